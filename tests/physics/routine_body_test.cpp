// The martial artist in the routine, frame by frame: what flies past misses him, his hand stays on
// its path, and no joint leaves its range.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "scenes/character/capsules.h"
#include "scenes/character/grip.h"
#include "tests/physics/routine.h"

namespace taut {
namespace {

constexpr double kDegree = M_PI / 180;

class RoutineBody : public testing::Test {
 protected:
  /// Calls use(instance, bones) for every frame of the clip.
  template <typename Use>
  void each_frame(Use use) const {
    const auto& steps = routine_.steps;
    const auto per_frame =
        static_cast<std::size_t>(std::lround(1 / (routine_.scene.fps * routine_.step)));
    for (std::size_t k = per_frame - 1; k < steps.size(); k += per_frame)
      use(steps[k], performance_.bones_at(steps[k].time));
  }
  Vec3 joint(const std::vector<Pose>& bones, const char* name) const {
    return bones[static_cast<std::size_t>(model_.bone(name))].position;
  }
  double stick_radius() const { return 0.014; }

  const Routine& routine_ = Routine::shipped();
  const Model& model_ = *routine_.scene.stage->characters[0];
  const Performance& performance_ = *routine_.scene.performances[0];
};

TEST_F(RoutineBody, TheFreeStickMissesHimAndTheHeldStick) {
  const auto fitted = fit_capsules(model_);
  std::map<std::string, double> least;
  double sticks = 1;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    const Capsule stick{i.top, i.tip, stick_radius(), 0};
    for (const Capsule& part : place_capsules(fitted, model_, bones)) {
      const auto [entry, fresh] = least.try_emplace(model_.bones[part.bone].name, 1.0);
      entry->second = std::min(entry->second, clearance(stick, part));
    }
    const Vec3 butt = i.from + 2 * (i.grip - i.from) / (0.15 - 0.015) * 0.15;
    sticks = std::min(sticks, clearance(stick, {i.from, butt, stick_radius(), 0}));
  });
  EXPECT_GT(least.size(), 20u);
  for (const auto& [part, distance] : least) EXPECT_GT(distance, 0.02) << part;
  EXPECT_GT(sticks, 0.005);
}

TEST_F(RoutineBody, TheHandStaysOnItsPath) {
  const Skeleton skeleton(model_);
  const std::size_t hand = skeleton.find("RightHand");
  const Grip grip = grip_stick(model_, skeleton, Side::right, stick_radius());
  const Eigen::Affine3d bind(model_.bones[hand].inverse_bind.cast<double>());
  const Vec3 held = bind * Vec3(skeleton.rest(hand) + grip.centre);  // in the bone's own axes
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    EXPECT_LT((i.grip - i.hand.position).norm(), 1e-9) << i.time;
    EXPECT_LT((bones[hand].to_world(held) - i.hand.position).norm(), 1e-3) << i.time;
  });
}

TEST_F(RoutineBody, WristAndElbowStayInTheirRange) {
  std::vector<double> bends;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    const Vec3 shoulder = joint(bones, "RightArm"), elbow = joint(bones, "RightForeArm");
    const Vec3 wrist = joint(bones, "RightHand"), knuckle = joint(bones, "RightHandMiddle1");
    const auto angle = [](const Vec3& a, const Vec3& b) {
      return std::atan2(a.cross(b).norm(), a.dot(b));
    };
    bends.push_back(angle(wrist - elbow, knuckle - wrist));
    // The elbow neither locks straight nor folds farther than an arm does.
    const double flexion = angle(elbow - shoulder, wrist - elbow);
    EXPECT_GT(flexion, 3 * kDegree) << i.time;
    EXPECT_LT(flexion, 145 * kDegree) << i.time;
    EXPECT_LT(elbow.y(), shoulder.y() + 0.1) << i.time;
  });
  std::ranges::sort(bends);
  EXPECT_LT(bends[bends.size() * 99 / 100], 45 * kDegree);
  EXPECT_LT(bends.back(), 60 * kDegree);
}

/// Nothing pops from one frame to the next, and the feet stand where they stand.
TEST_F(RoutineBody, MovesWithoutJumpsOnStandingFeet) {
  std::vector<Pose> before;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    if (!before.empty()) {
      for (const char* name : {"RightForeArm", "LeftForeArm", "Head", "Hips", "RightLeg"})
        EXPECT_LT((joint(bones, name) - joint(before, name)).norm(), 0.04) << name << i.time;
      for (const char* name : {"RightFoot", "LeftFoot"})
        EXPECT_LT((joint(bones, name) - joint(before, name)).norm(), 1e-6) << name << i.time;
    }
    before = bones;
  });
}

}  // namespace
}  // namespace taut
