// Every rank measures its own cells, and asks others for what its cells have to open.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/essential_tree.hpp"

#include <map>
#include <utility>

#include "gravity/askers.hpp"

namespace spall {
namespace {

template <int P>
class Completion {
 public:
  Completion(const Comm& comm, EssentialTree<P>& tree)
      : comm_(comm), tree_(tree), measures_(tree), tops_(tree, measures_) {}

  void run() {
    measures_.measure_own_cells();
    unopened_ = tops_.climb(comm_);
    const Askers askers = askers_of(tree_, measures_, tops_, tree_.octree.parts[0].roots);
    keep_needed(askers);
    // A cell that is left to the next round is known to a smaller block.
    for (int level = block_levels(comm_.size); level-- > 0;) ask(askers);
  }

  /// What each of the ranks `sample` would send, where this one has the parts of all.
  std::vector<Traffic> foretell(std::span<const int> sample) {
    measures_.measure_own_cells();
    const auto ranks = static_cast<int>(tree_.octree.parts.size());
    std::vector<Traffic> sent(ranks);
    tops_.climb_for_all(sent);
    std::vector<bool> in_sample(ranks);
    for (int rank : sample) in_sample[rank] = true;
    for (int rank = 0; rank < ranks; ++rank) foretell_asking(rank, in_sample, sent);
    std::vector<Traffic> of_sample;
    for (int rank : sample) of_sample.push_back(sent[rank]);
    for (Traffic& traffic : of_sample) traffic.collectives = 3 * block_levels(ranks);
    return of_sample;
  }

 private:
  void keep_needed(const Askers& askers) {
    std::erase_if(unopened_, [&](Index c) {
      return askers.empty() || !is_opened(tree_, tree_.octree.cells[c], askers);
    });
  }

  /// The unopened cells by whom `rank` asks for their inside.
  std::map<int, std::vector<Index>> take_unopened(int rank) {
    std::map<int, std::vector<Index>> asked;
    for (Index c : std::exchange(unopened_, {}))
      asked[tops_[c].known_to.partner_of(rank)].push_back(c);
    return asked;
  }

  /// Asks for the inside of unopened cells. What those asked do not know is unopened afterwards.
  void ask(const Askers& askers) {
    const auto asked = take_unopened(comm_.rank);
    ByRank<double> questions, answers;
    for (const auto& [rank, cells] : asked) questions[rank] = question(cells, askers);
    for (const auto& [rank, row] : comm_.exchange(std::move(questions)))
      answers[rank] = answer(row, comm_.rank);
    unopened_.clear();  // other ranks'
    answers = comm_.exchange(std::move(answers));
    std::size_t cells = tree_.octree.cells.size(), others = tree_.others.size();
    for (const auto& [rank, row] : answers) {
      cells += static_cast<std::size_t>(row[0]);
      others += static_cast<std::size_t>(row[1]);
    }
    tree_.octree.cells.reserve(cells);
    tree_.moments.reserve(cells);
    tree_.others.reserve(others);
    for (const auto& [rank, row] : answers) {
      RowReader reader(row.data() + 2);
      for (Index c : asked.at(rank)) read(reader, c);
    }
  }

  /// The questions of `rank` and the answers to them. An answer about a single rank's cells leaves
  /// nothing open: it is not made where nobody wants to know its length.
  void foretell_asking(int rank, const std::vector<bool>& in_sample, std::vector<Traffic>& sent) {
    const auto& roots = tree_.octree.parts[rank].roots;
    const Askers askers = askers_of(tree_, measures_, tops_, roots);
    unopened_ = tops_.unknown_to(rank);
    keep_needed(askers);
    const auto send = [&](int from, const std::vector<double>& row) {
      ++sent[from].messages;
      sent[from].bytes += static_cast<std::int64_t>(sizeof(double) * row.size());
    };
    while (!unopened_.empty())
      for (auto& [partner, cells] : take_unopened(rank)) {
        if (!in_sample[rank] && !in_sample[partner])
          std::erase_if(cells, [&](Index c) { return tops_[c].known_to.count == 1; });
        if (cells.empty()) continue;
        const std::vector<double> row = question(cells, askers);
        send(rank, row);
        send(partner, answer(row, partner));
      }
  }

  std::vector<double> question(std::span<const Index> cells, const Askers& askers) const {
    std::vector<double> row{static_cast<double>(cells.size())};
    for (Index c : cells) tops_.append_name(c, row);
    append_askers(askers_for(tree_, cells, askers), row);
    return row;
  }

  /// How many cells and eights it holds, then what is inside of the cells that were asked for.
  std::vector<double> answer(const std::vector<double>& question, int rank) {
    RowReader reader(question.data());
    std::vector<Index> cells(reader.index());
    for (Index& c : cells) c = tops_.find(reader);
    const Askers askers = read_askers(reader);
    std::vector<double> row(2);
    for (Index c : cells) tell(c, rank, false, askers, row);
    return row;
  }

  enum class Content : char { closed, elsewhere, halves, bodies };

  /// What is inside of cell `c`, as far as `rank` knows and the askers may need it. `owned`: inside
  /// of a cell that only this rank has bodies in.
  void tell(Index c, int rank, bool owned, const Askers& askers, std::vector<double>& row) {
    const Cell& cell = tree_.octree.cells[c];
    const auto begin = [&](Content content) { row.push_back(static_cast<double>(content)); };
    if (!is_opened(tree_, cell, askers)) return begin(Content::closed);
    if (!owned && !tops_[c].known_to.has(rank)) {
      begin(Content::elsewhere);
      tops_.append_top(c, row);
      unopened_.push_back(c);
      return;
    }
    owned = owned || tops_[c].known_to.count == 1;
    if (cell.inner()) {
      begin(Content::halves);
      for (Index half : cell.children) {
        append_cell(tree_, half, row);
        ++row[0];
        tell(half, rank, owned, askers, row);
      }
    } else {
      begin(Content::bodies);
      row.push_back(cell.count);
      row[1] += cell.count;
      for (const Eight& e : tree_.eights(cell))
        for (Lanes Eight::*field : sent_fields())
          for (std::size_t k = 0; k < lane_count; ++k) row.push_back((e.*field)[k]);
    }
  }

  /// What was told of cell `c`.
  void read(RowReader& row, Index c) {
    const auto content = static_cast<Content>(row.index());
    if (content == Content::elsewhere) {
      tops_.read_top(row, c);
      unopened_.push_back(c);
    }
    if (content == Content::halves)
      for (int k = 0; k < 2; ++k) {
        const Index half = read_cell(row, tree_);
        tree_.octree.cells[c].children[k] = half;
        read(row, half);
      }
    if (content == Content::bodies) {
      Cell& cell = tree_.octree.cells[c];
      cell.first = static_cast<Index>(tree_.others.size());
      cell.count = row.index();
      for (Index n = 0; n < cell.count; ++n) {
        Eight& e = tree_.others.emplace_back();
        for (Lanes Eight::*field : sent_fields())
          for (std::size_t k = 0; k < lane_count; ++k) (e.*field)[k] = row.number();
      }
    }
  }

  /// Lanes of bodies that other ranks are told.
  std::span<Lanes Eight::*const> sent_fields() const {
    static constexpr std::array all{&Eight::x,  &Eight::y,  &Eight::z, &Eight::mass,
                                    &Eight::vx, &Eight::vy, &Eight::vz};
    return std::span(all).first(body_width(tree_.octree.rates));
  }

  const Comm& comm_;
  EssentialTree<P>& tree_;
  CellMeasures<P> measures_;
  TopCells<P> tops_;
  std::vector<Index> unopened_;  // cells of which more is needed than is known
};

}  // namespace

template <int P>
EssentialTree<P>::EssentialTree(Octree grown, const TreeSettings& settings)
    : octree(std::move(grown)),
      squared_opening(settings.opening * settings.opening),
      squared_accuracy(settings.accuracy * settings.accuracy),
      moments(octree.cells.size()) {}

template <int P>
EssentialTree<P>::EssentialTree(const Comm& comm, Octree grown, const TreeSettings& settings)
    : EssentialTree(std::move(grown), settings) {
  Completion<P>(comm, *this).run();
}

template <int P>
std::vector<Traffic> foretell_messages(const Comm& alone, Octree grown,
                                       const TreeSettings& settings, std::span<const int> sample) {
  EssentialTree<P> tree(std::move(grown), settings);
  return Completion<P>(alone, tree).foretell(sample);
}

template struct EssentialTree<4>;
template struct EssentialTree<6>;
template struct EssentialTree<8>;
template std::vector<Traffic> foretell_messages<4>(const Comm&, Octree, const TreeSettings&,
                                                   std::span<const int>);
template std::vector<Traffic> foretell_messages<6>(const Comm&, Octree, const TreeSettings&,
                                                   std::span<const int>);
template std::vector<Traffic> foretell_messages<8>(const Comm&, Octree, const TreeSettings&,
                                                   std::span<const int>);

}  // namespace spall
