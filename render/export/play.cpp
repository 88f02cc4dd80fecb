#include <optional>
#include <utility>

#include "render/export/frame_writer.h"
#include "scenes/scene/exposure.h"
#include "sim/run/shown_velocities.h"

namespace taut::exporting {
namespace {

/// The states of a simulation between two frames, by another simulation that stops more often. A
/// method that chooses its steps goes another way with such stops: so the other one begins at every
/// frame in the simulation's state, and its difference at the next is taken back evenly.
class Between {
 public:
  explicit Between(const scenes::Scene& scene) : simulation_(start(scene)) {
    simulation_.advance_to(std::as_const(simulation_).world().time);  // what happens at the start
  }

  /// The states at `times`, of a simulation that was at `first` and is at `last` now.
  std::vector<Snapshot> states(const World& first, const std::vector<double>& times,
                               const Snapshot& last) {
    simulation_.go_on_from(first);
    std::vector<Snapshot> states;
    for (const double time : times) {
      simulation_.advance_to(time);
      states.push_back(simulation_.state());
    }
    simulation_.advance_to(last.time);
    const Snapshot end = simulation_.state();
    for (Snapshot& state : states)
      take_back(end, last, (state.time - first.time) / (last.time - first.time), state);
    return states;
  }

 private:
  static void take_back(const Snapshot& end, const Snapshot& last, double share, Snapshot& state) {
    for (std::size_t c = 0; c < state.connectors.size(); ++c)
      for (std::size_t i = 0; i < state.connectors[c].size(); ++i)
        state.connectors[c][i] += share * (last.connectors[c][i] - end.connectors[c][i]);
    for (std::size_t b = 0; b < state.bodies.size(); ++b) {
      Pose& pose = state.bodies[b];
      pose.position += share * (last.bodies[b].position - end.bodies[b].position);
      const Quat off = last.bodies[b].rotation * end.bodies[b].rotation.conjugate();
      pose.rotation = (Quat::Identity().slerp(share, off) * pose.rotation).normalized();
    }
  }

  Simulation simulation_;
};

/// Times between frame `frame` and the next at which a method of equal steps stops by itself.
std::vector<double> times_between(const scenes::Scene& scene, int frame, int parts) {
  std::vector<double> times;
  const double first = double(frame) / scene.fps, last = double(frame + 1) / scene.fps;
  for (int i = 1; i < parts; ++i) {
    const double time = scenes::own_time(scene, (frame + double(i) / parts) / scene.fps);
    if (time > (times.empty() ? first : times.back()) && time < last) times.push_back(time);
  }
  return times;
}

}  // namespace

void play(const scenes::Scene& scene, FrameWriter& writer, const std::function<void(int)>& tick) {
  const int frames = scene.frames(), parts = writer.states_per_frame();
  if (parts == 0) {
    for (int frame = 0; frame < frames; ++frame) {
      writer.add({true, {double(frame) / scene.fps, {}, {}}, {}});
      tick(frame + 1);
    }
    return writer.finish();
  }
  Simulation simulation = start(scene);
  const ShownVelocities velocities(scene.world, scene.timeline);
  std::optional<Between> between;
  if (parts > 1) between.emplace(scene);
  for (int frame = 0; frame < frames; ++frame) {
    World before;
    if (between) before = simulation.world();
    simulation.advance_to(double(frame) / scene.fps);
    const Snapshot state = simulation.state();
    if (between && frame > 0)
      for (Snapshot& shown : between->states(before, times_between(scene, frame - 1, parts), state))
        writer.add({false, std::move(shown), {}});
    writer.add({true, state, velocities.of(simulation)});
    tick(frame + 1);
  }
  writer.finish();
}

}  // namespace taut::exporting
