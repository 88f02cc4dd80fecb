// The contents of a clip: the order of cards and shots, the time of each frame, and the simulation
// made for it.
#include "scenes/scene/clip.h"

#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <numeric>
#include <string>

#include "render/draw/motion_extents.h"
#include "render/draw/shading/lighting.h"
#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "tests/physics/worlds.h"

namespace taut::clip_test {
namespace {

scenes::Scene swinging() {
  scenes::Scene scene;
  scene.duration = 2;
  scene.fps = 60;
  scene.method = {"impulse", {{"step", 1.0 / 2400}}};
  scene.world = worlds::chain(5, 1, Vec3::UnitX());
  scene.stage.emplace();
  scene.stage->shots = {{.until = 2, .camera = {scenes::CameraKey{}}}};
  return scene;
}

TEST(Clip, ASceneWithoutShotsIsPlayedOnce) {
  const scenes::Scene scene = swinging();
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene);
  ASSERT_EQ(int(frames.size()), scene.frames());
  for (std::size_t k = 0; k < frames.size(); ++k) EXPECT_EQ(frames[k].time, double(k) / 60);
}

TEST(Clip, ShotsFollowEachOtherAtTheirOwnRates) {
  scenes::Scene scene = swinging();
  scene.stage->shots = {
      {.from = 0, .until = 1, .camera = {scenes::CameraKey{}}},
      {.from = 0.5, .until = 0.75, .rate = 0.25, .camera = {scenes::CameraKey{}}}};
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene);
  ASSERT_EQ(frames.size(), 60u + 60u);
  EXPECT_EQ(frames[59].time, 59.0 / 60);
  for (int k = 0; k < 60; ++k) {
    EXPECT_NEAR(frames[std::size_t(60 + k)].time, 0.5 + k / 240.0, 1e-12);
    EXPECT_EQ(frames[std::size_t(60 + k)].shot, &scene.stage->shots[1]);
  }
}

TEST(Clip, CardsStandOverTheFirstAndTheLastPicture) {
  scenes::Scene scene = swinging();
  scene.stage->title = {.duration = 1, .heading = "title", .text = ""};
  scene.stage->end = {.duration = 0.5, .heading = "end", .text = ""};
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene);
  ASSERT_EQ(frames.size(), 60u + 120u + 30u);
  EXPECT_EQ(frames[0].card, &scene.stage->title);
  EXPECT_EQ(frames[0].card_shown, 1);
  EXPECT_EQ(frames[0].time, 0);
  EXPECT_LT(frames[59].card_shown, 0.1);
  EXPECT_EQ(frames[60].card, nullptr);
  EXPECT_EQ(frames[180].card, &scene.stage->end);
  EXPECT_LT(frames[180].card_shown, 0.1);
  EXPECT_EQ(frames[209].time, 119.0 / 60);
}

TEST(Clip, SlowMotionShowsStatesOfTheSameMotion) {
  scenes::Scene scene = swinging();
  scene.stage->shutter = 0.5;
  const std::vector<scenes::ClipFrame> straight = scenes::clip_frames(scene);
  const auto tick = [] {};
  const std::vector<int> wanted = {30, 44};
  const auto normal = scenes::record(scene, straight, wanted, tick);
  scene.stage->shots = {
      {.from = 0, .until = 1, .camera = {scenes::CameraKey{}}},
      {.from = 0.5, .until = 0.75, .rate = 0.25, .camera = {scenes::CameraKey{}}}};
  const std::vector<scenes::ClipFrame> again = scenes::clip_frames(scene);
  // Frames 60 and 60 + 4 * 14 of the second clip have the times of 30 and 44.
  const auto slow = scenes::record(scene, again, {60, 60 + 4 * 14}, tick);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const std::vector<Snapshot>&usual = normal[i].states, &slowed = slow[i].states;
    const Snapshot &a = usual[usual.size() / 2], &b = slowed[slowed.size() / 2];
    EXPECT_EQ(a.time, b.time);
    EXPECT_EQ(a.connectors, b.connectors);
    for (const auto& [shutter, rate] : {std::pair(&usual, 1.0), {&slowed, 0.25}}) {
      const double open = rate * scene.stage->shutter / scene.fps;  // half a state beyond both ends
      EXPECT_NEAR(shutter->back().time - shutter->front().time,
                  open * (1 - 1.0 / double(shutter->size())), 1.0 / 2400);
    }
  }
}

// Whichever frames are wanted, a trail has the places of the shot's frames until then.
TEST(ClipSimulation, ATrailIsTheWayOfLate) {
  scenes::Scene scene = swinging();
  scene.stage->shots = {{.from = 0, .until = 0.5, .camera = {scenes::CameraKey{}}},
                        {.from = 1, .until = 2, .camera = {scenes::CameraKey{}}}};
  scene.stage->trails = {
      {.connector = true, .particle = 4, .lasts = 0.2},
      {.connector = true, .particle = 0, .lasts = 0.1, .from = 0.25, .until = 1.02}};
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene);
  std::vector<int> all(frames.size());
  std::iota(all.begin(), all.end(), 0);
  const auto every = scenes::record(scene, frames, all, [] {});
  const auto lengths = [&](int frame) {
    const auto& trails = every[std::size_t(frame)].trails;
    return std::pair(trails.at(0).places.size(), trails.at(1).places.size());
  };
  EXPECT_EQ(lengths(0), std::pair(std::size_t(1), std::size_t(0)));
  EXPECT_EQ(lengths(20), std::pair(std::size_t(13), std::size_t(6))) << "since it appeared";
  EXPECT_EQ(lengths(31), std::pair(std::size_t(2), std::size_t(2))) << "since the cut";
  EXPECT_EQ(lengths(32), std::pair(std::size_t(3), std::size_t(0))) << "it has gone";
  const scenes::TrailPoints& trail = every[20].trails[0];
  EXPECT_NEAR(trail.ages.front(), 0.2, 1e-9);
  EXPECT_NEAR(trail.ages.back(), 0, 1e-9);
  EXPECT_EQ(trail.places.back(), every[20].states[0].connectors[0][4]);
  EXPECT_EQ(trail.places.front(), every[8].states[0].connectors[0][4]);
  const auto one = scenes::record(scene, frames, {20}, [] {});
  EXPECT_EQ(one[0].trails[0].places, trail.places);
}

TEST(ClipSimulation, KeepsTheStatesOfOneShutterHoweverLongTheClip) {
  scenes::Scene scene = swinging();
  scene.world = worlds::chain(2000, 1, Vec3::UnitX());
  scene.stage->shutter = 0.5;
  const auto allocated = [] {
    const struct mallinfo2 heap = mallinfo2();
    return double(heap.uordblks + heap.hblkhd);
  };
  std::size_t shown = 0;
  const auto most_allocated = [&](double until) {
    scene.stage->shots = {
        {.from = 0, .until = until, .camera = {scenes::CameraKey{}}},
        {.from = 0.05, .until = 0.1, .rate = 0.25, .camera = {scenes::CameraKey{}}}};
    const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene);
    std::vector<int> wanted(frames.size());
    std::iota(wanted.begin(), wanted.end(), 0);
    const double before = allocated();
    scenes::ClipSimulation simulation(scene, frames, wanted, [] {});
    double most = 0;
    while (!simulation.done()) {
      const scenes::ClipSimulation::Shutter shutter = simulation.next();
      shown = shutter.states.size();
      most = std::max(most, allocated() - before);
    }
    return most;
  };
  const double few = most_allocated(0.2), many = most_allocated(1);  // 12 frames and 60
  const double shutter = double(shown * 2001 * sizeof(Vec3));
  EXPECT_GE(shown, 2u);
  EXPECT_LT(many - few, shutter);
}

/// The hose's scene with other shots.
scenes::Scene with_shots(const std::string& shots) {
  return scenes::load_scene(TAUT_SOURCE_DIR "/scenes/hose.toml", true, {{"stage.shots", shots}});
}

TEST(Clip, ShotsAreReadAndThoseThatCannotBeAreTold) {
  const scenes::Scene scene = with_shots("[ { from = 0.5, until = 1.0, rate = 0.5 } ]");
  ASSERT_EQ(scene.stage->shots.size(), 1u);
  EXPECT_EQ(scene.stage->shots[0].rate, 0.5);
  EXPECT_EQ(scene.stage->shots[0].camera.size(), scene.stage->camera.size()) << "the stage's own";
  for (const auto& [shots, says] :
       {std::pair("[ { from = 0.5, until = 0.5 } ]", "a time after 0.5 s"),
        {"[ { from = 0.5, until = 99.0 } ]", "at most the scene's duration"},
        {"[ { from = 0.5, until = 1.0, rate = 0.0 } ]", "rate"},
        {"[ { from = 0.5 } ]", "until"}}) {
    try {
      with_shots(shots);
      ADD_FAILURE() << shots;
    } catch (const scenes::BadScene& error) {
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
  }
}

TEST(Clip, TheShortEditTakesTwelveSeconds) {
  const scenes::Scene scene = scenes::load_scene(
      std::filesystem::path(TAUT_SOURCE_DIR) / "scenes/nunchaku_edit.toml", true);
  EXPECT_EQ(scenes::clip_frames(scene).size(), 12u * 60u);
  EXPECT_EQ(scene.width, 1920);
  EXPECT_EQ(scene.height, 1080);
}

/// The farthest (px) that anything seen of the scenery comes while the shutter is open; counts the
/// frames in which the camera moves.
float farthest_move(const scenes::Scene& scene, int& moving) {
  const double open = scene.stage->shutter / scene.fps;
  const auto pixel = [&](const scenes::CameraView& view, const Vec3& p) {
    const Eigen::Vector4f q = draw::camera_projection(view, double(scene.width) / scene.height) *
                              p.cast<float>().homogeneous();
    const Eigen::Vector2f at = q.head<2>() / q.w();
    const bool seen = q.w() > 0.05f && at.cwiseAbs().maxCoeff() < 1;
    return std::pair(
        seen, Eigen::Vector2f(at.x() * float(scene.width) / 2, at.y() * float(scene.height) / 2));
  };
  float most = 0;
  for (const scenes::ClipFrame& frame : scenes::clip_frames(scene)) {
    const scenes::Shot& shot = *frame.shot;
    const scenes::CameraView first =
        scenes::camera_at(shot.camera, frame.time - shot.rate * open / 2);
    const scenes::CameraView last =
        scenes::camera_at(shot.camera, frame.time + shot.rate * open / 2);
    if (first.position == last.position && first.target == last.target) continue;
    ++moving;
    for (const auto& model : scene.stage->scenery)
      for (const scenes::Mesh& mesh : model->meshes)
        for (std::size_t v = 0; v < mesh.vertices.size(); v += 20) {
          const Vec3 p = Eigen::Vector3f(mesh.vertices[v].position.data()).cast<double>();
          const auto [seen, from] = pixel(first, p);
          const auto [still_seen, to] = pixel(last, p);
          if (seen && still_seen) most = std::max(most, (to - from).norm());
        }
  }
  return most;
}

TEST(LongClip, CamerasMoveLessThanAPixelWhileTheShutterIsOpen) {
  // Frames show the camera at one time, so its moves must be too slow to blur.
  int moving = 0;
  for (const char* name : {"nunchaku", "nunchaku_edit", "nunchaku_paper"}) {
    const scenes::Scene scene = scenes::load_scene(
        std::filesystem::path(TAUT_SOURCE_DIR) / "scenes" / (name + std::string(".toml")), true);
    EXPECT_LT(farthest_move(scene, moving), float(draw::MotionExtents::kStill)) << name;
  }
  EXPECT_GT(moving, 40);
}

}  // namespace
}  // namespace taut::clip_test
