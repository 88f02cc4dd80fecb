// A method of one's own joins the list, and is compared with others on a swinging rope.
#include <taut/sim/options.h>
#include <taut/sim/run/method.h>
#include <taut/sim/study/speed_accuracy.h>

#include <cstdio>

using namespace taut;
/// Particles fall freely, and each follows the one before it at the link's length.
struct Follow final : Method {
  void advance(World& world, double until) override {
    const StepTimes times(world.time, until, 1e-3);
    for (std::uint64_t step = 0; step < times.count; ++step)
      for (Connector& rope : world.connectors)
        for (std::size_t i = 1; i < rope.particles(); ++i) {
          const Vec3 before = rope.position[i], up = rope.position[i - 1];
          const Vec3 free = before + times.dt * (rope.velocity[i] + times.dt * world.gravity);
          rope.position[i] = up + rope.rest[i - 1] * (free - up).normalized();
          rope.velocity[i] = (rope.position[i] - before) / times.dt;
        }
    place_held(world, until);
  }
};

int main() {
  add_method({.name = "follow",
              .make = [](const Settings&) { return std::unique_ptr<Method>(new Follow); }});
  Connector rope = straight_connector("rope", 1, 0.2, 21, Vec3::Zero(), Vec3::UnitX());
  rope.holds = {{.particle = 0, .to = {.point = Vec3::Zero()}}};
  const study::Problem problem{World{.connectors = {rope}}, study::frame_times(1.0, 60)};
  const study::Run exact =
      study::run(problem, {"direct", direct::settings({.tolerance = 1e-8})}, 60);
  const study::Metric metric = study::share_of_length(1);
  for (const MethodChoice& candidate : {MethodChoice{"follow", {}}, {"xpbd", {}}, {"direct", {}}}) {
    const auto row = study::score(problem, {exact.frames, 1.0, 1e-8}, {&metric, 1}, candidate, 60);
    std::printf("%-8s error %.1e of the length\n", candidate.name.c_str(), row.errors[0]);
  }
}
