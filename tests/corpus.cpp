// Broken inputs of every reader: each is refused on all ranks with the message that corpus.txt
// wants. SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <filesystem>
#include <sstream>

#include "base/first_rank.hpp"
#include "described_hdf5.hpp"
#include "output/fclib.hpp"
#include "output/files.hpp"
#include "output/restart.hpp"
#include "run/run.hpp"
#include "solver/settings.hpp"
#include "testing.hpp"

namespace spall {
namespace {

using Files = std::vector<std::pair<std::string, std::string>>;  // name and content

/// A base, or one thing done to it.
struct Input {
  std::string reader = "";  ///< check, solve, resume
  Files files = {};         ///< the first is what is read
  std::vector<std::string> overrides = {};
  std::string message = "";  ///< how what is said begins; of a base: nothing is said
  std::int64_t line = 0;     ///< of corpus.txt
};

/// `base` with what a line says done to it.
Input changed(Input base, const std::string& line) {
  if (line.starts_with("--set ")) {
    base.overrides.push_back(line.substr(6));
    return base;
  }
  const std::size_t arrow = line.find(" ->");
  require(arrow != line.npos, "corpus.txt:{}: no change: {}", base.line, line);
  const std::string what = bytes_of(line.substr(0, arrow));
  const std::string by = bytes_of(line.substr(std::min(arrow + 4, line.size())));
  if (what == "end") {
    base.files[0].second += by;
    return base;
  }
  for (auto& [name, content] : base.files)
    if (const std::size_t at = content.find(what); at != content.npos) {
      content.replace(at, what.size(), by);
      return base;
    }
  throw Error(fmt::format("corpus.txt:{}: no file has {}", base.line, what));
}

std::vector<Input> read_corpus() {
  std::istringstream text(read_whole(CORPUS));
  std::vector<Input> inputs;
  Input base;
  bool changes = true;  // the head of the file is none of a base
  std::int64_t number = 0;
  for (std::string line; std::getline(text, line);) {
    ++number;
    if (line == "== changes") {
      inputs.push_back(base);
      changes = true;
    } else if (line.starts_with("== ")) {
      base = {.reader = line.substr(line.rfind(' ') + 1), .line = number};
      changes = false;
    } else if (!changes && line.starts_with("-- ")) {
      base.files.push_back({line.substr(3), ""});
    } else if (!changes) {
      base.files.back().second += line + "\n";
    } else if (line.starts_with("    ")) {
      inputs.back().message = line.substr(4);
    } else if (!line.empty() && line != "#" && !line.starts_with("# ")) {
      base.line = number;
      inputs.push_back(changed(base, line));
    }
  }
  return inputs;
}

void write_files(const std::string& folder, const Input& input) {
  std::filesystem::create_directories(folder);
  for (const auto& [name, content] : input.files) {
    if (name.ends_with(".h5"))
      write_hdf5(folder + "/" + name, content);
    else
      write_whole(folder + "/" + name, content);
  }
}

void read(const Comm& comm, const std::string& path, const Input& input) {
  if (input.reader == "check") {
    check_case(comm, read_case(path, input.overrides));
  } else if (input.reader == "solve") {
    const LocalProblem problem = read_fclib(path, comm);
    std::vector<Vec3> impulse(problem.q.size(), Vec3::Zero());
    solve(problem.view(), problem.rows, {.prox = 0}, impulse);
  } else {
    read_restart(comm, path);
  }
}

/// What is said, without the folder of this test; "not an Error" where it is none of Spall's own.
std::string complaint(const Comm& comm, const Input& input) {
  const std::string folder = fmt::format("corpus_{}/", comm.size);
  on_first_rank(comm, [&] {
    std::filesystem::remove_all(folder);
    write_files(folder, input);
  });
  std::string said;
  try {
    said = complaint_of([&] { read(comm, folder + input.files[0].first, input); });
  } catch (const std::exception& error) {
    said = std::string("not an Error: ") + error.what();
  }
  comm.any(false);  // rank 0 will write the next
  for (std::size_t at; (at = said.find(folder)) != said.npos;) said.erase(at, folder.size());
  return said;
}

TEST(Corpus, each_broken_input_is_refused_with_its_message_and_each_base_is_not) {
  const Comm comm = testing_world();
  const std::vector<Input> inputs = read_corpus();
  for (const Input& input : inputs) {
    const std::string said = complaint(comm, input);
    const bool is_base = &input == &inputs.front() || input.message.empty();
    EXPECT_TRUE(is_base ? said.empty() : said.starts_with(input.message))
        << "corpus.txt:" << input.line << ": " << said << "\n  instead of\n"
        << input.message;
    EXPECT_EQ(std::ranges::count(said, '\n'), 0) << said;
    EXPECT_LT(said.size(), 700u) << said;
  }
  EXPECT_GE(inputs.size(), 300u);
}

/// For corpus.sh, which reads them by the program: folders with an input each, and what is said.
TEST(Corpus, some_of_it_lies_ready_for_the_program) {
  const Comm comm = testing_world();
  if (comm.size > 1) return;
  std::vector<Input> inputs = read_corpus();
  std::erase_if(inputs, [](const Input& input) { return input.message.empty(); });
  constexpr std::size_t wanted = 30;
  std::string list;
  std::filesystem::remove_all("corpus");
  for (std::size_t k = 0; k < wanted; ++k) {
    const Input& input = inputs[k * inputs.size() / wanted];
    write_files(fmt::format("corpus/{}", k), input);
    list += fmt::format("{}|{}|{}|{}|{}\n", k, input.reader, input.files[0].first,
                        fmt::join(input.overrides, ""), input.message);
  }
  write_whole("corpus/list", list);
}

}  // namespace
}  // namespace spall
