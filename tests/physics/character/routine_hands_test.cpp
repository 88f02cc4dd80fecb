// The martial artist's hands in the routine, frame by frame, on the skin as it is drawn: the stick
// lies in the palm and in all fingers, the thumb over the index finger, and nothing enters
// anything.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "render/mesh/skinning.h"
#include "scenes/character/capsules.h"
#include "scenes/load/load_scene.h"

namespace taut::routine_hands_test {
namespace {

constexpr double kDegree = M_PI / 180, kStick = 0.014;  // m, radius

using Skin = std::map<std::string, std::vector<Vec3>>;  // by the bone that it moves most with

double gap(const Vec3& p, const scenes::Capsule& c) {
  return scenes::clearance(c, {p, p, 0, 0});
}

/// The least distance of skin from a capsule's surface.
double gap(const std::vector<Vec3>& skin, const scenes::Capsule& c) {
  double least = 1;
  for (const Vec3& p : skin) least = std::min(least, gap(p, c));
  return least;
}

class LongRoutineHands : public testing::Test {
 protected:
  /// Calls use(time, bones) for every frame, or every so many.
  template <typename Use>
  void each_frame(Use use, int stride = 1) const {
    for (int k = 0; k < scene_.frames(); k += stride)
      use(double(k) / scene_.fps, scene_.performances[0]->bones_at(double(k) / scene_.fps));
  }

  /// The skin of one hand.
  Skin skin_of(const std::string& mesh, const std::vector<Pose>& bones) const {
    const scenes::Mesh& hand = *std::ranges::find(model_.meshes, mesh, &scenes::Mesh::name);
    std::vector<mesh::MovingVertex> vertices;
    skin(hand, mesh::bone_matrices(model_, bones), vertices);
    Skin result;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const scenes::Vertex& v = hand.vertices[i];
      const auto most = std::size_t(std::ranges::max_element(v.weights) - v.weights.begin());
      result[model_.bones[v.bones[most]].name].push_back(vertices[i].position.cast<double>());
    }
    return result;
  }

  /// A finger's outer two phalanges as capsules, half as thick as its skin lies from them.
  std::vector<scenes::Capsule> phalanges(const Skin& skin, const std::string& finger,
                                         const std::vector<Pose>& bones) const {
    std::vector<scenes::Capsule> result;
    for (const int k : {2, 3}) {
      const std::string name = finger + std::to_string(k);
      const Vec3 from = joint(bones, name);
      Vec3 to = from;
      if (k == 2) {
        to = joint(bones, finger + "3");
      } else {
        for (const Vec3& p : skin.at(name))
          if ((p - from).norm() > (to - from).norm()) to = p;
        to = from + 0.7 * (to - from);
      }
      std::vector<double> off;
      for (const Vec3& p : skin.at(name)) off.push_back(gap(p, {from, to, 0, 0}));
      std::ranges::nth_element(off, off.begin() + std::ssize(off) / 2);
      result.push_back({from, to, off[off.size() / 2], 0});
    }
    return result;
  }

  Vec3 joint(const std::vector<Pose>& bones, const std::string& name) const {
    return bones[std::size_t(model_.bone(name))].position;
  }

  const scenes::Scene scene_ = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/nunchaku.toml", true);
  const scenes::Model& model_ = *scene_.stage->characters[0];
};

/// How far off a stick may be, m.
struct Range {
  double least, most;
};
constexpr Range kPalm{-0.0015, 0.005}, kFinger{-0.001, 0.003};
bool within(double x, const Range& range) {
  return x > range.least && x < range.most;
}

/// The frames in which a hand does not hold the held stick, moved by `off` (m) in the hand's axes
/// at rest.
class LongHolding : public LongRoutineHands {
 protected:
  std::string failures(int stride, const Vec3& off = Vec3::Zero()) const {
    const Body& held = scene_.world.bodies[0];
    std::string found;
    each_frame(
        [&](double time, const std::vector<Pose>& bones) {
          const Pose path = held.path->at(time).pose();
          const Vec3 axis = path.rotation * Vec3::UnitY();
          const Vec3 middle = path.position - path.rotation * held.grip + away(bones, off);
          const scenes::Capsule wood{middle - 0.14 * axis, middle + 0.14 * axis, kStick, 0};
          const Skin skin = skin_of("HandR", bones);
          const auto expect = [&](const std::string& part, double x, const Range& range) {
            if (!within(x, range) && found.size() < 300)
              found += fmt::format("{} {:.4f} m at {}\n", part, x, time);
          };
          for (const std::string finger : {"Index", "Middle", "Ring", "Pinky"}) {
            const double at = (joint(bones, "RightHand" + finger + "1") - middle).dot(axis);
            std::vector<Vec3> palm;  // under this finger
            for (const Vec3& p : skin.at("RightHand"))
              if (std::abs((p - middle).dot(axis) - at) < 0.008) palm.push_back(p);
            expect("palm under " + finger, gap(palm, wood), kPalm);
            for (const std::string phalanx : {"1", "2", "3"})
              expect(finger + phalanx, gap(skin.at("RightHand" + finger + phalanx), wood), kFinger);
          }
          expect("web", gap(web(skin, middle, axis, bones), wood), kPalm);
          for (const std::string phalanx : {"1", "2", "3"})
            expect("Thumb" + phalanx, gap(skin.at("RightHandThumb" + phalanx), wood),
                   {kFinger.least, 1});
        },
        stride);
    return found;
  }

 private:
  /// Between thumb and index finger, beyond the index finger's root by more than the finger is half
  /// wide: no daylight is seen between it and the stick.
  std::vector<Vec3> web(const Skin& skin, const Vec3& middle, const Vec3& axis,
                        const std::vector<Pose>& bones) const {
    const double at = (joint(bones, "RightHandIndex1") - middle).dot(axis) + 0.015;
    std::vector<Vec3> found;
    for (const std::string part : {"RightHand", "RightHandThumb1"})
      for (const Vec3& p : skin.at(part))
        if (std::abs((p - middle).dot(axis) - at) < 0.004) found.push_back(p);
    return found;
  }

  /// From the wrist to the middle knuckle, to the thumb's side, and out of the palm.
  Vec3 away(const std::vector<Pose>& bones, const Vec3& off) const {
    const Vec3 along = (joint(bones, "RightHandMiddle1") - joint(bones, "RightHand")).normalized();
    const Vec3 to_thumb = joint(bones, "RightHandIndex1") - joint(bones, "RightHandPinky1");
    const Vec3 across = (to_thumb - to_thumb.dot(along) * along).normalized();
    return off.x() * along + off.y() * across + off.z() * across.cross(along);
  }
};

TEST_F(LongHolding, TheStickLiesInThePalmAndInEveryFinger) {
  EXPECT_EQ(failures(3), "");
}

TEST_F(LongHolding, AStickSomeMillimetresOffIsSeen) {
  for (const double off : {-0.015, -0.004, 0.004, 0.015}) {
    EXPECT_NE(failures(400, Vec3(off, 0, 0)), "") << off;
    EXPECT_NE(failures(400, Vec3(0, 0, off)), "") << off;
  }
}

TEST_F(LongRoutineHands, ThumbsLieOverTheFingersAndEnterNone) {
  each_frame(
      [&](double time, const std::vector<Pose>& bones) {
        for (const std::string side : {"Right", "Left"}) {
          const Skin skin = skin_of(side == "Right" ? "HandR" : "HandL", bones);
          const std::string hand = side + "Hand";
          double over = 1;
          for (const char* finger : {"Index", "Middle", "Ring", "Pinky"})
            for (const scenes::Capsule& c : phalanges(skin, hand + finger, bones)) {
              const double off = gap(skin.at(hand + "Thumb3"), c);
              EXPECT_GT(off, -0.002) << side << finger << time;
              if (side == "Left" || finger == std::string("Index")) over = std::min(over, off);
            }
          EXPECT_LT(over, 0.003) << side << time;
        }
      },
      6);
}

TEST_F(LongRoutineHands, WristsBendLessThan45Degrees) {
  each_frame([&](double time, const std::vector<Pose>& bones) {
    for (const std::string side : {"Right", "Left"}) {
      const Vec3 elbow = joint(bones, side + "ForeArm"), wrist = joint(bones, side + "Hand");
      const Vec3 arm = wrist - elbow, hand = joint(bones, side + "HandMiddle1") - wrist;
      EXPECT_LT(std::atan2(arm.cross(hand).norm(), arm.dot(hand)), 45 * kDegree) << side << time;
    }
  });
}

/// Hands against the trunk, the head and the legs, with what they wear. The jacket is flatter than
/// the capsule that holds it: of what is inside of that the jacket's surface decides.
TEST_F(LongRoutineHands, EnterNothingThatHeWears) {
  const auto fitted = scenes::fit_capsules(model_);
  const scenes::Mesh& jacket = *std::ranges::find(model_.meshes, "Jacket", &scenes::Mesh::name);
  const auto is_sleeve = [&](std::size_t vertex) {
    const scenes::Vertex& v = jacket.vertices[vertex];
    const auto most = std::size_t(std::ranges::max_element(v.weights) - v.weights.begin());
    const std::string& bone = model_.bones[v.bones[most]].name;
    return bone.find("Arm") != bone.npos || bone.find("Hand") != bone.npos ||
           bone.find("Cuff") != bone.npos;
  };
  std::vector<mesh::MovingVertex> cloth;
  const auto out_of_jacket = [&](const Vec3& p) {
    double least = 1, out = 1;
    for (std::size_t i = 0; i < cloth.size(); ++i) {
      const Vec3 off = p - cloth[i].position.cast<double>();
      if (off.norm() > least || is_sleeve(i)) continue;
      least = off.norm();
      out = off.dot(cloth[i].normal.cast<double>());
    }
    return out;
  };
  each_frame(
      [&](double time, const std::vector<Pose>& bones) {
        const auto placed = scenes::place_capsules(fitted, model_, bones);
        cloth.clear();
        for (const char* mesh : {"HandR", "HandL"})
          for (const auto& [bone, skin] : skin_of(mesh, bones)) {
            if (bone.find("Hand") == bone.npos) continue;
            for (const scenes::Capsule& part : placed) {
              const std::string& name = model_.bones[part.bone].name;
              if (name.find("Arm") != name.npos || name.find("Hand") != name.npos ||
                  name.find("Shoulder") != name.npos)
                continue;
              if (name != "Chest") {
                EXPECT_GT(gap(skin, part), 0) << bone << " in " << name << time;
                continue;
              }
              if (gap(skin, part) > 0) continue;
              if (cloth.empty()) mesh::skin(jacket, mesh::bone_matrices(model_, bones), cloth);
              for (const Vec3& p : skin)
                ASSERT_GT(out_of_jacket(p), kFinger.least) << bone << " in the jacket at " << time;
            }
          }
      },
      30);
}

}  // namespace
}  // namespace taut::routine_hands_test
