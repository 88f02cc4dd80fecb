// The martial artist in the routine, frame by frame: what flies past misses him, his hand stays on
// its path, and no joint leaves its range.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "render/mesh/skinning.h"
#include "scenes/character/capsules.h"
#include "scenes/character/hand.h"
#include "tests/physics/character/routine.h"

namespace taut::routine_body_test {
namespace {

constexpr double kDegree = M_PI / 180;

class LongRoutineBody : public testing::Test {
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
  const scenes::Model& model_ = *routine_.scene.stage->characters[0];
  const scenes::Performance& performance_ = *routine_.scene.performances[0];
};

/// Until it is thrown over the shoulder, where it is to touch him.
TEST_F(LongRoutineBody, TheFreeStickMissesHimAndTheHeldStick) {
  const double thrown = routine_.caption("Four times slower: the hand").from;
  const auto fitted = scenes::fit_capsules(model_);
  std::map<std::string, double> least;
  double sticks = 1;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    if (i.time > thrown) return;
    const scenes::Capsule stick{i.top, i.tip, stick_radius(), 0};
    for (const scenes::Capsule& part : scenes::place_capsules(fitted, model_, bones)) {
      const auto [entry, fresh] = least.try_emplace(model_.bones[part.bone].name, 1.0);
      entry->second = std::min(entry->second, scenes::clearance(stick, part));
    }
    const Vec3 butt = i.from + 2 * (i.grip - i.from) / (0.15 - 0.015) * 0.15;
    sticks = std::min(sticks, scenes::clearance(stick, {i.from, butt, stick_radius(), 0}));
  });
  EXPECT_GT(least.size(), 20u);
  for (const auto& [part, distance] : least) EXPECT_GT(distance, 0.02) << part;
  EXPECT_GT(sticks, 0.005);
}

TEST_F(LongRoutineBody, TheHandStaysOnItsPath) {
  const scenes::Skeleton skeleton(model_);
  const std::size_t hand = skeleton.find("RightHand");
  const scenes::Grip grip =
      scenes::grip_stick(model_, skeleton, scenes::Side::right, stick_radius());
  const Eigen::Affine3d bind(model_.bones[hand].inverse_bind.cast<double>());
  const Vec3 held = bind * Vec3(skeleton.rest(hand) + grip.centre);  // in the bone's own axes
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    EXPECT_LT((i.grip - i.hand.position).norm(), 1e-9) << i.time;
    EXPECT_LT((bones[hand].to_world(held) - i.hand.position).norm(), 1e-3) << i.time;
  });
}

TEST_F(LongRoutineBody, WristAndElbowStayInTheirRange) {
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

TEST_F(LongRoutineBody, MovesWithoutJumps) {
  std::vector<Pose> before;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    if (!before.empty()) {
      for (const char* name :
           {"RightForeArm", "LeftForeArm", "Head", "Hips", "RightLeg", "LeftLeg"})
        EXPECT_LT((joint(bones, name) - joint(before, name)).norm(), 0.04) << name << i.time;
      for (const char* name : {"RightFoot", "LeftFoot"})
        EXPECT_LT((joint(bones, name) - joint(before, name)).norm(), 0.03) << name << i.time;
    }
    before = bones;
  });
}

/// A foot stands flat where it stands and never slides; it goes through the air where it steps, its
/// skin above the floor, and the other stands meanwhile and carries.
TEST_F(LongRoutineBody, BothFeetStepAndNeitherSlides) {
  const scenes::Skeleton skeleton(model_);
  const scenes::Placement rest = skeleton.place(skeleton.upright());
  constexpr std::array<const char*, 2> names = {"LeftFoot", "RightFoot"};
  std::array<double, 2> in_the_air{}, way{}, leaning{};  // s, m, m
  Vec3 left_from = Vec3::Zero();                         // m, of the pelvis
  std::vector<Pose> before;
  std::vector<mesh::MovingVertex> skin_now;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    int lifted = 0;
    for (std::size_t f = 0; f < 2; ++f) {
      const std::size_t bone = foot(names[f]);
      const double sole = rest.position[bone].y();
      const bool is_up = bones[bone].position.y() > sole + 1e-4;
      const bool was_up = !before.empty() && before[bone].position.y() > sole + 1e-4;
      lifted += is_up;
      const Vec3 up =
          bones[bone].rotation * (skeleton.poses(rest)[bone].rotation.conjugate() * Vec3::UnitY());
      if (!is_up) {
        EXPECT_GT(up.y(), 1 - 1e-9) << names[f] << " is flat at " << i.time;
      }
      if (is_up) {
        const scenes::Mesh& mesh =
            *std::ranges::find(model_.meshes, f == 0 ? "SoleL" : "SoleR", &scenes::Mesh::name);
        mesh::skin(mesh, mesh::bone_matrices(model_, bones), skin_now);
        for (const mesh::MovingVertex& v : skin_now) ASSERT_GT(v.position.y(), -0.004f) << i.time;
        // The weight is on the other: the pelvis goes there from where it was as the foot left.
        const Vec3 other = bones[foot(names[1 - f])].position, hips = joint(bones, "Hips");
        if (!was_up) left_from = hips;
        const Vec3 aside = (other - hips).cwiseProduct(Vec3(1, 0, 1)).normalized();
        leaning[f] = std::max(leaning[f], (hips - left_from).dot(aside));
        in_the_air[f] += 1.0 / routine_.scene.fps;
      }
      if (before.empty()) continue;
      const Vec3 moved = bones[bone].position - before[bone].position;
      if (!is_up && !was_up) {
        EXPECT_LT(moved.norm(), 1e-6) << names[f] << i.time;
      }
      way[f] += std::hypot(moved.x(), moved.z());
    }
    EXPECT_LE(lifted, 1) << i.time;
    before = bones;
  });
  for (std::size_t f = 0; f < 2; ++f) {
    EXPECT_GT(in_the_air[f], 0.2) << names[f];  // it does step, but mostly stands
    EXPECT_LT(in_the_air[f], 0.2 * routine_.scene.duration) << names[f];
    EXPECT_GT(way[f], 0.06) << names[f];
    EXPECT_GT(leaning[f], 0.01) << names[f];
  }
}

/// The upper arm as the chest sees it: human shoulders reach no farther.
TEST_F(LongRoutineBody, TheShouldersStayInTheirRange) {
  const auto chest = static_cast<std::size_t>(model_.bone("Chest"));
  const Quat rest =
      scenes::Skeleton(model_)
          .poses(scenes::Skeleton(model_).place(scenes::Skeleton(model_).upright()))[chest]
          .rotation;
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

/// Gaze: eyes rest on the opponent, on the free stick, or between them; they come from the floor
/// before him, and go from the stick to whoever sees the last picture, and stay there as he bows.
TEST_F(LongRoutineBody, TheEyesAreOnTheOpponentOrTheStick) {
  const auto eye = static_cast<std::size_t>(model_.bone("RightEye"));
  const Quat rest =
      scenes::Skeleton(model_)
          .poses(scenes::Skeleton(model_).place(scenes::Skeleton(model_).upright()))[eye]
          .rotation;
  const Vec3 opponent(0.35, 1.55, 3.0), floor(0.2, 0.55, 1.9), audience(-1.35, 1.42, 2.1);
  constexpr int kAhead = 77, kBlurs = 48;  // steps of 1/960 s
  const auto at = [&](double time, int later) {
    const auto k = static_cast<std::size_t>(std::lround(time / routine_.step) - 1 + later);
    return routine_.steps[std::min(k, routine_.steps.size() - 1)].position;
  };
  int off = 0, frames = 0;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    Vec3 stick = Vec3::Zero();
    for (int k = -kBlurs; k <= kBlurs; ++k) stick += at(i.time, kAhead + k) / (2 * kBlurs + 1);
    const Vec3 look = bones[eye].rotation * (rest.conjugate() * Vec3::UnitZ());
    double least = 180;
    for (const auto& [from, to] :
         {std::pair{opponent, stick}, {opponent, floor}, {stick, audience}})
      for (int k = 0; k <= 20; ++k) {
        const double share = k / 20.0;
        const Vec3 there = ((1 - share) * from + share * to - bones[eye].position).normalized();
        least = std::min(least, std::acos(std::min(1.0, there.dot(look))) / kDegree);
      }
    off += least > 8;
    ++frames;
  });
  EXPECT_LT(off, 0.03 * frames);
}

/// Angles (rad) up from an eye's axis to the lowest and the highest point of a mesh that a bone
/// turns, within 3 mm of the vertical plane through the eye.
std::array<double, 2> span_of(const scenes::Model& model, const char* name, const Vec3& eye) {
  std::array<double, 2> span = {M_PI, -M_PI};
  const scenes::Mesh& mesh = *std::ranges::find(model.meshes, name, &scenes::Mesh::name);
  for (const scenes::Vertex& v : mesh.vertices) {
    const Vec3 d = Vec3(v.position[0], v.position[1], v.position[2]) - eye;
    if (std::abs(d.x()) > 3e-3) continue;
    const double angle = std::atan2(d.y(), d.z());
    span = {std::min(span[0], angle), std::max(span[1], angle)};
  }
  return span;
}

/// Whoever looks down, or strains, has his eyes open all the same: between the lids a third of the
/// iris' height is seen or more, but for blinks, which are short and seldom.
TEST_F(LongRoutineBody, TheEyesAreOpenButForBlinks) {
  const scenes::Skeleton skeleton(model_);
  const std::size_t head = skeleton.find("Head"), eye = skeleton.find("LeftEye");
  const std::size_t lid = skeleton.find("LeftLid");
  const auto rest = skeleton.poses(skeleton.place(skeleton.upright()));
  const auto leans = [&](const std::vector<Pose>& bones, std::size_t bone) {
    const auto from_rest = [&](std::size_t b) -> Quat {
      return bones[b].rotation * rest[b].rotation.conjugate();
    };
    const Vec3 d = from_rest(head).conjugate() * (from_rest(bone) * Vec3::UnitZ());
    return std::atan2(-d.y(), std::hypot(d.x(), d.z()));
  };
  const std::array<double, 2> iris = span_of(model_, "IrisL", skeleton.rest(eye));
  const double rim = span_of(model_, "LidL", skeleton.rest(eye))[0];
  double lower = M_PI / 2;                  // the lid's rim lies on the lower lid when it is shut
  std::vector<std::array<double, 2>> seen;  // s; share of the iris' height
  std::vector<double> opening;
  each_frame([&](const Instance& i, const std::vector<Pose>& bones) {
    opening.push_back(rim - leans(bones, lid));
    lower = std::min(lower, opening.back());
    seen.push_back({i.time, leans(bones, eye)});
  });
  double shut_since = -1, shut_before = -10;
  int blinks = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    const auto [time, lean] = seen[k];
    const double shown = std::min(iris[1] - lean, opening[k]) - std::max(iris[0] - lean, lower);
    const double share = shown / (iris[1] - iris[0]);
    if (share > 0.35) {
      if (shut_since >= 0) shut_before = time;
      shut_since = -1;
      continue;
    }
    if (shut_since < 0) {
      EXPECT_GT(time - shut_before, 1.5) << time;
      shut_since = time;
      ++blinks;
    }
    EXPECT_LT(time - shut_since, 0.2) << time;
  }
  EXPECT_GT(blinks, 2);
  EXPECT_LT(lower, rim - 0.6);  // the lids do meet
}

}  // namespace
}  // namespace taut::routine_body_test
