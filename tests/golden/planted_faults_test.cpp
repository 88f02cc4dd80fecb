// Faults planted on purpose: the thresholds by which golden pictures are compared see each of them,
// and let pass what is not a fault.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>

#include "render/film/film.h"
#include "render/golden/golden.h"
#include "scenes/load/golden_suite.h"
#include "scenes/load/load_scene.h"

namespace taut::planted_faults_test {
namespace {

const std::filesystem::path kFolder =
    std::filesystem::path(TAUT_SOURCE_DIR) / "tests/golden/nunchaku";
constexpr int kSamples = 4;

/// The tools that all tests here draw with.
struct Studio {
  scenes::GoldenSuite suite = scenes::load_golden_suite(kFolder);
  scenes::Scene scene = scenes::load_scene(suite.frames.front().scene, true);
  gl::Context context{gl::Backend::automatic};
  film::Film film{context, scene, suite.width, suite.height, kSamples};  // of the scene as it is
};

class PlantedFaults : public testing::Test {
 protected:
  static void SetUpTestSuite() { studio_ = std::make_unique<Studio>(); }
  static void TearDownTestSuite() { studio_.reset(); }

  inline static std::unique_ptr<Studio> studio_;
  const scenes::GoldenSuite& suite_ = studio_->suite;
  const scenes::Scene& scene_ = studio_->scene;
  std::string driver_ = golden::driver_of(studio_->context.description());
  std::string other_driver_ = "another driver";

  golden::GoldenRecord record(const scenes::GoldenFrame& frame) const {
    return golden::read_golden(kFolder / (frame.name + ".json"));
  }

  picture::Picture draw(const scenes::Scene& scene, const golden::GoldenRecord& record,
                        int samples = kSamples, const draw::Shading& shadows = {}) {
    film::Film film(studio_->context, scene, suite_.width, suite_.height, samples, shadows);
    return film.draw(kept(film, record));
  }

  picture::Picture draw(const golden::GoldenRecord& record) {
    return studio_->film.draw(kept(studio_->film, record));
  }

  static draw::FrameState kept(const film::Film& film, const golden::GoldenRecord& record) {
    draw::FrameState instant = film.instant(record.state);
    instant.bones = record.bones;
    return instant;
  }

  /// How a picture of the frame would compare if `driver` drew it.
  golden::PictureComparison compared(const picture::Picture& picture,
                                     const scenes::GoldenFrame& frame, const std::string& driver) {
    return golden::compare(picture, driver, picture::read_png(kFolder / (frame.name + ".png")),
                           record(frame));
  }

  /// Caught by the driver that drew the golden pictures.
  void expect_caught(const picture::Picture& picture, const scenes::GoldenFrame& frame) {
    if (record(frame).driver != driver_) GTEST_SKIP() << "accepted by another driver";
    EXPECT_FALSE(compared(picture, frame, driver_).same) << frame.name;
  }

  /// The state with the last body moved in the picture, across its length.
  golden::GoldenRecord stick_moved(golden::GoldenRecord moved, double pixels) const {
    const scenes::CameraView camera = scenes::camera_at(scene_.stage->camera, moved.state.time);
    Pose& stick = moved.state.bodies.back();
    const Vec3 forward = (camera.target - camera.position).normalized();
    const double depth = (stick.position - camera.position).dot(forward);
    const double pixel = 2 * depth * std::tan(camera.field_of_view / 2) / suite_.height;  // m
    stick.position += pixels * pixel * forward.cross(stick.rotation * Vec3::UnitY()).normalized();
    return moved;
  }

  /// The scene with a changed copy of its character's model.
  scenes::Scene character_changed(const std::function<void(scenes::Model&)>& change) const {
    scenes::Scene scene = scene_;
    scenes::Model model = *scene.stage->characters.front();
    change(model);
    scene.stage->characters.front() = std::make_shared<const scenes::Model>(std::move(model));
    return scene;
  }
};

TEST_F(PlantedFaults, NothingPlantedPassesByEveryTolerance) {
  for (const scenes::GoldenFrame& frame : suite_.frames) {
    const picture::Picture picture = draw(record(frame));
    for (const std::string& driver : {driver_, other_driver_})
      EXPECT_TRUE(compared(picture, frame, driver).same)
          << frame.name
          << ", compared by: " << golden::name_of(compared(picture, frame, driver).tier);
  }
}

TEST_F(PlantedFaults, AStickOnePixelOffIsSeen) {
  for (const scenes::GoldenFrame& frame : suite_.frames)
    expect_caught(draw(stick_moved(record(frame), 1)), frame);
}

TEST_F(PlantedFaults, AStickThreePixelsOffIsSeenEvenByAnotherDriver) {
  // Where a hand or the other stick covers it, nothing can be seen: most frames tell.
  std::size_t seen = 0;
  for (const scenes::GoldenFrame& frame : suite_.frames) {
    const picture::Picture picture = draw(stick_moved(record(frame), 3));
    seen += !compared(picture, frame, other_driver_).same;
  }
  EXPECT_GT(2 * seen, suite_.frames.size());
}

TEST_F(PlantedFaults, AMissingLinkIsSeen) {
  // A link is drawn between particles: without the last particle there is one less.
  const scenes::GoldenFrame& frame = suite_.frames.front();
  golden::GoldenRecord short_of_one = record(frame);
  short_of_one.state.connectors.front().pop_back();
  expect_caught(draw(short_of_one), frame);
}

TEST_F(PlantedFaults, ALightTwoPercentOffIsSeen) {
  scenes::Scene scene = scene_;
  scene.stage->light.color *= 0.98;
  const scenes::GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene, record(frame)), frame);
}

TEST_F(PlantedFaults, MissingAntialiasingIsSeen) {
  const scenes::GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene_, record(frame), 1), frame);
}

TEST_F(PlantedFaults, AShadowMapOfHalfTheSizeIsSeen) {
  const scenes::GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene_, record(frame), kSamples, {.map_size = draw::Shading().map_size / 2}),
                frame);
}

TEST_F(PlantedFaults, MissingContactShadowIsSeen) {
  const scenes::GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene_, record(frame), kSamples, {.contact = false}), frame);
}

TEST_F(PlantedFaults, AWrongBoneWeightIsSeen) {
  // One mesh of the character follows each vertex's first bone alone.
  const scenes::Scene scene = character_changed([](scenes::Model& model) {
    for (scenes::Vertex& vertex : model.meshes.front().vertices) vertex.weights = {1, 0, 0, 0};
  });
  const scenes::GoldenFrame& frame = suite_.frames.front();
  expect_caught(draw(scene, record(frame)), frame);
}

}  // namespace
}  // namespace taut::planted_faults_test
