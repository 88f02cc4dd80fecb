// The hand around the stick, judged by the deformed skin of the martial artist himself.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "scenes/character/capsules.h"
#include "scenes/character/character.h"
#include "scenes/character/figure.h"
#include "scenes/character/hand.h"
#include "scenes/files/error.h"
#include "scenes/model/load_model.h"
#include "sim/motion/rotation.h"

namespace taut::character_grip {
namespace {

std::shared_ptr<const scenes::Model> artist() {
  static const auto model = std::make_shared<const scenes::Model>(
      scenes::load_model(TAUT_SOURCE_DIR "/assets/martial_artist.glb"));
  return model;
}

std::shared_ptr<const Path> still(const Vec3& position, const Vec3& axis) {
  const Quat rotation = rotation_between(Vec3::UnitY(), axis.normalized());
  return std::make_shared<const Path>(
      std::vector<PathKey>{{0, position, rotation, true}, {1, position, rotation, true}});
}

Vec3 skinned(const scenes::Vertex& v, const scenes::Model& model, const std::vector<Pose>& bones) {
  Vec3 sum = Vec3::Zero();
  for (std::size_t k = 0; k < 4; ++k) {
    if (v.weights[k] == 0) continue;
    const Eigen::Affine3d bind(model.bones[v.bones[k]].inverse_bind.cast<double>());
    sum += double{v.weights[k]} *
           bones[v.bones[k]].to_world(bind * Vec3(v.position[0], v.position[1], v.position[2]));
  }
  return sum;
}

std::size_t strongest_bone(const scenes::Vertex& v) {
  return v.bones[static_cast<std::size_t>(std::max_element(v.weights.begin(), v.weights.end()) -
                                          v.weights.begin())];
}

TEST(CharacterGrip, EveryFingerTouchesTheStickAndNothingEntersIt) {
  const double radius = 0.014;
  const Vec3 centre(-0.28, 1.05, 0.45), axis = Vec3(-0.85, 0.3, 0.43).normalized();
  const auto performance = scenes::make_performance(artist(), {still(centre, axis), 2 * radius}, 1);
  const auto bones = performance->bones_at(0.5);
  std::map<std::string, double> gap;  // by bone, to the stick's surface
  for (const scenes::Mesh& mesh : artist()->meshes) {
    for (const scenes::Vertex& v : mesh.vertices) {
      const std::string name = artist()->bones[strongest_bone(v)].name;
      if (name.rfind("RightHand", 0) != 0) continue;
      const Vec3 p = skinned(v, *artist(), bones) - centre;
      if (std::abs(p.dot(axis)) > 0.10) continue;
      const double distance = p.cross(axis).norm() - radius;
      const auto [entry, fresh] = gap.emplace(name, distance);
      if (!fresh) entry->second = std::min(entry->second, distance);
    }
  }
  ASSERT_EQ(gap.size(), 16u);  // three phalanges of five fingers, and the palm
  double thumb = 1;
  for (const auto& [bone, distance] : gap) {
    EXPECT_GT(distance, -0.001) << bone;
    // The thumb lies on the stick and over the index finger's end.
    if (bone.find("Thumb") == bone.npos) {
      EXPECT_LT(distance, 0.003) << bone;
    } else {
      thumb = std::min(thumb, distance);
    }
  }
  EXPECT_LT(thumb, 0.003);
}

/// Where the joints of a digit are when the hand's fingers are turned so; the hand is at rest.
std::array<Vec3, 4> joints_of(const scenes::Digit& digit,
                              const std::vector<std::pair<std::size_t, Quat>>& fingers) {
  const std::map<std::size_t, Quat> turns(fingers.begin(), fingers.end());
  scenes::DigitTurns turned;
  Quat sum = Quat::Identity();
  for (std::size_t k = 0; k < 3; ++k) turned[k] = sum = sum * turns.at(digit.bones()[k]);
  return digit.joints(turned);
}

TEST(CharacterGrip, AnEmptyHandIsAFistWhoseFingersEndInThePalm) {
  const scenes::Skeleton skeleton(*artist());
  for (const auto side : {scenes::Side::left, scenes::Side::right}) {
    const scenes::HandAxes axes = scenes::hand_axes(skeleton, side);
    const auto fingers = scenes::fist(*artist(), skeleton, side);
    const auto joints = [&](const char* name) {
      return joints_of(scenes::Digit(*artist(), skeleton, side, name), fingers);
    };
    for (const char* name : {"Index", "Middle", "Ring", "Pinky"}) {
      const auto at = joints(name);
      // The last phalanx points into the palm rather than along it, and does not go through it.
      EXPECT_LT((at[3] - at[2]).normalized().dot(axes.palm), -std::sqrt(0.5)) << name;
      EXPECT_GT((at[3] - at[0]).dot(axes.palm), 0) << name;
    }
    // The thumb lies across the fingers, over their backs, no further out than they are wide.
    const auto thumb = joints("Thumb"), index = joints("Index");
    EXPECT_LT((thumb[3] - index[0]).dot(axes.across), 0);
    EXPECT_LT((thumb[3] - index[1]).dot(axes.palm), 0.030);
  }
}

/// The least distance of a finger's two outer phalanges from those of its neighbour, as their skin
/// bends.
double apart(const scenes::Digit& finger, const scenes::Digit& neighbour,
             const std::map<std::size_t, Quat>& turns) {
  const auto bent = [&](const scenes::Digit& digit) {
    scenes::DigitTurns turned;
    Quat sum = Quat::Identity();
    for (std::size_t k = 0; k < 3; ++k) turned[k] = sum = sum * turns.at(digit.bones()[k]);
    scenes::BentSkin skin;
    digit.bend(turned, skin);
    return skin;
  };
  const scenes::BentSkin a = bent(finger), b = bent(neighbour);
  double least = 1;
  for (const std::size_t i : {1, 2})
    for (const std::size_t k : {1, 2})
      for (const Vec3& p : a.part(i))
        for (const Vec3& q : b.part(k)) least = std::min(least, (p - q).norm());
  return least;
}

TEST(CharacterGrip, ClosedFingersLieSideBySide) {
  const scenes::Skeleton skeleton(*artist());
  const auto fist = scenes::fist(*artist(), skeleton, scenes::Side::left);
  const auto grip = scenes::grip_stick(*artist(), skeleton, scenes::Side::right, 0.014).fingers;
  for (const auto& [side, fingers] :
       {std::pair{scenes::Side::left, fist}, {scenes::Side::right, grip}}) {
    const std::map<std::size_t, Quat> turns(fingers.begin(), fingers.end());
    const auto digit = [&](const char* name) {
      return scenes::Digit(*artist(), skeleton, side, name);
    };
    // Vertices are some 2 mm from one another.
    for (const auto& [name, next] :
         {std::pair{"Index", "Middle"}, {"Middle", "Ring"}, {"Ring", "Pinky"}})
      EXPECT_LT(apart(digit(name), digit(next), turns), 0.003) << name << " and " << next;
  }
}

TEST(CharacterGrip, AThickerStickOpensTheFingers) {
  const scenes::Figure thin(*artist(), 0.010), thick(*artist(), 0.018);
  double closed = 0, opened = 0;
  for (std::size_t i = 0; i < thin.grip().fingers.size(); ++i) {
    closed += Eigen::AngleAxisd(thin.grip().fingers[i].second).angle();
    opened += Eigen::AngleAxisd(thick.grip().fingers[i].second).angle();
  }
  EXPECT_LT(opened, closed - 0.5);
}

TEST(CharacterGrip, AModelWithoutABoneIsRefusedByName) {
  auto broken = std::make_shared<scenes::Model>(*artist());
  broken->bones[static_cast<std::size_t>(broken->bone("RightForeArm"))].name = "Stump";
  try {
    scenes::make_performance(broken, {still(Vec3(-0.28, 1.05, 0.45), Vec3::UnitX()), 0.028}, 1);
    FAIL() << "accepted";
  } catch (const scenes::BadAsset& error) {
    EXPECT_EQ(std::string(error.what()).find("martial_artist: has no bone RightForeArm; "), 0u)
        << error.what();
  }
}

TEST(CharacterCapsules, HoldTheSkin) {
  const scenes::Model& model = *artist();
  const auto capsules = scenes::fit_capsules(model);
  std::size_t outside = 0, total = 0;
  for (const scenes::Mesh& mesh : model.meshes) {
    for (const scenes::Vertex& v : mesh.vertices) {
      const Vec3 p(v.position[0], v.position[1], v.position[2]);
      double least = 1;
      for (const scenes::Capsule& c : capsules)
        least = std::min(least, scenes::clearance(c, {p, p, 0, 0}));
      outside += least > 0.01;
      ++total;
    }
  }
  EXPECT_LT(static_cast<double>(outside), 0.01 * static_cast<double>(total));
}

}  // namespace
}  // namespace taut::character_grip
