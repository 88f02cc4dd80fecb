#include <optional>
#include <utility>

#include "render/export/frame_writer.h"
#include "scenes/scene/clip.h"
#include "sim/run/simulation.h"

namespace taut::exporting {
namespace {

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
  if (parts > 1) between.emplace(start(scene));
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
