// A rope with a weight swings; its middle is held where it is for half a second, and let go again.
#include <taut/sim/measure/measure.h>
#include <taut/sim/options.h>
#include <taut/sim/run/simulation.h>

#include <cstdio>

namespace {

void show(const char* what, const taut::Simulation& simulation) {
  const taut::Connector& rope = simulation.world().connectors[0];
  std::printf("%-14s t = %.2f s, end at (%.3f, %.3f), stretch %.1e\n", what,
              simulation.world().time, rope.position.back().x(), rope.position.back().y(),
              taut::stretch_max(simulation.world()));
}

}  // namespace

int main() {
  using namespace taut;
  World world;
  world.connectors = {straight_connector("rope", 1.0, 0.1, 21, Vec3::Zero(), Vec3::UnitX())};
  world.connectors[0].holds = {{.particle = 0, .to = {.point = Vec3::Zero()}}};
  world.connectors[0].particle_mass.back() += 0.2;  // kg

  Simulation simulation(world, make_method(direct::Options{.tolerance = 1e-4}));
  simulation.advance_to(0.4);
  const Pinned pinned = simulation.interventions().pin(simulation.world(), 0, 0.5);
  if (pinned.outcome != Outcome::done) return 1;
  show("pinned", simulation);
  simulation.advance_to(0.9);
  const Outcome released = simulation.interventions().release(simulation.world(), pinned.pin);
  show("released", simulation);
  simulation.advance_to(2.0);
  show("swinging", simulation);
  return released == Outcome::done ? 0 : 1;
}
