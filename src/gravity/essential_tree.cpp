// Every rank measures its own cells, learns the top cells of all, and sends what others must open.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/essential_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "gravity/expansion.hpp"

namespace spall {
namespace {

/// What a rank tells the others of a cell: enough to decide whether they need more of it.
struct Outline {
  Box box;
  double largest_leaf = 0;  ///< radius
};

template <int P, bool rates>
class Completion {
 public:
  Completion(const Comm& comm, EssentialTree<P>& tree)
      : comm_(comm), tree_(tree), octree_(tree.octree), outlines_(octree_.cells.size()) {}

  void run() {
    measure_own_cells();
    share_top_cells();
    share_near_cells();
  }

 private:
  using Row = Moments<P>;

  /// Centre, radius and moments of a cell from its bodies or from its two halves.
  void measure(Index c) {
    if (octree_.cells[c].inner())
      measure_inner(c);
    else
      measure_leaf(c);
  }

  void measure_leaf(Index c) {
    Cell& cell = octree_.cells[c];
    Row& row = tree_.moments[c];
    Outline& outline = outlines_[c];
    Vec3 place = Vec3::Zero(), momentum = Vec3::Zero();
    double mass = 0;
    for (const Eight& e : tree_.eights(cell)) {
      mass += sum_of_lanes(e.mass);
      place +=
          Vec3(sum_of_lanes(e.mass * e.x), sum_of_lanes(e.mass * e.y), sum_of_lanes(e.mass * e.z));
      momentum += Vec3(sum_of_lanes(e.mass * e.vx), sum_of_lanes(e.mass * e.vy),
                       sum_of_lanes(e.mass * e.vz));
      for (std::size_t k = 0; k < lane_count; ++k) {
        const Vec3 x(e.x[k], e.y[k], e.z[k]);
        outline.box.low = outline.box.low.cwiseMin(x);
        outline.box.high = outline.box.high.cwiseMax(x);
      }
    }
    cell.center = mass > 0 ? Vec3(place / mass) : Vec3((outline.box.low + outline.box.high) / 2);
    cell.mass = mass;
    start_row(row, mass, cell.center, mass > 0 ? Vec3(momentum / mass) : Vec3(Vec3::Zero()));
    double squared_radius = 0;
    for (const Eight& e : tree_.eights(cell)) {
      const Lanes x = e.x - cell.center.x(), y = e.y - cell.center.y(), z = e.z - cell.center.z();
      const Lanes r2 = x * x + (y * y + z * z);
      for (std::size_t k = 0; k < lane_count; ++k) squared_radius = std::max(squared_radius, r2[k]);
    }
    measure_bodies<P, rates>(tree_.eights(cell), row);
    cell.radius = std::sqrt(squared_radius);
    outline.largest_leaf = cell.radius;
  }

  void measure_inner(Index c) {
    Cell& cell = octree_.cells[c];
    Row& row = tree_.moments[c];
    Outline& outline = outlines_[c];
    Vec3 place = Vec3::Zero(), momentum = Vec3::Zero();
    double mass = 0;
    for (Index half : cell.children) {
      const double m = tree_.moments[half].row[0];
      mass += m;
      place += m * octree_.cells[half].center;
      momentum += m * tree_.moments[half].mean_velocity();
      const Outline& part = outlines_[half];
      outline.box.low = outline.box.low.cwiseMin(part.box.low);
      outline.box.high = outline.box.high.cwiseMax(part.box.high);
      outline.largest_leaf = std::max(outline.largest_leaf, part.largest_leaf);
    }
    cell.center = mass > 0 ? Vec3(place / mass) : Vec3((outline.box.low + outline.box.high) / 2);
    cell.mass = mass;
    start_row(row, mass, cell.center, mass > 0 ? Vec3(momentum / mass) : Vec3(Vec3::Zero()));
    // Two bounds of the distance of the farthest body: by the halves' spheres and by the box.
    const Vec3 corner = (cell.center - outline.box.low).cwiseMax(outline.box.high - cell.center);
    double reach = 0;
    for (Index half : cell.children) {
      const Cell& part = octree_.cells[half];
      reach = std::max(reach, (part.center - cell.center).norm() + part.radius);
      add_moments(row, tree_.moments[half]);
    }
    cell.radius = std::min(reach, corner.norm());
    cell.pull =
        std::min(octree_.cells[cell.children[0]].pull, octree_.cells[cell.children[1]].pull);
    cell.key = octree_.cells[cell.children[0]].key;
    const auto holder = octree_.cells[cell.children[0]].holder;
    cell.holder = holder == octree_.cells[cell.children[1]].holder ? holder : Cell::Holder::both;
  }

  static void start_row(Row& row, double mass, const Vec3& center, const Vec3& velocity) {
    row.row[0] = mass;
    Vec3::Map(&row.row[1]) = center;
    Vec3::Map(&row.row[Row::velocity]) = velocity;
  }

  void measure_own_cells() {
    for (auto c = static_cast<Index>(octree_.cells.size()); c-- > octree_.top;) measure(c);
    for (Index c = 0; c < octree_.top; ++c)
      if (octree_.owner[c] == comm_.rank) measure(c);
  }

  /// All ranks learn the cells at which the curve is dealt out, and make those above them alike.
  void share_top_cells() {
    constexpr std::size_t width = Row::width + 11;
    std::vector<double> records;
    for (Index c = 0; c < octree_.top; ++c) {
      if (octree_.owner[c] != comm_.rank) continue;
      const Cell& cell = octree_.cells[c];
      const Outline& outline = outlines_[c];
      records.insert(records.end(), tree_.moments[c].row.begin(), tree_.moments[c].row.end());
      records.insert(records.end(), outline.box.low.begin(), outline.box.low.end());
      records.insert(records.end(), outline.box.high.begin(), outline.box.high.end());
      records.insert(records.end(), {outline.largest_leaf, cell.radius, cell.pull,
                                     std::bit_cast<double>(cell.key), static_cast<double>(c)});
    }
    records = comm_.all_gather(records);
    for (std::size_t at = 0; at < records.size(); at += width) {
      const double* r = records.data() + at;
      const auto c = static_cast<Index>(r[width - 1]);
      if (octree_.owner[c] == comm_.rank) continue;
      Cell& cell = octree_.cells[c];
      std::copy_n(r, Row::width, tree_.moments[c].row.begin());
      r += Row::width;
      outlines_[c] = {{Vec3::Map(r), Vec3::Map(r + 3)}, r[6]};
      cell.center = tree_.moments[c].center();
      cell.radius = r[7];
      cell.mass = tree_.moments[c].row[0];
      cell.pull = r[8];
      cell.key = std::bit_cast<std::uint64_t>(r[9]);
      cell.holder = Cell::Holder::elsewhere;
    }
    for (Index c = octree_.top; c-- > 0;)
      if (octree_.owner[c] < 0) measure_inner(c);
  }

  /// Whether rank `rank` holds bodies of a top cell.
  bool has_part(Index top_cell, int rank) const {
    if (octree_.owner[top_cell] >= 0) return octree_.owner[top_cell] == rank;
    return std::ranges::any_of(octree_.cells[top_cell].children,
                               [&](Index half) { return has_part(half, rank); });
  }

  /// Whether `cell`, which is this rank's, may have to be opened for some cell of rank `rank` in
  /// `top_cell`. That may be the top cell itself, or one below it, of which bounds are known:
  /// only cells that are not larger than `cell`, and leaves, open it.
  bool is_needed(const Cell& cell, int rank, Index top_cell = 0) const {
    const Cell& by = octree_.cells[top_cell];
    const Outline& outline = outlines_[top_cell];
    constexpr double slack = 1 - 1e-12;  // for round-off
    if (tree_.are_far({cell.radius + std::max(cell.radius, outline.largest_leaf),
                       slack * outline.box.squared_distance(cell.center),
                       cell.mass / by.pull + by.mass / cell.pull}))
      return false;
    if (octree_.owner[top_cell] >= 0 ||
        (!is_larger(by, cell) && !tree_.are_far(measure_pair(by, cell))))
      return has_part(top_cell, rank);
    return std::ranges::any_of(by.children,
                               [&](Index half) { return is_needed(cell, rank, half); });
  }

  enum class Content : char { closed, halves, bodies };

  /// What a message holds, so that memory is taken once.
  struct Contents {
    std::vector<Content> of_cells;  // in the order of the descent
    std::size_t halves = 0, eights = 0;
  };

  /// What `rank` needs to know about the inside of cell `c`.
  void choose(Index c, int rank, Contents& chosen) const {
    const Cell& cell = octree_.cells[c];
    const Content content = !is_needed(cell, rank) ? Content::closed
                            : cell.inner()         ? Content::halves
                                                   : Content::bodies;
    chosen.of_cells.push_back(content);
    if (content == Content::bodies) chosen.eights += cell.count;
    if (content == Content::halves) {
      chosen.halves += 2;
      for (Index half : cell.children) choose(half, rank, chosen);
    }
  }

  /// Appends it.
  void pack(Index c, const Content*& chosen, std::vector<double>& message) {
    const Cell& cell = octree_.cells[c];
    const Content content = *chosen++;
    message.push_back(static_cast<double>(content));
    if (content == Content::halves)
      for (Index half : cell.children) {
        const Cell& part = octree_.cells[half];
        message.insert(message.end(), tree_.moments[half].row.begin(),
                       tree_.moments[half].row.end());
        message.insert(message.end(), {part.radius, part.pull, std::bit_cast<double>(part.key)});
        pack(half, chosen, message);
      }
    if (content == Content::bodies) {
      message.push_back(cell.count);
      for (const Eight& e : tree_.eights(cell))
        for (const Lanes* field : sent_fields(e))
          for (std::size_t k = 0; k < lane_count; ++k) message.push_back((*field)[k]);
    }
  }

  const double* unpack(Index c, const double* message) {
    const auto content = static_cast<Content>(*message++);
    if (content == Content::halves)
      for (int k = 0; k < 2; ++k) {
        const auto half = static_cast<Index>(octree_.cells.size());
        Cell& part = octree_.cells.emplace_back();
        Row& row = tree_.moments.emplace_back();
        octree_.cells[c].children[k] = half;
        std::copy_n(message, Row::width, row.row.begin());
        message += Row::width;
        part.center = row.center();
        part.radius = *message++;
        part.pull = *message++;
        part.mass = row.row[0];
        part.key = std::bit_cast<std::uint64_t>(*message++);
        part.holder = Cell::Holder::elsewhere;
        message = unpack(half, message);
      }
    if (content == Content::bodies) {
      Cell& cell = octree_.cells[c];
      cell.first = static_cast<Index>(tree_.others.size());
      cell.count = static_cast<Index>(*message++);
      for (Index n = 0; n < cell.count; ++n) {
        Eight& e = tree_.others.emplace_back();
        for (Lanes* field : sent_fields(e))
          for (std::size_t k = 0; k < lane_count; ++k) (*field)[k] = *message++;
      }
    }
    return message;
  }

  /// Lanes of bodies that other ranks are told.
  template <class E>
  static auto sent_fields(E& e) {
    if constexpr (rates)
      return std::array{&e.x, &e.y, &e.z, &e.mass, &e.vx, &e.vy, &e.vz};
    else
      return std::array{&e.x, &e.y, &e.z, &e.mass};
  }

  /// How many cells and eights come, then what is inside of this rank's top cells.
  std::vector<double> message_to(int rank) {
    Contents chosen;
    const auto for_each_top = [&](auto&& f) {
      for (Index c = 0; c < octree_.top; ++c)
        if (octree_.owner[c] == comm_.rank) f(c);
    };
    for_each_top([&](Index c) { choose(c, rank, chosen); });
    std::vector<double> message;
    constexpr std::size_t lanes_sent =
        std::tuple_size_v<decltype(sent_fields(std::declval<Eight&>()))>;
    message.reserve(2 + 2 * chosen.of_cells.size() + chosen.halves * (Row::width + 3) +
                    chosen.eights * lanes_sent * lane_count);
    message.push_back(static_cast<double>(chosen.halves));
    message.push_back(static_cast<double>(chosen.eights));
    const Content* next = chosen.of_cells.data();
    for_each_top([&](Index c) { pack(c, next, message); });
    return message;
  }

  void share_near_cells() {
    if (comm_.size == 1) return;
    std::vector<std::vector<double>> messages(comm_.size);
    for (int r = 0; r < comm_.size; ++r)
      if (r != comm_.rank) messages[r] = message_to(r);
    messages = comm_.exchange(messages);
    std::size_t cells = octree_.cells.size(), others = 0;
    for (const auto& message : messages)
      if (!message.empty()) {
        cells += static_cast<std::size_t>(message[0]);
        others += static_cast<std::size_t>(message[1]);
      }
    octree_.cells.reserve(cells);
    tree_.moments.reserve(cells);
    tree_.others.reserve(others);
    for (int r = 0; r < comm_.size; ++r) {
      if (r == comm_.rank) continue;
      const double* message = messages[r].data() + 2;
      for (Index c = 0; c < octree_.top; ++c)
        if (octree_.owner[c] == r) message = unpack(c, message);
    }
  }

  const Comm& comm_;
  EssentialTree<P>& tree_;
  Octree& octree_;
  std::vector<Outline> outlines_;  // of own and top cells
};

}  // namespace

template <int P>
EssentialTree<P>::EssentialTree(const Comm& comm, Octree grown, const TreeSettings& settings)
    : octree(std::move(grown)),
      squared_opening(settings.opening * settings.opening),
      squared_accuracy(settings.accuracy * settings.accuracy),
      moments(octree.cells.size()) {
  if (octree.rates)
    Completion<P, true>(comm, *this).run();
  else
    Completion<P, false>(comm, *this).run();
}

template struct EssentialTree<4>;
template struct EssentialTree<5>;
template struct EssentialTree<6>;

}  // namespace spall
