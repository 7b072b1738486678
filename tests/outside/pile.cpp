// A program outside the tree: builds a pile, steps it, reads positions.
#include <cstdio>
#include <spall/spall.hpp>

int main() {
  spall::Session session;
  spall::Scene scene = spall::Scene::from_text(R"(
[materials.rock]
density = "2000 kg/m^3"
[contact]
friction = 0.5
[gravity]
uniform = [0, 0, -9.81]
[[planes]]
[[phases]]
name = "fall"
step = "1 ms"
duration = "1 s"
)");
  for (int k = 0; k < 10; ++k)
    scene.add({.material = "rock", .radius = 0.1, .position = {0.05 * (k % 2), 0, 0.1 + 0.21 * k}});
  spall::Simulation simulation(session.world(), scene);
  simulation.run_until(0.5);
  const spall::Bodies& bodies = simulation.bodies();
  for (int b = 0; b < bodies.owned; ++b)
    std::printf("%d %.4f\n", static_cast<int>(bodies.id[b]), bodies.position[b].z());
  const double kinetic = simulation.energies().kinetic;  // collective
  std::printf("%.3g J\n", kinetic);
}
