// One HDF5 file of all ranks: rows as they are distributed, under one seal.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/restart.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "base/first_rank.hpp"
#include "output/files.hpp"
#include "output/h5.hpp"
#include "output/seal.hpp"
#include "spall/error.hpp"

namespace spall {

namespace {

constexpr int format_version = 12;

std::string place_of(const FieldInfo& info) {
  return std::string("/bodies/") + info.name;
}

std::string place_of_contacts(const char* field) {
  return std::string("/contacts/") + field;
}

/// One text each: they may hold any sign, also the ends of lines.
std::string change_place(const char* list, std::size_t k) {
  return fmt::format("/case/{}/{}", list, k);
}

/// `f(list, changes)` for both lists of changes of the case.
template <class State, class F>
void for_each_list(State& state, F&& f) {
  f("overrides", state.overrides);
  f("constants", state.constants);
}

/// `f(name, field)` for every field that all contacts have.
template <class Memory, class F>
void for_each_contact_field(Memory& contacts, F&& f) {
  f("i", contacts.i);
  f("j", contacts.j);
  f("impulse", contacts.impulse);
}

/// `f(name, field, blank)` for those that are left out where no contact has one; `blank` is what
/// others have then.
template <class Memory, class F>
void for_each_rare_contact_field(Memory& contacts, F&& f) {
  f("rolling", contacts.rolling, Vec3(Vec3::Zero()));
  f("spheres", contacts.spheres, std::array<std::int32_t, 2>{});
}

/// The clock as two short arrays.
std::array<std::int64_t, 3> counts(const Clock& clock) {
  return {clock.step, clock.phase, clock.step_in_phase};
}
std::array<double, 3> times(const Clock& clock) {
  return {clock.time, clock.time_in_phase, clock.since_impact};
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const auto& line : lines) text += line + "\n";
  return text;
}

/// This rank's rows, from the number of rows on every rank that wrote.
h5::Rows rows_to_read(const Comm& comm, const std::vector<std::int64_t>& written) {
  h5::Rows rows;
  for (std::int64_t count : written) {
    require(count >= 0, "a rank has written {} rows", count);
    rows.total += count;
  }
  if (static_cast<int>(written.size()) != comm.size)
    return h5::equal_rows(comm.rank, comm.size, rows.total);
  for (int r = 0; r < comm.rank; ++r) rows.begin += written[r];
  rows.count = written[comm.rank];
  return rows;
}

/// The bonds of a rank's bodies stand together, in the order of the bodies.
void write_bonds(h5::File& file, const Comm& comm, const Bonds& bonds, Index bodies) {
  std::vector<std::int32_t> counts;
  for (Index b = 0; b < bodies; ++b) counts.push_back(bonds.count(b));
  file.write<std::int32_t>("/bonds/count", counts, h5::rows_in_rank_order(comm, bodies));
  file.write<BodyId>("/bonds/other", bonds.other,
                     h5::rows_in_rank_order(comm, std::ssize(bonds.other)));
}

std::optional<Bonds> read_bonds(const h5::File& file, const Comm& comm, Index bodies) {
  if (!file.exists("/bonds")) return {};
  const auto counts = file.read<std::int32_t>("/bonds/count", h5::rows_in_rank_order(comm, bodies));
  Bonds bonds;
  const bool negative = std::ranges::any_of(counts, [](std::int32_t count) { return count < 0; });
  require(!comm.any(negative), "a body has less than no bonds");
  for (std::int32_t count : counts) bonds.start.push_back(bonds.start.back() + count);
  bonds.other = file.read<BodyId>("/bonds/other", h5::rows_in_rank_order(comm, bonds.start.back()));
  return bonds;
}

/// A small array that is the same on all ranks.
template <class T>
std::vector<T> read_few(const h5::File& file, const std::string& name, std::size_t count) {
  return file.read<T>(name, {0, count, count});
}

RestartState read_state(const Comm& comm, const std::string& path) {
  check_seal(comm, path);
  const auto file = h5::File::open(path, comm);
  const auto version = read_few<std::int32_t>(file, "/format", 1)[0];
  require(version == format_version, "its format is {}, not {}", version, format_version);
  RestartState state;
  state.case_file = file.read_text("/case/file");
  state.case_text = file.read_text("/case/text");
  for_each_list(state, [&](const char* list, std::vector<std::string>& changes) {
    for (std::string name = change_place(list, 0); file.exists(name);
         name = change_place(list, changes.size()))
      changes.push_back(file.read_text(name));
  });
  const auto count = read_few<std::int64_t>(file, "/clock/counts", 3);
  const auto time = read_few<double>(file, "/clock/times", 3);
  state.clock = {count[0], count[1], count[2], time[0], time[1], time[2]};
  const auto names = complete_lines(file.read_text("/scalars/names"));
  const auto values = read_few<double>(file, "/scalars/values", names.size());
  for (std::size_t k = 0; k < names.size(); ++k) state.scalars[names[k]] = values[k];

  auto rows = rows_to_read(comm, file.read<std::int64_t>("/layout/bodies"));
  state.bodies.owned = static_cast<Index>(rows.count);
  state.bodies.fields = {};
  for (const FieldInfo& info : field_table)
    if (file.exists(place_of(info))) state.bodies.fields |= {info.field};
  for_each_field(state.bodies, [&]<class T>(const TypedField<T>& info, auto& field) {
    if (info.is(trait::restarted)) field = file.read<T>(place_of(info), rows);
  });
  fill_fields(state.bodies);
  rows = rows_to_read(comm, file.read<std::int64_t>("/layout/contacts"));
  ContactMemory contacts;
  for_each_contact_field(contacts, [&]<class T>(const char* name, std::vector<T>& field) {
    field = file.read<T>(place_of_contacts(name), rows);
  });
  for_each_rare_contact_field(
      contacts, [&]<class T>(const char* name, std::vector<T>& field, const T&) {
        if (const std::string place = place_of_contacts(name); file.exists(place))
          field = file.read<T>(place, rows);
      });
  state.contacts = std::move(contacts);
  state.bonds = read_bonds(file, comm, state.bodies.owned);
  return state;
}

}  // namespace

double find_scalar(const Scalars& scalars, const std::string& name) {
  const auto found = scalars.find(name);
  require(found != scalars.end(), "the restart file has no '{}'", name);
  return found->second;
}

void write_restart(const Comm& comm, const std::string& path, const RestartState& state) {
  auto file = h5::File::create(unfinished(path), comm, seal_size);
  file.write<std::int32_t>("/format", std::array{format_version});
  file.write_text("/version", SPALL_VERSION);
  file.write_text("/case/file", state.case_file);
  file.write_text("/case/text", state.case_text);
  for_each_list(state, [&](const char* list, const std::vector<std::string>& changes) {
    for (std::size_t k = 0; k < changes.size(); ++k)
      file.write_text(change_place(list, k), changes[k]);
  });
  file.write<std::int64_t>("/clock/counts", counts(state.clock));
  file.write<double>("/clock/times", times(state.clock));
  file.write<Vec3>("/periodic/size", std::array{state.period});
  std::vector<std::string> names;
  std::vector<double> values;
  for (const auto& [name, value] : state.scalars) {
    names.push_back(name);
    values.push_back(value);
  }
  file.write_text("/scalars/names", joined(names));
  file.write<double>("/scalars/values", values);

  const auto layout = [&](const std::string& name, std::int64_t count) {
    file.write<std::int64_t>(name, comm.all_gather(std::span<const std::int64_t>(&count, 1)));
    return h5::rows_in_rank_order(comm, count);
  };
  auto rows = layout("/layout/bodies", state.bodies.owned);
  for_each_field(state.bodies, [&]<class T>(const TypedField<T>& info, const auto& field) {
    if (!info.is(trait::restarted)) return;
    file.write<T>(place_of(info), std::span(field).first(state.bodies.owned), rows);
    if (*info.unit) file.attribute(place_of(info), "unit", info.unit);
  });
  rows = layout("/layout/contacts", std::ssize(state.contacts->i));
  for_each_contact_field(*state.contacts,
                         [&]<class T>(const char* name, const std::vector<T>& field) {
                           file.write<T>(place_of_contacts(name), field, rows);
                         });
  for_each_rare_contact_field(
      *state.contacts, [&]<class T>(const char* name, const std::vector<T>& field, const T& blank) {
        if (!comm.any(!field.empty())) return;
        std::vector<T> all = field;
        all.resize(rows.count, blank);
        file.write<T>(place_of_contacts(name), all, rows);
      });
  if (state.bonds) write_bonds(file, comm, *state.bonds, state.bodies.owned);
  file.close();
  check_mpi(MPI_Barrier(comm.raw), "MPI_Barrier");  // every rank has closed the file
  seal(comm, unfinished(path));
  on_first_rank(comm, [&] {
    if (!std::filesystem::exists(path)) return;
    std::error_code none;  // a file system without links keeps one generation
    std::filesystem::remove(former_restart(path), none);
    std::filesystem::create_hard_link(path, former_restart(path), none);
  });
  put_in_place(comm, path, Outlives::power);
}

void remove_unless_whole(const Comm& comm, const std::string& path) {
  if (!comm.any(std::filesystem::exists(path))) return;
  try {
    check_seal(comm, path);
  } catch (const Error&) {
    on_first_rank(comm, [&] { std::filesystem::remove(path); });
  }
}

std::string former_restart(const std::string& path) {
  const std::filesystem::path file(path);
  return (file.parent_path() / (file.stem().string() + "_before.h5")).string();
}

RestartState read_restart(const Comm& comm, const std::string& path) {
  require(std::filesystem::exists(path), "no restart file '{}'", path);
  try {
    return read_state(comm, path);
  } catch (const std::exception& error) {
    const std::string former = former_restart(path);
    throw Error(fmt::format(
        "'{}' is not a whole restart file: {}{}", path, error.what(),
        std::filesystem::exists(former) ? fmt::format("; the one before is '{}'", former) : ""));
  }
}

}  // namespace spall
