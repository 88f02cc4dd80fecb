// The backdrop that a canvas keeps saves work and changes no pixel.
#include <gtest/gtest.h>

#include "render/draw/stage_renderer.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::backdrop_test {
namespace {

constexpr int kWidth = 320, kHeight = 180;

picture::Picture draw(draw::StageRenderer& renderer, gl::Canvas& canvas,
                      const draw::FrameState& instant) {
  const draw::View view{{0, 0, kWidth, kHeight}, instant.camera};
  renderer.begin(canvas, {&view, 1});
  renderer.draw(canvas, view.viewport, instant);
  return canvas.finish();
}

/// The camera stands for a while, steps aside for one frame, and comes back; by then the hand is
/// where it was not before.
std::vector<draw::FrameState> instants_of(const scenes::Scene& scene) {
  Simulation simulation(scene.world, make_method(scene.method.name, scene.method.settings));
  std::vector<draw::FrameState> instants;
  for (int i = 0; i < 7; ++i) {
    const double time = i == 6 ? 3.4 : 1.2 + 0.25 * i;
    simulation.advance_to(time);
    draw::FrameState instant{
        snapshot(simulation.world()), {}, scenes::camera_at(scene.stage->camera, 0)};
    for (const auto& performance : scene.performances)
      instant.bones.push_back(performance->bones_at(time));
    if (i == 5) instant.camera.position += Vec3(0.5, 0, 0);
    instants.push_back(instant);
  }
  return instants;
}

/// By a camera with a lens of that relative aperture.
void expect_frames_depend_on_their_instants(double relative_aperture) {
  static const scenes::Scene scene =
      scenes::load_scene(std::filesystem::path(TAUT_SOURCE_DIR) / "scenes/nunchaku.toml", true);
  static const std::vector<draw::FrameState> played = instants_of(scene);
  const gl::Context context(gl::Backend::automatic);
  draw::StageRenderer renderer(context, *scene.stage, scene.world);
  gl::Canvas canvas(context, kWidth, kHeight, 4);
  std::vector<draw::FrameState> instants = played;
  for (draw::FrameState& instant : instants) instant.camera.relative_aperture = relative_aperture;
  for (std::size_t i = 0; i < instants.size(); ++i) {
    gl::Canvas alone(context, kWidth, kHeight, 4);
    EXPECT_EQ(draw(renderer, canvas, instants[i]).pixels, draw(renderer, alone, instants[i]).pixels)
        << i;
  }
}

TEST(Backdrop, AFrameDependsOnItsInstantAlone) {
  expect_frames_depend_on_their_instants(0);
}

TEST(Backdrop, AFrameOutOfFocusDependsOnItsInstantAlone) {
  expect_frames_depend_on_their_instants(1);
}

}  // namespace
}  // namespace taut::backdrop_test
