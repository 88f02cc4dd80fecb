// A rope swings from the horizontal. Prints where its free end is, sixty times a second.
#include <taut/sim/options.h>
#include <taut/sim/run/simulation.h>

#include <cstdio>

int main() {
  using namespace taut;
  World world;  // 1 m, 0.2 kg, 21 particles, from the origin along x
  world.connectors = {straight_connector("rope", 1.0, 0.2, 21, Vec3::Zero(), Vec3::UnitX())};
  world.connectors[0].holds = {{.particle = 0, .to = {.point = Vec3::Zero()}}};

  Simulation simulation(world, make_method(direct::Options{.tolerance = 1e-4}));
  std::puts("t,x,y,z");
  for (int frame = 0; frame <= 60; ++frame) {
    simulation.advance_to(frame / 60.0);
    const Vec3 end = simulation.state().connectors[0].back();
    std::printf("%.4f,%.6f,%.6f,%.6f\n", frame / 60.0, end.x(), end.y(), end.z());
  }
}
