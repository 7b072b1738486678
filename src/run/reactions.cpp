// Impulses add up from the start; a mean is a difference over its time.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/reactions.hpp"

#include "scene/read_walls.hpp"

namespace spall {
namespace {

constexpr std::size_t components = 6;  // of an obstacle: impulse, then moment about its point

}  // namespace

ReactionRows::ReactionRows(const Case& scene) {
  const Walls walls = scene.walls();
  for (std::size_t w = 0; w < walls.size(); ++w)
    obstacles_.push_back({walls.name(w), walls.point(w), true, w});
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    if (group.held())
      obstacles_.push_back({column_name(group.name),
                            group.motion ? group.motion->point : group.volume.center, false, g});
  }
  received_.assign(components * obstacles_.size(), 0);
}

std::vector<Column> ReactionRows::columns() const {
  std::vector<Column> columns;
  for (const Obstacle& obstacle : obstacles_)
    for (const auto& [what, unit] : {std::pair("force", "N"), std::pair("torque", "N m")})
      for (char k : {'x', 'y', 'z'})
        columns.push_back({fmt::format("{}_{}_{}", obstacle.name, what, k), unit});
  return columns;
}

std::vector<double> ReactionRows::received(const World& world) const {
  std::vector<double> values;
  for (const Obstacle& obstacle : obstacles_) {
    const auto& all = obstacle.is_wall ? world.reactions.of_walls : world.reactions.of_groups;
    const Reaction own = obstacle.number < all.size() ? all[obstacle.number] : Reaction{};
    const Vec3 moment = own.moment - obstacle.point.cross(own.impulse);
    values.insert(values.end(), own.impulse.data(), own.impulse.data() + 3);
    values.insert(values.end(), moment.data(), moment.data() + 3);
  }
  return values;
}

std::vector<double> ReactionRows::row(double time, const std::vector<double>& received) {
  std::vector<double> values(received.size(), 0);
  if (time_ >= 0 && time > time_)
    for (std::size_t k = 0; k < values.size(); ++k)
      values[k] = (received[k] - received_[k]) / (time - time_);
  time_ = time;
  received_ = received;
  return values;
}

template <class F>
void ReactionRows::for_each_scalar(F&& f) {
  if (obstacles_.empty()) return;
  f("reactions.time", time_);
  for (std::size_t k = 0; k < received_.size(); ++k)
    f(fmt::format("reactions.{}.{}", obstacles_[k / components].name, k % components),
      received_[k]);
}
void ReactionRows::save(Scalars& scalars) const {
  ReactionRows copy = *this;
  copy.for_each_scalar([&](const std::string& name, double value) { scalars[name] = value; });
}
void ReactionRows::load(const Scalars& scalars) {
  for_each_scalar(
      [&](const std::string& name, double& value) { value = find_scalar(scalars, name); });
}

}  // namespace spall
