// Moments up the tree, cells to the ranks that need them, and one walk down that does the rest.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/gravity_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "spall/base/require.hpp"
#include "spall/force/expansion.hpp"
#include "spall/force/octree.hpp"

namespace spall {
namespace {

/// What a rank tells the others of a cell: enough to decide whether they need more of it.
struct Outline {
  Box box;
  double largest_leaf = 0;  ///< radius
};

/// What of two cells decides whether they may attract each other by multipoles.
struct PairMeasure {
  double radii;             ///< sum
  double squared_distance;  ///< of the centres
  double weight;            ///< mass of one / acceleration of the other, summed over both ways
};

PairMeasure measure_pair(const Cell& a, const Cell& b) {
  return {a.radius + b.radius, (b.center - a.center).squaredNorm(),
          a.mass / b.pull + b.mass / a.pull};
}

/// Of two near cells the larger is opened; keys decide between equals.
bool is_larger(const Cell& a, const Cell& b) {
  return a.radius != b.radius ? a.radius > b.radius : a.key > b.key;
}

template <int P, bool rates>
class Walk {
 public:
  Walk(const Comm& comm, Octree& tree, double opening, double accuracy)
      : comm_(comm),
        tree_(tree),
        squared_opening_(opening * opening),
        squared_accuracy_(accuracy * accuracy),
        moments_(tree.cells.size()),
        outlines_(tree.cells.size()) {}

  void run() {
    measure_own_cells();
    share_top_cells();
    share_near_cells();
    outlines_ = {};
    if (tree_.cells[0].holder != Cell::Holder::elsewhere)
      descend(0, 0, LocalField<P>{}, tree_.cells[0].center, moments_[0].mean_velocity());
  }

 private:
  using Row = Moments<P>;

  /// Two cells attract each other by their multipoles: a symmetric decision, made alike wherever it
  /// is made, or momentum would be lost. The terms left out are about (mass / distance^2)
  /// (radii / distance)^P (Dehnen 2014, eq. 13) and have to be small against the acceleration of
  /// either.
  bool are_far(const PairMeasure& pair) const {
    const double q = pair.radii * pair.radii / pair.squared_distance;
    double power = 1;  // q^P
    for (int k = 0; k < P; ++k) power *= q;
    return q < squared_opening_ && pair.weight * pair.weight * power < squared_accuracy_ *
                                                                           pair.squared_distance *
                                                                           pair.squared_distance;
  }

  std::span<Eight> eights(const Cell& leaf) {
    std::vector<Eight>& held = leaf.holder == Cell::Holder::elsewhere ? others_ : tree_.eights;
    return {held.data() + leaf.first, static_cast<std::size_t>(leaf.count)};
  }

  /// Centre, radius and moments of a cell from its bodies or from its two halves.
  void measure(Index c) {
    if (tree_.cells[c].inner())
      measure_inner(c);
    else
      measure_leaf(c);
  }

  void measure_leaf(Index c) {
    Cell& cell = tree_.cells[c];
    Row& row = moments_[c];
    Outline& outline = outlines_[c];
    Vec3 place = Vec3::Zero(), momentum = Vec3::Zero();
    double mass = 0;
    for (const Eight& e : eights(cell)) {
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
    for (const Eight& e : eights(cell)) {
      const Lanes x = e.x - cell.center.x(), y = e.y - cell.center.y(), z = e.z - cell.center.z();
      const Lanes r2 = x * x + (y * y + z * z);
      for (std::size_t k = 0; k < lane_count; ++k) squared_radius = std::max(squared_radius, r2[k]);
    }
    measure_bodies<P, rates>(eights(cell), row);
    cell.radius = std::sqrt(squared_radius);
    outline.largest_leaf = cell.radius;
  }

  void measure_inner(Index c) {
    Cell& cell = tree_.cells[c];
    Row& row = moments_[c];
    Outline& outline = outlines_[c];
    Vec3 place = Vec3::Zero(), momentum = Vec3::Zero();
    double mass = 0;
    for (Index half : cell.children) {
      const double m = moments_[half].row[0];
      mass += m;
      place += m * tree_.cells[half].center;
      momentum += m * moments_[half].mean_velocity();
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
      const Cell& part = tree_.cells[half];
      reach = std::max(reach, (part.center - cell.center).norm() + part.radius);
      add_moments(row, moments_[half]);
    }
    cell.radius = std::min(reach, corner.norm());
    cell.pull = std::min(tree_.cells[cell.children[0]].pull, tree_.cells[cell.children[1]].pull);
    cell.key = tree_.cells[cell.children[0]].key;
    const auto holder = tree_.cells[cell.children[0]].holder;
    cell.holder = holder == tree_.cells[cell.children[1]].holder ? holder : Cell::Holder::both;
  }

  static void start_row(Row& row, double mass, const Vec3& center, const Vec3& velocity) {
    row.row[0] = mass;
    Vec3::Map(&row.row[1]) = center;
    Vec3::Map(&row.row[Row::velocity]) = velocity;
  }

  void measure_own_cells() {
    for (auto c = static_cast<Index>(tree_.cells.size()); c-- > tree_.top;) measure(c);
    for (Index c = 0; c < tree_.top; ++c)
      if (tree_.owner[c] == comm_.rank) measure(c);
  }

  /// All ranks learn the cells at which the curve is dealt out, and make those above them alike.
  void share_top_cells() {
    constexpr std::size_t width = Row::width + 11;
    std::vector<double> records;
    for (Index c = 0; c < tree_.top; ++c) {
      if (tree_.owner[c] != comm_.rank) continue;
      const Cell& cell = tree_.cells[c];
      const Outline& outline = outlines_[c];
      records.insert(records.end(), moments_[c].row.begin(), moments_[c].row.end());
      records.insert(records.end(), outline.box.low.begin(), outline.box.low.end());
      records.insert(records.end(), outline.box.high.begin(), outline.box.high.end());
      records.insert(records.end(), {outline.largest_leaf, cell.radius, cell.pull,
                                     std::bit_cast<double>(cell.key), static_cast<double>(c)});
    }
    records = comm_.all_gather(records);
    for (std::size_t at = 0; at < records.size(); at += width) {
      const double* r = records.data() + at;
      const auto c = static_cast<Index>(r[width - 1]);
      if (tree_.owner[c] == comm_.rank) continue;
      Cell& cell = tree_.cells[c];
      std::copy_n(r, Row::width, moments_[c].row.begin());
      r += Row::width;
      outlines_[c] = {{Vec3::Map(r), Vec3::Map(r + 3)}, r[6]};
      cell.center = moments_[c].center();
      cell.radius = r[7];
      cell.mass = moments_[c].row[0];
      cell.pull = r[8];
      cell.key = std::bit_cast<std::uint64_t>(r[9]);
      cell.holder = Cell::Holder::elsewhere;
    }
    for (Index c = tree_.top; c-- > 0;)
      if (tree_.owner[c] < 0) measure_inner(c);
  }

  /// Whether rank `rank` holds bodies of a top cell.
  bool has_part(Index top_cell, int rank) const {
    if (tree_.owner[top_cell] >= 0) return tree_.owner[top_cell] == rank;
    return std::ranges::any_of(tree_.cells[top_cell].children,
                               [&](Index half) { return has_part(half, rank); });
  }

  /// Whether `cell`, which is this rank's, may have to be opened for some cell of rank `rank` in
  /// `top_cell`. That may be the top cell itself, or one below it, of which bounds are known: only
  /// cells that are not larger than `cell`, and leaves, open it.
  bool is_needed(const Cell& cell, int rank, Index top_cell = 0) const {
    const Cell& by = tree_.cells[top_cell];
    const Outline& outline = outlines_[top_cell];
    constexpr double slack = 1 - 1e-12;  // for round-off
    if (are_far({cell.radius + std::max(cell.radius, outline.largest_leaf),
                 slack * outline.box.squared_distance(cell.center),
                 cell.mass / by.pull + by.mass / cell.pull}))
      return false;
    if (tree_.owner[top_cell] >= 0 || (!is_larger(by, cell) && !are_far(measure_pair(by, cell))))
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
    const Cell& cell = tree_.cells[c];
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
    const Cell& cell = tree_.cells[c];
    const Content content = *chosen++;
    message.push_back(static_cast<double>(content));
    if (content == Content::halves)
      for (Index half : cell.children) {
        const Cell& part = tree_.cells[half];
        message.insert(message.end(), moments_[half].row.begin(), moments_[half].row.end());
        message.insert(message.end(), {part.radius, part.pull, std::bit_cast<double>(part.key)});
        pack(half, chosen, message);
      }
    if (content == Content::bodies) {
      message.push_back(cell.count);
      for (const Eight& e : eights(cell))
        for (const Lanes* field : sent_fields(e))
          for (std::size_t k = 0; k < lane_count; ++k) message.push_back((*field)[k]);
    }
  }

  const double* unpack(Index c, const double* message) {
    const auto content = static_cast<Content>(*message++);
    if (content == Content::halves)
      for (int k = 0; k < 2; ++k) {
        const auto half = static_cast<Index>(tree_.cells.size());
        Cell& part = tree_.cells.emplace_back();
        Row& row = moments_.emplace_back();
        tree_.cells[c].children[k] = half;
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
      Cell& cell = tree_.cells[c];
      cell.first = static_cast<Index>(others_.size());
      cell.count = static_cast<Index>(*message++);
      for (Index n = 0; n < cell.count; ++n) {
        Eight& e = others_.emplace_back();
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
      for (Index c = 0; c < tree_.top; ++c)
        if (tree_.owner[c] == comm_.rank) f(c);
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
    std::size_t cells = tree_.cells.size(), others = 0;
    for (const auto& message : messages)
      if (!message.empty()) {
        cells += static_cast<std::size_t>(message[0]);
        others += static_cast<std::size_t>(message[1]);
      }
    tree_.cells.reserve(cells);
    moments_.reserve(cells);
    others_.reserve(others);
    for (int r = 0; r < comm_.size; ++r) {
      if (r == comm_.rank) continue;
      const double* message = messages[r].data() + 2;
      for (Index c = 0; c < tree_.top; ++c)
        if (tree_.owner[c] == r) message = unpack(c, message);
    }
  }

  /// Cell `c` feels all others: those in `stack_` from `begin` on were near its parent. Far ones
  /// act on it by multipoles, near ones are left to its halves or, in a leaf, act body by body.
  void descend(Index c, std::size_t begin, const LocalField<P>& parent, const Vec3& parent_center,
               const Vec3& parent_velocity) {
    const Cell cell = tree_.cells[c];
    const std::size_t end = stack_.size();
    far_.clear();
    for (std::size_t k = begin; k < end; ++k) sort_out(cell, stack_[k]);

    const Vec3 velocity = moments_[c].mean_velocity();
    LocalField<P> field =
        shifted(parent, cell.center - parent_center, (velocity - parent_velocity).norm());
    attract_by_far<P, rates>(far_, moments_[c], cell.radius, field);
    if (cell.inner()) {
      for (int k = 0; k < 2; ++k) {
        if (tree_.cells[cell.children[k]].holder == Cell::Holder::elsewhere) continue;
        stack_.push_back(cell.children[1 - k]);
        descend(cell.children[k], end, field, cell.center, velocity);
        stack_.pop_back();
      }
    } else {
      attract_by_near(c, end);
      attract_by_field<P, rates>(field, moments_[c], eights(cell));
    }
    stack_.resize(end);
  }

  /// Source `s` to the far ones, to the near ones at the end of the stack, or its halves in turn.
  void sort_out(const Cell& target, Index s) {
    const Cell& source = tree_.cells[s];
    if (are_far(measure_pair(target, source)))
      far_.push_back(&moments_[s]);
    else if (source.inner() && !(target.inner() && is_larger(target, source)))
      for (Index half : source.children) sort_out(target, half);
    else
      stack_.push_back(s);
  }

  /// Own leaves later on the curve are attracted in return, so that each pair is computed once.
  void attract_by_near(Index c, std::size_t begin) {
    const Cell leaf = tree_.cells[c];
    mutual_.clear();
    one_sided_.assign(1, eights(leaf));
    for (std::size_t k = begin; k < stack_.size(); ++k) {
      const Cell& source = tree_.cells[stack_[k]];
      require(source.first != Cell::none, "gravity tree: a cell that is needed was not sent");
      if (source.holder == Cell::Holder::elsewhere)
        one_sided_.push_back(eights(source));
      else if (source.first > leaf.first)
        mutual_.push_back(eights(source));
    }
    attract<false, rates>(eights(leaf), one_sided_);
    attract<true, rates>(eights(leaf), mutual_);
  }

  const Comm& comm_;
  Octree& tree_;
  double squared_opening_, squared_accuracy_;
  std::vector<Row> moments_;       // of every cell
  std::vector<Outline> outlines_;  // of own and top cells
  std::vector<Eight> others_;      // bodies of leaves that are elsewhere
  std::vector<Index> stack_;       // near cells of the cells on the way down
  std::vector<const Row*> far_;
  std::vector<std::span<Eight>> mutual_, one_sided_;
};

}  // namespace

TreeSettings tree_settings(double accuracy) {
  // Measured on homogeneous and clustered sets of 10^4 to 10^6 bodies: the rms error is 0.3 to 0.9
  // of `accuracy` (bench/results/gravity.md).
  TreeSettings settings;
  settings.order = accuracy > 3e-3 ? 4 : accuracy > 5e-5 ? 5 : 6;
  settings.accuracy = accuracy * (settings.order == 4 ? 1.5 : 2.4);
  return settings;
}

GravityField evaluate_gravity_tree(const Comm& comm, double constant, const TreeSettings& settings,
                                   std::span<const double> mass, std::span<const Vec3> position,
                                   std::span<const Vec3> velocity) {
  Octree tree = grow_octree(comm, mass, position, velocity, settings.leaf_size, settings.reach());
  if (tree.cells.empty()) return {};
  const bool rates = tree.rates;
  const auto walk = [&]<int P>(std::integral_constant<int, P>) {
    if (rates)
      Walk<P, true>(comm, tree, settings.opening, settings.accuracy).run();
    else
      Walk<P, false>(comm, tree, settings.opening, settings.accuracy).run();
  };
  switch (settings.order) {
    case 4:
      walk(std::integral_constant<int, 4>{});
      break;
    case 5:
      walk(std::integral_constant<int, 5>{});
      break;
    case 6:
      walk(std::integral_constant<int, 6>{});
      break;
    default:
      throw Error(fmt::format("gravity tree of order {}: 4, 5 and 6 exist", settings.order));
  }

  GravityField field;
  const double bound = 2 * (1 + 2 * estimate_error);  // see gravity_direct.cpp
  const std::vector<double> felt = tree.take_felt(comm);
  field.acceleration.resize(mass.size());
  field.potential.resize(mass.size());
  field.rate.resize(rates ? mass.size() : 0);
  for (std::size_t k = 0; k < mass.size(); ++k) {
    const double* row = felt.data() + k * felt_width(rates);
    const Index b = tree.went_row[k];
    field.acceleration[b] = constant * Vec3::Map(row);
    field.potential[b] = -constant * row[3];
    if (rates) field.rate[b] = constant * bound * row[4];
  }
  return field;
}

}  // namespace spall
