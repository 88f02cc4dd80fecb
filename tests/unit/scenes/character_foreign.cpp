// Characters of others: their names of bones, skeletons with fewer bones, and animations.
#include <gtest/gtest.h>

#include <cmath>

#include "scenes/character/character.h"
#include "scenes/character/hand.h"
#include "scenes/character/skeleton.h"
#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "scenes/model/load_model.h"
#include "sim/motion/rotation.h"
#include "sim/run/simulation.h"
#include "tests/support/folder.h"
#include "tests/unit/scenes/model_files.h"

namespace taut::character_foreign {
namespace {

using nlohmann::json;
using scenes::Model;

/// A figure of the needed bones alone, arms straight to the sides, palms down.
Model bare_figure() {
  Model model;
  model.name = "figure";
  const auto add = [&](const std::string& name, const char* parent, const Vec3& at) {
    scenes::Bone bone;
    bone.name = name;
    bone.parent = model.bone(parent);
    Vec3 above = Vec3::Zero();
    for (int i = bone.parent; i >= 0; i = model.bones[std::size_t(i)].parent)
      above += model.bones[std::size_t(i)].rest.position;
    bone.rest.position = at - above;
    bone.inverse_bind.topRightCorner<3, 1>() = -at.cast<float>();
    model.bones.push_back(bone);
  };
  add("Hips", "", {0, 0.95, 0});
  add("Spine", "Hips", {0, 1.05, 0});
  add("Head", "Spine", {0, 1.55, 0});
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "Left" : "Right";
    add(name + "Arm", "Spine", {0.18 * side, 1.42, 0});
    add(name + "ForeArm", (name + "Arm").c_str(), {0.46 * side, 1.42, 0});
    add(name + "Hand", (name + "ForeArm").c_str(), {0.72 * side, 1.42, 0});
    add(name + "UpLeg", "Hips", {0.10 * side, 0.92, 0});
    add(name + "Leg", (name + "UpLeg").c_str(), {0.10 * side, 0.50, 0});
    add(name + "Foot", (name + "Leg").c_str(), {0.10 * side, 0.08, 0});
  }
  return model;
}

std::string complaint_about(const Model& model) {
  try {
    scenes::check_bones(model);
  } catch (const scenes::BadAsset& error) {
    return error.what();
  }
  return "accepted";
}

std::shared_ptr<const Path> still(const Vec3& position, const Vec3& axis) {
  const Quat rotation = rotation_between(Vec3::UnitY(), axis.normalized());
  return std::make_shared<const Path>(
      std::vector<PathKey>{{0, position, rotation, true}, {1, position, rotation, true}});
}

TEST(CharacterForeign, AFigureWithoutFingersShouldersAndNeckHoldsAStick) {
  const auto model = std::make_shared<const Model>(bare_figure());
  const Vec3 centre(-0.25, 1.1, 0.4), axis = Vec3(-0.8, 0.5, 0.3).normalized();
  const auto performance = scenes::make_performance(model, {still(centre, axis), 0.03}, 1);
  const std::vector<Pose> bones = performance->bones_at(0.5);
  const auto at = [&](const char* name) { return bones[std::size_t(model->bone(name))]; };
  // The stick lies before the palm, as the hand is turned.
  const scenes::Skeleton skeleton(*model);
  const scenes::Grip grip = scenes::grip_stick(*model, skeleton, scenes::Side::right, 0.015);
  const Pose hand = at("RightHand");
  EXPECT_LT((hand.position + hand.rotation * grip.centre - centre).norm(), 1e-9);
  EXPECT_LT((hand.rotation * grip.axis - axis).norm(), 1e-9);
  // Palms look down at rest, the thumb's side to the front.
  EXPECT_LT((grip.axis - Vec3::UnitZ()).norm(), 1e-9);
  EXPECT_LT(grip.centre.y(), 0);
  // Limbs keep their lengths, and elbow and knee bend as people's do.
  const Vec3 shoulder = at("RightArm").position, elbow = at("RightForeArm").position;
  EXPECT_NEAR((elbow - shoulder).norm(), 0.28, 1e-9);
  EXPECT_NEAR((hand.position - elbow).norm(), 0.26, 1e-9);
  EXPECT_LT(elbow.y(), std::max(shoulder.y(), hand.position.y()));
  const Vec3 hip = at("LeftUpLeg").position, knee = at("LeftLeg").position,
             foot = at("LeftFoot").position;
  EXPECT_GT((knee - (hip + foot) / 2).dot(at("LeftFoot").rotation * Vec3::UnitZ()), 0);
  // What was the front of a straight elbow at rest is its inside.
  const Vec3 inside = at("RightForeArm").rotation * Vec3::UnitZ();
  EXPECT_GT(inside.dot((shoulder + hand.position) / 2 - elbow), 0);
}

TEST(CharacterForeign, AllMissingBonesAreNamedAtOnce) {
  Model model = bare_figure();
  EXPECT_EQ(complaint_about(model), "accepted");
  for (const char* name : {"RightForeArm", "Head", "LeftFoot"})
    model.bones[std::size_t(model.bone(name))].name += "_x";
  const std::string said = complaint_about(model);
  EXPECT_EQ(said.find("figure: has no bones Head, LeftFoot, RightForeArm; a table bones = { Head = "
                      "\"...\" } says which they are; it has: Hips, Spine, Head_x, LeftArm"),
            0u)
      << said;
  scenes::rename_bones(
      model, {{"RightForeArm", "RightForeArm_x"}, {"Head", "Head_x"}, {"LeftFoot", "LeftFoot_x"}});
  EXPECT_EQ(complaint_about(model), "accepted");
  try {
    scenes::rename_bones(model, {{"Neck", "neck_01"}, {"Head", "Head"}, {"Jaw", "jaw"}});
    ADD_FAILURE() << "accepted";
  } catch (const scenes::BadAsset& error) {
    EXPECT_STREQ(error.what(), "figure: has no bones \"neck_01\", \"jaw\"");
  }
}

TEST(CharacterForeign, NamesOfMixamo) {
  for (const char* prefix : {"mixamorig:", "mixamorig7:", "mixamorig_", "mixamorig"}) {
    Model model = bare_figure();
    for (scenes::Bone& bone : model.bones) bone.name = prefix + bone.name;
    EXPECT_NE(complaint_about(model).find("; bones = \"mixamo\" finds them"), std::string::npos)
        << complaint_about(model);
    model.bones.push_back(model.bones[1]);
    model.bones.back().name = std::string(prefix) + "Spine2";
    model.bones.push_back(model.bones[1]);
    model.bones.back().name = "Chest";  // of clothes, say
    scenes::rename_bones(model, scenes::mixamo_names(model));
    EXPECT_EQ(complaint_about(model), "accepted");
    EXPECT_EQ(model.bone("Chest"), int(model.bones.size()) - 2);
  }
}

/// Two joints and a hand, in centimetres, of which the second turns; by 10 frames a second.
constexpr const char* kBvh = R"(HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT RightForeArm
  {
    OFFSET -20 40 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightHand
    {
      OFFSET -30 0 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET -10 0 0
      }
    }
  }
}
MOTION
Frames: 3
Frame Time: 0.1
0 100 0  0 0 0  0 0 0   0 0 0
10 100 0  0 0 0  90 0 0  0 0 0
20 100 0  0 0 0  90 0 90 0 0 0
)";

TEST(CharacterForeign, MotionCaptureMovesItsSkeleton) {
  const Folder folder;
  Model read = scenes::load_model(folder.write("a.bvh", kBvh));
  scenes::enlarge(read, 0.01);
  const auto model = std::make_shared<const Model>(std::move(read));
  ASSERT_EQ(model->bones.size(), 3u);
  EXPECT_EQ(model->meshes.at(0).indices.size(), 3u * 8 * 3);  // a rod for each
  const auto performance = scenes::play_animation(model, {}, 0);
  const auto hand = [&](double time) { return performance->limb_at(2, time); };
  EXPECT_LT((hand(0).position - Vec3(-0.5, 1.4, 0)).norm(), 1e-6);
  EXPECT_LT((hand(-1).position - hand(0).position).norm(), 1e-12);
  // A quarter turn about z takes -x to -y.
  EXPECT_LT((hand(0.1).position - Vec3(-0.1, 1.1, 0)).norm(), 1e-6);
  const double half = std::sqrt(0.5);
  EXPECT_LT((hand(0.05).position - Vec3(-0.15 - 0.3 * half, 1.4 - 0.3 * half, 0)).norm(), 1e-6);
  // Angles follow each other as the channels do: then about the y axis that has been turned.
  EXPECT_LT((hand(0.2).position - Vec3(0, 1.4, 0.3)).norm(), 1e-6);
  EXPECT_LT((hand(9).position - hand(0.2).position).norm(), 1e-12);

  // Placed elsewhere, later and at half the speed.
  const Pose place{{1, 0, 0}, Quat(Eigen::AngleAxisd(M_PI, Vec3::UnitY()))};
  const auto other = scenes::play_animation(model, {0, 0.05, 0.5, place}, 0);
  EXPECT_LT((other->limb_at(2, 0.1).position - place.to_world(hand(0.1).position)).norm(), 1e-9);

  // What the hand holds lies across it and goes along.
  const Path held = scenes::held_path(*performance, *model, 0.03, 0.2);
  const Vec3 lies = held.at(0).position - hand(0).position;
  EXPECT_LT(lies.norm(), 0.2);
  EXPECT_LT((held.at(0.1).position - (hand(0.1).position + hand(0.1).rotation * lies)).norm(),
            1e-6);
  EXPECT_LT((held.at(0).rotation * Vec3::UnitY() - Vec3::UnitZ()).norm(), 1e-9);
}

TEST(CharacterForeign, BrokenMotionCaptureIsRefusedWithItsLine) {
  const Folder folder;
  const auto said = [&](const std::string& from, const std::string& to) {
    std::string text = kBvh;
    text.replace(text.find(from), from.size(), to);
    try {
      scenes::load_model(folder.write("a.bvh", text));
    } catch (const scenes::BadAsset& error) {
      return std::string(error.what()).substr(folder.path().string().size() + 1);
    }
    return std::string("accepted");
  };
  EXPECT_EQ(said("HIERARCHY", "HIERARCHX"),
            "a.bvh: line 1: found \"HIERARCHX\", expected HIERARCHY");
  EXPECT_EQ(said("OFFSET -20", "OFFSET nan"), "a.bvh: line 8: found \"nan\", expected a number");
  EXPECT_EQ(said("Zrotation Xrotation", "Wrotation Xrotation"),
            "a.bvh: line 5: found \"Wrotation\", expected Xposition, Yposition, Zposition, "
            "Xrotation, Yrotation or Zrotation");
  EXPECT_EQ(said("Frames: 3", "Frames: 4"), "a.bvh: line 27: found \"\", expected a number");
  EXPECT_EQ(said("Frames: 3", "Frames: 2"),
            "a.bvh: line 26: found \"20\" after the last of 2 frames");
  EXPECT_EQ(said("Frames: 3", "Frames: 1000000"),
            "a.bvh: line 22: its frames have more than 16777216 numbers");
  EXPECT_EQ(said("Frame Time: 0.1", "Frame Time: 0"),
            "a.bvh: line 23: expected a Frame Time above 0 s");
  EXPECT_EQ(said("MOTION", "ROOT a { OFFSET 0 0 0 } MOTION"), "accepted");
  EXPECT_EQ(said("Hips\n{", "My Hips {"), "accepted");
}

TEST(CharacterForeign, AnimationsOfGltfMoveBones) {
  const Folder folder;
  Gltf g = skinned();
  const auto times = g.add<float>({0, 1, 3}, 5126, "SCALAR", 1);
  const float half = std::sqrt(0.5f);
  const auto turns = g.add<float>({0, 0, 0, 1, 0, 0, half, half, 0, 0, 1, 0}, 5126, "VEC4", 4);
  const auto places = g.add<float>({0, 1, 0, 0, 2, 0, 5, 2, 0}, 5126, "VEC3", 3);
  // Between a tangent in and a tangent out.
  const auto smooth = g.add<float>(
      {0, 0, 0, 0, 0.5f, 0, 0, 0, 0, 0, 0, 0, 1, 0.5f, 0, 0, 0, 0, 0, 0, 0, 1, 0.5f, 0, 0, 0, 0},
      5126, "VEC3", 3);
  const auto sizes = g.add<float>({1, 1, 1, 1, 1, 1, 2, 1, 1}, 5126, "VEC3", 3);
  g.json["animations"] = {
      {{"name", "Turn"},
       {"samplers",
        {{{"input", times}, {"output", turns}},
         {{"input", times}, {"output", places}, {"interpolation", "STEP"}},
         {{"input", times}, {"output", smooth}, {"interpolation", "CUBICSPLINE"}},
         {{"input", times}, {"output", sizes}}}},
       {"channels",
        {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "rotation"}}}},
         {{"sampler", 1}, {"target", {{"node", 1}, {"path", "translation"}}}},
         {{"sampler", 2}, {"target", {{"node", 2}, {"path", "translation"}}}},
         {{"sampler", 3}, {"target", {{"node", 3}, {"path", "scale"}}}},
         {{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
  const auto model =
      std::make_shared<const Model>(scenes::load_model(folder.write("a.glb", g.bytes())));
  ASSERT_EQ(model->animations.size(), 1u);
  EXPECT_EQ(model->animations[0].name, "Turn");
  EXPECT_EQ(model->left_out.size(), 2u);  // scales, morph targets
  const auto performance = scenes::play_animation(model, {}, 0);
  const auto tip = [&](double time) { return performance->limb_at(1, time).position; };
  EXPECT_LT((tip(0) - Vec3(0, 1.5, 0)).norm(), 1e-6);
  // A quarter turn about z takes y to -x; the root steps, the tip eases from 0 to 1 m aside.
  EXPECT_LT((performance->limb_at(0, 0.99).position - Vec3(0, 1, 0)).norm(), 1e-6);
  EXPECT_LT((tip(1) - Vec3(-0.5, 3, 0)).norm(), 1e-6);
  const Quat eighth(Eigen::AngleAxisd(M_PI / 4, Vec3::UnitZ()));
  EXPECT_LT((tip(0.5) - (Vec3(0, 1, 0) + eighth * Vec3(0.5, 0.5, 0))).norm(), 1e-6);

  // The same in centimetres below a node that makes metres of it.
  g.json["nodes"].push_back(
      {{"name", "Armature"}, {"scale", {0.01, 0.01, 0.01}}, {"children", {1}}});
  g.json["scenes"][0]["nodes"] = {0, 4};
  const auto small =
      std::make_shared<const Model>(scenes::load_model(folder.write("b.glb", g.bytes())));
  const auto slow = scenes::play_animation(small, {0, 0.25, 0.5, {}}, 0);
  EXPECT_LT((slow->limb_at(std::size_t(small->bone("Tip")), 0.5).position -
             0.01 * (Vec3(0, 1, 0) + eighth * Vec3(0.5, 0.5, 0)))
                .norm(),
            1e-8);

  g.json["animations"][0]["samplers"][0]["output"] = places;
  EXPECT_THROW(scenes::load_model(folder.write("c.glb", g.bytes())), scenes::BadAsset);
}

TEST(CharacterForeign, MoreMovingNodesThanBonesAreAModelAtRest) {
  const Folder folder;
  Gltf g = triangle();
  const auto times = g.add<float>({0, 1}, 5126, "SCALAR", 1);
  const auto places = g.add<float>({0, 0, 0, 1, 0, 0}, 5126, "VEC3", 3);
  json channels = json::array();
  for (std::size_t i = 1; i <= 300; ++i) {
    g.json["nodes"].push_back(json::object());
    g.json["scenes"][0]["nodes"].push_back(i);
    channels.push_back({{"sampler", 0}, {"target", {{"node", i}, {"path", "translation"}}}});
  }
  g.json["animations"] = {
      {{"samplers", {{{"input", times}, {"output", places}}}}, {"channels", channels}}};
  const Model model = scenes::load_model(folder.write("a.glb", g.bytes()));
  EXPECT_EQ(model.bones.size(), 0u);
  EXPECT_EQ(model.animations.size(), 0u);
  ASSERT_EQ(model.left_out.size(), 1u);
  EXPECT_NE(model.left_out[0].find("left out: animations ("), std::string::npos);
  EXPECT_NE(model.left_out[0].find("more than 256 bones)"), std::string::npos);
}

TEST(CharacterForeign, ARopeHangsOnTheHandOfMotionCapture) {
  const Folder folder;
  folder.write("a.bvh", kBvh);
  const auto file = folder.write("scene.toml", R"(duration = 0.2
[characters.dancer]
mesh = "a.bvh"
scale = 0.01
animation = { position = [0, 0, 1] }
[bodies.stick]
mass = 0.1
shape = { cylinder = { length = 0.3, diameter = 0.03 } }
driven_by = { character = "dancer", hand = "right" }
[connectors.rope]
length = 0.4
mass = 0.1
particles = 9
from = { character = "dancer", bone = "RightHand", point = [-0.1, 0, 0] }
to = { free = true }
start = { direction = [0, -1, 0] }
[connectors.cord]
length = 0.4
mass = 0.1
particles = 9
from = { body = "stick", point = [0, 0.15, 0] }
to = { free = true }
start = { direction = [0, -1, 0] }
[stage]
)");
  const scenes::Scene scene = scenes::load_scene(file, true);
  Simulation simulation = scenes::start(scene);
  simulation.advance_to(0.1);
  // The hand and what it holds are turned by a quarter then, from -x to -y.
  EXPECT_LT((simulation.world().connectors[0].position.front() - Vec3(-0.1, 1.0, 1)).norm(), 1e-4);
  const Pose stick = scene.world.bodies[0].path->at(0.1).pose();
  EXPECT_LT(
      (simulation.world().connectors[1].position.front() - stick.to_world(Vec3(0, 0.15, 0))).norm(),
      1e-6);
}

}  // namespace
}  // namespace taut::character_foreign
