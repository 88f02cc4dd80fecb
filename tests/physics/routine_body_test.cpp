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
  std::size_t foot(const char* name) const { return static_cast<std::size_t>(model_.bone(name)); }
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

/// Nothing pops from one frame to the next; a foot stands where it stands, and goes through the air
/// where it steps.
TEST_F(RoutineBody, MovesWithoutJumpsAndStepsWithLiftedFeet) {
  const double sole = Skeleton(model_).rest(foot("RightFoot")).y();
  std::vector<Pose> before;
  double in_the_air = 0, way = 0;  // s, m
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    if (!before.empty()) {
      for (const char* name : {"RightForeArm", "LeftForeArm", "Head", "Hips", "RightLeg"})
        EXPECT_LT((joint(bones, name) - joint(before, name)).norm(), 0.04) << name << i.time;
      EXPECT_LT((joint(bones, "LeftFoot") - joint(before, "LeftFoot")).norm(), 1e-6) << i.time;
      const Vec3 moved = joint(bones, "RightFoot") - joint(before, "RightFoot");
      const double height =
          std::max(joint(bones, "RightFoot").y(), joint(before, "RightFoot").y()) - sole;
      if (height < 1e-4) {
        EXPECT_LT(moved.norm(), 1e-6) << i.time;
      } else {
        in_the_air += 1.0 / routine_.scene.fps;
        way += std::hypot(moved.x(), moved.z());
      }
      EXPECT_LT(moved.norm(), 0.03) << i.time;
    }
    before = bones;
  });
  EXPECT_GT(in_the_air, 0.2);  // it does step, but mostly stands
  EXPECT_LT(in_the_air, 0.2 * routine_.scene.duration);
  EXPECT_GT(way, 0.06);
}

/// The upper arm as the chest sees it: human shoulders reach no farther.
TEST_F(RoutineBody, TheShouldersStayInTheirRange) {
  const auto chest = static_cast<std::size_t>(model_.bone("Chest"));
  const Quat rest =
      Skeleton(model_).poses(Skeleton(model_).place(Skeleton(model_).upright()))[chest].rotation;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    for (const auto& [side, out] : {std::pair<std::string, double>{"Right", -1}, {"Left", 1}}) {
      const Vec3 arm =
          joint(bones, (side + "ForeArm").c_str()) - joint(bones, (side + "Arm").c_str());
      const Vec3 d = rest * (bones[chest].rotation.conjugate() * arm.normalized());
      const double raised = std::acos(-d.y()) / kDegree;                  // from hanging down
      EXPECT_LT(raised, 120) << side << i.time;                           // 180 is possible
      EXPECT_GT(d.z(), -std::sin(60 * kDegree)) << side << i.time;        // extension
      EXPECT_GT(out * d.x(), -std::sin(45 * kDegree)) << side << i.time;  // across the chest
    }
  });
}

/// Gaze: eyes rest on the opponent, on the stick in the hand, or between them.
TEST_F(RoutineBody, TheEyesAreOnTheOpponentOrTheStick) {
  const auto eye = static_cast<std::size_t>(model_.bone("RightEye"));
  const Quat rest =
      Skeleton(model_).poses(Skeleton(model_).place(Skeleton(model_).upright()))[eye].rotation;
  const Vec3 opponent(0.35, 1.55, 3.0);
  int off = 0, frames = 0;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    const Vec3 look = bones[eye].rotation * (rest.conjugate() * Vec3::UnitZ());
    const Vec3 a = opponent - bones[eye].position, b = i.from - bones[eye].position;
    double least = 180;
    for (double share = 0; share <= 1; share += 0.05) {
      const Vec3 there = ((1 - share) * a + share * b).normalized();
      least = std::min(least, std::acos(std::min(1.0, there.dot(look))) / kDegree);
    }
    off += least > 8;
    ++frames;
  });
  EXPECT_LT(off, 0.03 * frames);
}

}  // namespace
}  // namespace taut
