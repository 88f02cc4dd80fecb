// Faults planted on purpose: the thresholds by which golden pictures are compared see each of them,
// and let pass what is not a fault.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>

#include "render/film/film.h"
#include "render/golden/golden.h"
#include "scenes/golden_suite.h"
#include "scenes/load_scene.h"

namespace taut {
namespace {

const std::filesystem::path kFolder =
    std::filesystem::path(TAUT_SOURCE_DIR) / "tests/golden/nunchaku";

class PlantedFaults : public testing::Test {
 protected:
  GoldenSuite suite_ = load_golden_suite(kFolder);
  Scene scene_ = load_scene(suite_.frames.front().scene, true);
  Context context_{Backend::automatic};
  Renderer here_ = renderer_of(context_.description());
  Renderer same_driver_{here_.driver, "another processor"};
  Renderer other_driver_{"another driver", "another processor"};

  GoldenRecord record(const GoldenFrame& frame) const {
    return read_golden(kFolder / (frame.name + ".json"));
  }

  Picture draw(const Scene& scene, const Snapshot& state, int samples = 4,
               const Shading& shadows = {}) {
    Film film(context_, scene, suite_.width, suite_.height, samples, shadows);
    return film.draw(film.instant(state));
  }

  /// How a picture of the frame would compare if it came from `renderer`.
  PictureComparison compared(const Picture& picture, const GoldenFrame& frame,
                             const Renderer& renderer) {
    return compare(picture, renderer, read_png(kFolder / (frame.name + ".png")), record(frame));
  }

  /// Caught in both tiers of one driver.
  void expect_caught(const Picture& picture, const GoldenFrame& frame) {
    for (const Renderer* renderer : {&here_, &same_driver_}) {
      const PictureComparison comparison = compared(picture, frame, *renderer);
      EXPECT_FALSE(comparison.same) << frame.name << ", compared by: " << name_of(comparison.tier);
    }
  }

  /// The state with the last body moved in the picture, across its length.
  Snapshot stick_moved(const Snapshot& state, double pixels) const {
    const CameraView camera = camera_at(scene_.stage->camera, state.time);
    Snapshot moved = state;
    Pose& stick = moved.bodies.back();
    const Vec3 forward = (camera.target - camera.position).normalized();
    const double depth = (stick.position - camera.position).dot(forward);
    const double pixel = 2 * depth * std::tan(camera.field_of_view / 2) / suite_.height;  // m
    stick.position += pixels * pixel * forward.cross(stick.rotation * Vec3::UnitY()).normalized();
    return moved;
  }

  /// The scene with a changed copy of its character's model.
  Scene character_changed(const std::function<void(Model&)>& change) const {
    Scene scene = scene_;
    Model model = *scene.stage->characters.front();
    change(model);
    scene.stage->characters.front() = std::make_shared<const Model>(std::move(model));
    return scene;
  }
};

TEST_F(PlantedFaults, NothingPlantedPassesInEveryTier) {
  for (const GoldenFrame& frame : suite_.frames) {
    const Picture picture = draw(scene_, record(frame).state);
    for (const Renderer* renderer : {&here_, &same_driver_, &other_driver_})
      EXPECT_TRUE(compared(picture, frame, *renderer).same)
          << frame.name << ", compared by: " << name_of(compared(picture, frame, *renderer).tier);
  }
}

TEST_F(PlantedFaults, AStickOnePixelOffIsSeen) {
  for (const GoldenFrame& frame : suite_.frames)
    expect_caught(draw(scene_, stick_moved(record(frame).state, 1)), frame);
}

TEST_F(PlantedFaults, AStickThreePixelsOffIsSeenEvenByAnotherDriver) {
  // Where a hand or the other stick covers it, nothing can be seen: most frames tell.
  std::size_t seen = 0;
  for (const GoldenFrame& frame : suite_.frames) {
    const Picture picture = draw(scene_, stick_moved(record(frame).state, 3));
    seen += !compared(picture, frame, other_driver_).same;
  }
  EXPECT_GT(2 * seen, suite_.frames.size());
}

TEST_F(PlantedFaults, AMissingLinkIsSeen) {
  // A link is drawn between particles: without the last particle there is one less.
  const GoldenFrame& frame = suite_.frames.front();
  Snapshot state = record(frame).state;
  state.connectors.front().pop_back();
  expect_caught(draw(scene_, state), frame);
}

TEST_F(PlantedFaults, ALightTwoPercentOffIsSeen) {
  Scene scene = scene_;
  scene.stage->light.color *= 0.98;
  const GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene, record(frame).state), frame);
}

TEST_F(PlantedFaults, MissingAntialiasingIsSeen) {
  const GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene_, record(frame).state, 1), frame);
}

TEST_F(PlantedFaults, AShadowMapOfHalfTheSizeIsSeen) {
  const GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene_, record(frame).state, 4, {.map_size = Shading().map_size / 2}), frame);
}

TEST_F(PlantedFaults, MissingContactShadowIsSeen) {
  const GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene_, record(frame).state, 4, {.contact = false}), frame);
}

TEST_F(PlantedFaults, AWrongBoneWeightIsSeen) {
  // One mesh of the character follows each vertex's first bone alone.
  const Scene scene = character_changed([](Model& model) {
    for (Vertex& vertex : model.meshes.front().vertices) vertex.weights = {1, 0, 0, 0};
  });
  const GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene, record(frame).state), frame);
}

}  // namespace
}  // namespace taut
