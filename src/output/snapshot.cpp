// Bodies to blocks of ids, blocks to one file by all ranks, files to one trajectory.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/snapshot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <type_traits>

#include "base/first_rank.hpp"
#include "base/let_go.hpp"
#include "output/files.hpp"
#include "output/h5.hpp"
#include "scene/scene.hpp"
#include "spall/error.hpp"
#include "state/pack.hpp"

namespace spall {

namespace {

constexpr unsigned in_snapshots = trait::written | trait::fixed;

/// Beside the fields of the bodies.
constexpr FieldInfo temperature_info{
    Field::heat, "temperature", "K",
    "of a solid that had 298 K before it took up its heat; nan of what is held", trait::written};

/// Where the values of a field stand; what is fixed stands once, by H5MD's rules.
std::string dataset(const FieldInfo& info) {
  return std::string("/particles/all/") + info.name + (info.is(trait::fixed) ? "" : "/value");
}

/// Fields of all ranks in order of id, of which this rank gets an equal part. One field at a time:
/// whole bodies on their way would take more than all else that a run holds.
class InOrderOfId {
 public:
  InOrderOfId(const Comm& comm, const Bodies& bodies, const h5::Rows& rows)
      : comm_(comm), count_(rows.count) {
    std::vector<hsize_t> end(comm.size);
    for (int r = 0; r < comm.size; ++r) end[r] = h5::equal_rows(r, comm.size, rows.total).end();
    for (Index b = 0; b < bodies.owned; ++b) {
      const auto id = static_cast<hsize_t>(bodies.id[b]);
      require(id < rows.total, "body id {} in a set of {} bodies: ids must be 0 … N-1",
              bodies.id[b], rows.total);
      const auto part = std::upper_bound(end.begin(), end.end(), id) - end.begin();
      rank_of_.push_back(static_cast<int>(part));
      ++leaving_[rank_of_.back()];
    }
    const auto came = exchange(bodies.id);
    const auto first = static_cast<BodyId>(rows.begin);
    std::vector<bool> has(rows.count);
    for (BodyId id : came) {
      place_.push_back(static_cast<Index>(id - first));
      has[place_.back()] = true;
    }
    const auto lost = std::ranges::find(has, false) - has.begin();
    require(lost == std::ssize(has), "no body has id {}: ids must be 0 … N-1", first + lost);
  }

  /// Collective.
  template <class T>
  std::vector<T> operator()(const std::vector<T>& values) const {
    const std::vector<T> came = exchange(values);
    std::vector<T> ordered(came.size());
    for (std::size_t k = 0; k < came.size(); ++k) ordered[place_[k]] = came[k];
    return ordered;
  }

 private:
  /// What came to this rank, in the order of the ranks.
  template <class T>
  std::vector<T> exchange(const std::vector<T>& values) const {
    constexpr std::size_t width = packed_width<T>;
    ByRank<double> outgoing;
    for (const auto& [rank, count] : leaving_) outgoing[rank].reserve(width * count);
    for (std::size_t b = 0; b < rank_of_.size(); ++b) pack_value(values[b], outgoing[rank_of_[b]]);
    std::vector<T> came;
    came.reserve(count_);
    auto incoming = comm_.exchange(std::move(outgoing));
    for (auto& [rank, rows] : incoming) {
      for (std::size_t at = 0; at < rows.size(); at += width)
        came.push_back(unpack_value<T>(&rows[at]));
      let_go(rows);
    }
    return came;
  }

  const Comm& comm_;
  std::size_t count_;                   // of bodies in this rank's part
  std::vector<int> rank_of_;            // whose part has each owned body
  std::map<int, std::size_t> leaving_;  // how many for each rank
  std::vector<Index> place_;            // in the part, of what comes
};

/// `step` and `time` of one field; later fields link to the first's.
void write_frames(h5::File& file, const std::string& field, std::string& first,
                  std::span<const std::int64_t> steps, std::span<const double> times) {
  const std::string group = "/particles/all/" + field;
  if (first.empty()) {
    file.write(group + "/step", steps);
    file.write(group + "/time", times);
    file.attribute(group + "/time", "unit", "s");
    first = group;
  } else {
    file.link(first + "/step", group + "/step");
    file.link(first + "/time", group + "/time");
  }
}

/// Names of groups and materials; then come the impactor and what a program has added, of which a
/// run that goes on knows by the lack of groups alone.
FieldNames names_of(const Case& scene) {
  FieldNames names;
  const auto add = [&](Field field, std::string name) {
    auto& before = names[static_cast<int>(field)];
    while (std::ranges::find(before, name) != before.end()) name += "'";
    before.push_back(name);
  };
  for (const Group& group : scene.groups) add(Field::group, group.name);
  for (const Material& material : scene.materials) add(Field::material, material.name);
  for (const BodyShape& shape : scene.shapes) add(Field::shape, shape.name);
  const bool added = !scene.spheres.empty() || scene.groups.empty();
  if (added || std::ranges::any_of(scene.phases, &Phase::has_impactor))
    add(Field::group, "impactor");
  if (added) add(Field::group, "spheres");
  return names;
}

/// `species` is what H5MD calls the material.
void describe(h5::File& file, const FieldInfo& info) {
  if (*info.unit) file.attribute(dataset(info), "unit", info.unit);
  if (info.field == Field::material) file.link(dataset(info), "/particles/all/species");
}

}  // namespace

std::string describe_output_fields() {
  std::string text = "\nFields of bodies in snapshots and trajectories (H5MD)\n";
  const auto add = [&](const FieldInfo& info) {
    text += fmt::format("{:<23}{:<15}{:<12}{}\n", info.name, info.unit,
                        info.is(trait::always) ? "always" : "if needed", info.meaning);
  };
  for (const FieldInfo& info : field_table)
    if (info.is(in_snapshots)) add(info);
  add(temperature_info);
  return text;
}

SnapshotWriter::SnapshotWriter(Comm comm, std::string folder, const Case& scene,
                               Provenance provenance, std::int64_t kept)
    : comm_(comm),
      folder_(std::move(folder)),
      provenance_(std::move(provenance)),
      materials_(scene.materials),
      names_(names_of(scene)),
      shapes_(scene.shapes),
      period_(scene.period),
      gravity_(scene.gravity),
      map_(scene.gravity_map),
      fields_(fields_of(scene)) {
  make_folder(comm_, folder_ + "/snapshots");
  find_written(kept);
}

void SnapshotWriter::write_metadata(h5::File& file) const {
  h5::write_h5md(file);
  const std::string box = "/particles/all/box";
  std::vector<std::string> boundary;
  for (double size : period_.size) boundary.emplace_back(size > 0 ? "periodic" : "none");
  file.group(box);
  file.attribute(box, "dimension", 3);
  file.attribute(box, "boundary", boundary);
  // Zero along what does not repeat. The lower corner, which H5MD leaves out, stands beside.
  const auto write_corner = [&](const std::string& name, const Vec3& corner) {
    file.write<double>(name, {corner.data(), 3});
    file.attribute(name, "unit", "m");
  };
  if (period_.any()) write_corner(box + "/edges", period_.size);
  if (period_.any()) write_corner(box + "/offset", period_.low);
  for (const BodyShape& shape : shapes_) {
    const std::string group = "/parameters/shapes/" + shape.name + "/";
    std::vector<Vec3> centers;
    std::vector<double> radii;
    for (const ShapeSphere& sphere : shape.spheres) {
      centers.push_back(sphere.at);
      radii.push_back(sphere.radius);
    }
    file.write<Vec3>(group + "centers", centers);
    file.write<double>(group + "radii", radii);
    file.write<double>(group + "volume", std::array{shape.volume});
    file.write<double>(group + "inertia", {shape.inertia.data(), 3});
  }
  for (const auto& [key, value] : provenance_) {
    const std::string name = "/parameters/" + key;
    if (const auto* number = std::get_if<std::int64_t>(&value))
      file.write<std::int64_t>(name, {number, 1});
    else
      file.write_text(name, std::get<std::string>(value));
  }
}

void SnapshotWriter::find_written(std::int64_t kept) {
  namespace fs = std::filesystem;
  std::vector<double> found;  // step, time, rows of each, on rank 0
  on_first_rank(comm_, [&] {
    std::set<fs::path> files;
    for (const auto& entry : fs::directory_iterator(folder_ + "/snapshots"))
      if (is_snapshot(entry.path())) files.insert(entry.path());
    for (std::int64_t k = 0; k < kept && !files.empty(); ++k) {
      const std::string path = folder_ + "/" + snapshot_name(k);
      require(fs::exists(path),
              "'{}' is lost, one of {} snapshots before the step from which the run goes on: move "
              "the others away to resume",
              path, kept);
      const auto file = h5::File::open(path);
      const auto one = [&]<class T>(T, const char* name) {
        return file.read<T>(std::string("/particles/all/") + name, {0, 1, 1}).at(0);
      };
      found.push_back(static_cast<double>(one(std::int64_t{}, "position/step")));
      found.push_back(one(double{}, "position/time"));
      found.push_back(static_cast<double>(file.total_rows("/particles/all/radius")));
    }
    for (std::size_t k = 0; k < found.size() / 3; ++k)
      files.erase(fs::path(folder_) / snapshot_name(k));
    others_.assign(files.begin(), files.end());
  });
  found = comm_.all_gather(found);  // only rank 0 has any
  for (std::size_t k = 0; k < found.size(); k += 3)
    written_.push_back({static_cast<std::int64_t>(found[k]), found[k + 1],
                        static_cast<std::int64_t>(found[k + 2])});
}

void SnapshotWriter::begin() {
  on_first_rank(comm_, [&] {
    for (const auto& path : others_) std::filesystem::remove(path);
  });
}

template <class F>
void SnapshotWriter::for_each_output(const Bodies& bodies, F&& f) const {
  for_each_field(bodies, [&](const FieldInfo& info, const auto& values) {
    if (info.is(in_snapshots)) f(info, values);
  });
  const auto warms = [](const Material& m) { return m.solid && m.solid->specific_heat > 0; };
  if (!bodies.has(Field::heat) || std::none_of(materials_.begin(), materials_.end(), warms)) return;
  std::vector<double> temperatures;
  for (Index b = 0; b < bodies.owned; ++b) {
    const Material& material = materials_[bodies.material[b]];
    temperatures.push_back(warms(material) && std::isfinite(bodies.mass[b])
                               ? temperature(*material.solid, bodies.heat[b] / bodies.mass[b])
                               : std::nan(""));
  }
  f(temperature_info, temperatures);
}

void SnapshotWriter::write(const Bodies& bodies, std::int64_t step, double time) {
  const auto rows =
      h5::equal_rows(comm_.rank, comm_.size, comm_.sum(static_cast<std::int64_t>(bodies.owned)));
  const InOrderOfId in_order(comm_, bodies, rows);
  fields_ = bodies.fields;

  const std::string path = folder_ + "/" + snapshot_name(written_.size());
  auto file = h5::File::create(unfinished(path), comm_);
  write_metadata(file);
  std::string first;
  for_each_output(bodies, [&]<class T>(const FieldInfo& info, const std::vector<T>& values) {
    const bool fixed = info.is(trait::fixed);
    file.write<T>(dataset(info), in_order(values), rows, !fixed,
                  names_[static_cast<int>(info.field)]);
    describe(file, info);
    if (!fixed) write_frames(file, info.name, first, std::array{step}, std::array{time});
  });
  if (map_) write_gravity(file, bodies);
  file.close();
  put_in_place(comm_, path);

  written_.push_back({step, time, static_cast<std::int64_t>(rows.total)});
  // The index names all snapshots: written for each of them it would cost the square of their
  // number, written for each twentieth part more it costs as much as they do.
  if (written_.size() - indexed_ > written_.size() / 20) write_index();
}

void SnapshotWriter::write_gravity(h5::File& file, const Bodies& bodies) const {
  const GravityMap map = map_gravity(comm_, gravity_, bodies, *map_);
  const auto rows = h5::equal_rows(comm_.rank, comm_.size, static_cast<hsize_t>(map_->total()));
  const std::string group = "/fields/gravity/";
  file.write<std::int64_t>(group + "counts", map_->counts);
  file.write<Vec3>(group + "low", std::array{map_->low});
  file.write<double>(group + "spacing", std::array{map_->spacing});
  file.write<double>(group + "potential", map.potential, rows);
  file.attribute(group + "potential", "unit", "J kg-1");
  file.write<Vec3>(group + "acceleration", map.acceleration, rows);
  file.attribute(group + "acceleration", "unit", "m s-2");
}

void SnapshotWriter::write_index() {
  if (indexed_ == written_.size()) return;
  indexed_ = written_.size();
  if (comm_.rank != 0) return;
  write_trajectory();
  write_xdmf();
}

void SnapshotWriter::write_trajectory() const {
  std::vector<std::int64_t> steps;
  std::vector<double> times;
  hsize_t most = 0;
  for (const Written& one : written_) {
    steps.push_back(one.step);
    times.push_back(one.time);
    most = std::max(most, static_cast<hsize_t>(one.rows));
  }
  const std::string path = folder_ + "/trajectory.h5";
  auto file = h5::File::create(unfinished(path));
  write_metadata(file);
  std::string first;
  Bodies none;
  none.fields = fields_;
  for_each_output(none, [&](const FieldInfo& info, const auto& values) {
    using Value = typename std::decay_t<decltype(values)>::value_type;
    const bool fixed = info.is(trait::fixed);
    std::vector<h5::Source> sources;
    for (std::size_t k = fixed ? written_.size() - 1 : 0; k < written_.size(); ++k)
      sources.push_back({snapshot_name(k), static_cast<hsize_t>(written_[k].rows)});
    file.write_view<Value>(dataset(info), sources, most, !fixed,
                           names_[static_cast<int>(info.field)]);
    describe(file, info);
    if (!fixed) write_frames(file, info.name, first, steps, times);
  });
  file.link_outside("series.h5", "/observables", "/observables");
  file.close();
  put_in_place(path);
}

void SnapshotWriter::write_xdmf() const {
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<Xdmf Version=\"3.0\">\n<Domain>\n"
      "<Grid Name=\"bodies\" GridType=\"Collection\" CollectionType=\"Temporal\">\n");
  for (std::size_t k = 0; k < written_.size(); ++k) {
    const auto rows = written_[k].rows;
    text += fmt::format(
        "<Grid Name=\"bodies\" GridType=\"Uniform\">\n  <Time Value=\"{}\"/>\n"
        "  <Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\"/>\n",
        written_[k].time, rows);
    Bodies none;
    none.fields = fields_;
    for_each_output(none, [&](const FieldInfo& info, const auto& values) {
      using Value = typename std::decay_t<decltype(values)>::value_type;
      if constexpr (std::is_same_v<Value, Quaternion>) return;  // XDMF knows none
      constexpr bool is_vector = std::is_same_v<Value, Vec3>;
      const bool fixed = info.is(trait::fixed);
      const bool is_place = info.field == Field::position;
      text += is_place
                  ? "  <Geometry GeometryType=\"XYZ\">"
                  : fmt::format("  <Attribute Name=\"{}\" Center=\"Node\" AttributeType=\"{}\">",
                                info.name, is_vector ? "Vector" : "Scalar");
      text += fmt::format(
          "<DataItem Format=\"HDF\" NumberType=\"{}\" Precision=\"{}\" Dimensions=\"{}{}{}\">"
          "{}:{}</DataItem>{}\n",
          std::is_integral_v<Value> ? "Int" : "Float", sizeof(Value) / (is_vector ? 3 : 1),
          fixed ? "" : "1 ", rows, is_vector ? " 3" : "", snapshot_name(k), dataset(info),
          is_place ? "</Geometry>" : "</Attribute>");
    });
    text += "</Grid>\n";
  }
  text += "</Grid>\n</Domain>\n</Xdmf>\n";
  write_whole(folder_ + "/trajectory.xdmf", text);
}

}  // namespace spall
