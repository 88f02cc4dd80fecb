#include "tests/physics/character/routine.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut {
namespace {

constexpr std::size_t kHeld = 0, kFree = 1;  // bodies, in the order of the scene file
constexpr double kBetween = 1.0 / 960;       // s, where the method chooses its steps

Instance instance(const World& world) {
  const Body &held = world.bodies[kHeld], &free = world.bodies[kFree];
  const Connector& chain = world.connectors[0];
  const Vec3 end = chain.holds[1].to.point;
  return {world.time,
          held.path->at(world.time),
          held.point(held.grip),
          held.point(chain.holds[0].to.point),
          free.point(end),
          free.point(-end),
          free.position,
          free.velocity};
}

}  // namespace

Routine Routine::play(const std::string& file, bool with_stage, const Settings& settings) {
  Routine routine;
  routine.scene = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/" + file, with_stage);
  const scenes::Scene& scene = routine.scene;
  Settings all = scene.method.settings;
  for (const auto& [key, value] : settings) all[key] = value;
  routine.step = all.contains("step") ? number(all, "step") : kBetween;
  Simulation simulation(scene.world, make_method(scene.method.name, all));
  routine.mass = scene.world.bodies[kFree].mass_properties.mass;
  for (const double rest : scene.world.connectors[0].rest) routine.length += rest;
  const auto steps = static_cast<int>(std::lround(scene.duration / routine.step));
  for (int k = 1; k <= steps; ++k) {
    simulation.advance_to(k * routine.step);
    routine.steps.push_back(instance(simulation.world()));
    const std::vector<Event>& events = simulation.method().events();
    routine.events.insert(routine.events.end(), events.begin(), events.end());
  }
  return routine;
}

const Routine& Routine::shipped() {
  static const Routine routine = play("nunchaku.toml", true);
  return routine;
}

const Routine& Routine::paper() {
  static const Routine routine = play("nunchaku_paper.toml", true);
  return routine;
}

const scenes::Caption& Routine::caption(std::string_view beginning) const {
  for (const scenes::Caption& caption : scene.stage->captions)
    if (caption.text.starts_with(beginning)) return caption;
  throw std::out_of_range("no caption begins with " + std::string(beginning));
}

std::vector<Instance> Routine::between(double from, double until) const {
  std::vector<Instance> found;
  for (const Instance& i : steps)
    if (i.time >= from && i.time <= until) found.push_back(i);
  return found;
}

double Routine::rest(const scenes::Caption& caption) const {
  for (const Instance& i : between(caption.from, caption.until))
    if (i.hand.velocity.norm() < 1e-9) return i.time;
  throw std::out_of_range("the hand does not come to rest in " + caption.text);
}

}  // namespace taut
