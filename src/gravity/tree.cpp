// One walk down the tree: what is far acts by multipoles on whole cells, what is near body by body.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/kernels.hpp"
#include "base/let_go.hpp"
#include "gravity/essential_tree.hpp"
#include "gravity/expansion.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

template <int P>
class Walk {
 public:
  explicit Walk(EssentialTree<P>& tree) : tree_(tree) {}

  void run() {
    const Index root = tree_.octree.root;
    const Cell& cell = tree_.octree.cells[root];
    if (cell.holder != Cell::Holder::elsewhere)
      descend(root, 0, LocalField<P>{}, cell.center, tree_.moments[root].mean_velocity());
  }

 private:
  /// Cell `c` feels all others: those in `stack_` from `begin` on were near its parent. Far ones
  /// act on it by multipoles, near ones are left to its halves or, in a leaf, act body by body.
  void descend(Index c, std::size_t begin, const LocalField<P>& parent, const Vec3& parent_center,
               const Vec3& parent_velocity) {
    const Cell cell = tree_.octree.cells[c];
    const std::size_t end = stack_.size();
    far_.clear();
    for (std::size_t k = begin; k < end; ++k) sort_out(cell, stack_[k]);

    const Vec3 velocity = tree_.moments[c].mean_velocity();
    LocalField<P> field =
        shifted(parent, cell.center - parent_center, (velocity - parent_velocity).norm());
    attract_by_far<P>(far_, tree_.moments[c], cell.radius, tree_.octree.rates, field);
    if (cell.inner()) {
      for (int k = 0; k < 2; ++k) {
        if (tree_.octree.cells[cell.children[k]].holder == Cell::Holder::elsewhere) continue;
        stack_.push_back(cell.children[1 - k]);
        descend(cell.children[k], end, field, cell.center, velocity);
        stack_.pop_back();
      }
    } else {
      attract_by_near(c, end);
      attract_by_field(field, tree_.moments[c], tree_.octree.rates, tree_.eights(cell));
    }
    stack_.resize(end);
  }

  /// Source `s` to the far ones, to the near ones at the end of the stack, or its halves in turn.
  void sort_out(const Cell& target, Index s) {
    const Cell& source = tree_.octree.cells[s];
    if (tree_.are_far(measure_pair(target, source)))
      far_.push_back(&tree_.moments[s]);
    else if (source.inner() && !(target.inner() && is_larger(target, source)))
      for (Index half : source.children) sort_out(target, half);
    else
      stack_.push_back(s);
  }

  /// Own leaves later on the curve are attracted in return, so that each pair is computed once.
  void attract_by_near(Index c, std::size_t begin) {
    const Cell leaf = tree_.octree.cells[c];
    mutual_.clear();
    one_sided_.assign(1, tree_.eights(leaf));
    for (std::size_t k = begin; k < stack_.size(); ++k) {
      const Cell& source = tree_.octree.cells[stack_[k]];
      require(source.first != Cell::none, "gravity tree: a cell that is needed was not sent");
      if (source.holder == Cell::Holder::elsewhere)
        one_sided_.push_back(tree_.eights(source));
      else if (source.first > leaf.first)
        mutual_.push_back(tree_.eights(source));
    }
    if (tree_.octree.rates) {
      attract<false, true>(tree_.eights(leaf), one_sided_);
      attract<true, true>(tree_.eights(leaf), mutual_);
    } else {
      attract<false, false>(tree_.eights(leaf), one_sided_);
      attract<true, false>(tree_.eights(leaf), mutual_);
    }
  }

  EssentialTree<P>& tree_;
  std::vector<Index> stack_;  // near cells of the cells on the way down
  std::vector<const Moments<P>*> far_;
  std::vector<std::span<Eight>> mutual_, one_sided_;
};

template <int P>
GravityField evaluate(const Comm& comm, double constant, const TreeSettings& settings,
                      Octree octree) {
  EssentialTree<P> tree(comm, std::move(octree), settings);
  const bool rates = tree.octree.rates;
  Walk<P>(tree).run();
  let_go(tree.moments, tree.others);

  const std::vector<double> felt = tree.octree.take_felt(comm);
  const std::vector<Index>& rows = tree.octree.went_row;
  GravityField field;
  field.acceleration.resize(rows.size());
  field.potential.resize(rows.size());
  field.rate.resize(rates ? rows.size() : 0);
  const double bound = 2 * (1 + 2 * estimate_error);  // see direct.cpp
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double* row = felt.data() + k * felt_width(rates);
    field.acceleration[rows[k]] = constant * Vec3::Map(row);
    field.potential[rows[k]] = -constant * row[3];
    if (rates) field.rate[rows[k]] = constant * bound * row[4];
  }
  return field;
}

/// Calls `f` with the order as a compile-time constant.
template <class F>
auto with_order(int order, F&& f) {
  switch (order) {
    case 4:
      return f(std::integral_constant<int, 4>());
    case 6:
      return f(std::integral_constant<int, 6>());
    case 8:
      return f(std::integral_constant<int, 8>());
  }
  throw Error(fmt::format("gravity tree of order {}: 4, 6 and 8 exist", order));
}

}  // namespace

TreeSettings tree_settings(double accuracy) {
  // The errors of the pairs that act on a body add up as random numbers do, and there are some
  // theta^-3 of them, with theta^P the error of one. The factor is measured: the rms error is 0.3
  // to 0.9 of `accuracy` on homogeneous and clustered sets (bench/results/gravity.md).
  TreeSettings settings;
  settings.order = accuracy > 2e-3 ? 4 : accuracy > 2e-5 ? 6 : 8;
  settings.accuracy = 0.75 * (settings.order + 4) * std::pow(accuracy, 1 + 1.5 / settings.order);
  return settings;
}

SPALL_KERNEL(GravityField, evaluate_gravity_tree,
             (const Comm& comm, double constant, const TreeSettings& settings,
              std::span<const double> mass, std::span<const Vec3> position,
              std::span<const Vec3> velocity),
             (comm, constant, settings, mass, position, velocity)) {
  Octree octree = grow_octree(comm, mass, position, velocity, settings.leaf_size, settings.reach());
  if (octree.parts.empty()) return {};  // no bodies on any rank
  return with_order(settings.order, [&](auto order) {
    return evaluate<order()>(comm, constant, settings, std::move(octree));
  });
}

SPALL_KERNEL(std::vector<TreeShare>, foretell_gravity_tree,
             (const Comm& alone, const TreeSettings& settings, std::span<const double> mass,
              std::span<const Vec3> position, std::span<const Vec3> velocity,
              std::span<const int> owner, int ranks, std::span<const int> sample),
             (alone, settings, mass, position, velocity, owner, ranks, sample)) {
  const Traffic before = std::exchange(traffic(), {});
  PlannedRanks planned{{owner.begin(), owner.end()}, std::vector<Traffic>(ranks)};
  Octree octree =
      grow_octree(alone, mass, position, velocity, settings.leaf_size, settings.reach(), &planned);
  const bool rates = octree.rates;
  // Bodies go from their owners to those of the curve, and what they feel goes back.
  std::vector<std::map<int, std::int64_t>> to(ranks), from(ranks);
  std::vector<TreeShare> shares(sample.size());
  std::vector<std::int64_t> held(ranks);
  for (std::size_t k = 0; const auto& [holder, bodies] : octree.went) {
    held[holder] += static_cast<std::int64_t>(bodies);
    for (const std::size_t end = k + bodies; k < end; ++k) {
      const int rank = owner[octree.went_row[k]];
      if (rank == holder) continue;
      ++to[rank][holder];
      ++from[holder][rank];
    }
  }
  const std::vector<Traffic> told = with_order(settings.order, [&](auto order) {
    return foretell_messages<order()>(alone, std::move(octree), settings, sample);
  });
  Traffic of_all = std::exchange(traffic(), before);
  for (std::size_t k = 0; k < sample.size(); ++k) {
    const int rank = sample[k];
    Traffic& own = shares[k].traffic = of_all;
    own.add(told[k]);
    own.add(planned.sent[rank]);
    own.messages += std::ssize(to[rank]) + std::ssize(from[rank]);
    const auto add_rows = [&](const std::map<int, std::int64_t>& others, std::size_t width) {
      for (const auto& [other, rows] : others)
        own.bytes += rows * static_cast<std::int64_t>(width * sizeof(double));
    };
    add_rows(to[rank], body_width(rates));
    add_rows(from[rank], felt_width(rates));
    shares[k].bodies = held[rank];
  }
  return shares;
}

}  // namespace spall
