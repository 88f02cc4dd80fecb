#include "render/export/frame_writer.h"
#include "scenes/exposure.h"
#include "sim/shown_velocities.h"

namespace taut {

void play(const Scene& scene, FrameWriter& writer, const std::function<void(int)>& tick) {
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
  const auto show = [&](double time, bool frame) {
    simulation.advance_to(time);
    writer.add({frame, simulation.state(), velocities.of(simulation)});
  };
  for (int frame = 0; frame < frames; ++frame) {
    show(double(frame) / scene.fps, true);
    tick(frame + 1);
    for (int i = 1; i < parts && frame + 1 < frames; ++i) {
      // Where a method of equal steps stops by itself: the states between change no bit of it.
      const double time = own_time(scene, (frame + double(i) / parts) / scene.fps);
      if (time > simulation.world().time && time < double(frame + 1) / scene.fps) show(time, false);
    }
  }
  writer.finish();
}

}  // namespace taut
