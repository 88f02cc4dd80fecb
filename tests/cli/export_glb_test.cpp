// Animated glTF files, played by a reader of the test's own: everything is where the simulation had
// it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "render/export/frame_writer.h"
#include "render/mesh/skinning.h"
#include "scenes/load/load_scene.h"
#include "scenes/model/load_model.h"
#include "tests/cli/export_scenes.h"
#include "tests/cli/kept_states.h"
#include "tests/support/folder.h"
#include "tests/support/glb.h"
#include "tests/support/program.h"

namespace taut {
namespace {

constexpr double kAtFrames = 1e-6, kBetween = 1e-4;  // m

class GlbMotion : public testing::TestWithParam<const char*> {};

TEST_P(GlbMotion, ParticlesAndBodiesAreWhereTheSimulationHadThem) {
  const scenes::Scene scene = scene_of(GetParam());
  const GlbFile file(exported(scene, exporting::glb_writer));
  const World world = divided(scene.world, scene.timeline);
  const std::vector<double> radii = exporting::bounding_radii(scene);
  const std::vector<double> keys = file.keys();
  double at_frames = 0, between = 0, bodies = 0;
  std::size_t frame = 0;
  for (const exporting::ExportState& state : states_of(scene)) {
    // A key's time is a float.
    const double time = state.frame ? double(float(state.state.time)) : state.state.time;
    if (state.frame) {
      EXPECT_TRUE(std::ranges::binary_search(keys, time)) << "frame " << frame;
    }
    frame += state.frame;
    double& error = state.frame ? at_frames : between;
    for (std::size_t c = 0; c < world.connectors.size(); ++c)
      for (std::size_t i = 0; i < world.connectors[c].particles(); ++i) {
        const std::size_t node = file.node(fmt::format("{}.{}", world.connectors[c].name, i));
        error = std::max(
            error, (file.world(node, time).translation() - state.state.connectors[c][i]).norm());
      }
    for (std::size_t b = 0; b < world.bodies.size(); ++b) {
      const Eigen::Affine3d place = file.world(file.node(world.bodies[b].name), time);
      for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
        const Vec3 point = radii[b] * axis;
        const double off = (place * point - state.state.bodies[b].to_world(point)).norm();
        bodies = std::max(bodies, off);
        if (state.frame) at_frames = std::max(at_frames, off);
      }
    }
  }
  EXPECT_EQ(int(frame), scene.frames());
  EXPECT_LT(at_frames, kAtFrames);
  EXPECT_LT(between, kBetween);
  EXPECT_LT(bodies, kBetween);
  EXPECT_GT(between, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, GlbMotion,
                         testing::Values("rope_swing.toml", "two_bodies.toml", "rope_drop.toml"));

TEST(GlbExport, PartsOfACutRopeAreWhereTheyAre) {
  Folder folder;
  scenes::Scene scene = scenes::load_scene(folder.write("cut.toml", kPinnedAndCut), true);
  const GlbFile file(exported(scene, exporting::glb_writer));
  for (const exporting::ExportState& state : states_of(scene)) {
    const double time = state.frame ? double(float(state.state.time)) : state.state.time;
    const char* names[] = {"cord", "rope", "rope'"};
    for (std::size_t c = 0; c < 3; ++c)
      for (std::size_t i = 0; i < state.state.connectors[c].size(); ++i)
        ASSERT_LT((file.world(file.node(fmt::format("{}.{}", names[c], i)), time).translation() -
                   state.state.connectors[c][i])
                      .norm(),
                  state.frame ? kAtFrames : kBetween);
  }
}

// Whatever happens between frames, and however the method chooses its steps: a rope caught by a pin
// soon goes another way after the smallest change.
TEST(GlbExport, FramesAreThoseOfARunThatStopsAtNothingElse) {
  const scenes::Scene scene = scene_of("pin.toml");
  ASSERT_EQ(scene.method.name, "direct");
  const GlbFile file(exported(scene, exporting::glb_writer));
  Simulation simulation = scenes::start(scene);
  const std::size_t first = file.node("rope.0");
  for (int frame = 0; frame < scene.frames(); ++frame) {
    simulation.advance_to(double(frame) / scene.fps);
    if (frame % 7 != 0) continue;
    const std::vector<Vec3> shown = simulation.state().connectors[0];
    for (std::size_t i = 0; i < shown.size(); ++i)
      ASSERT_LT(
          (file.world(first + i, double(float(double(frame) / scene.fps))).translation() - shown[i])
              .norm(),
          kAtFrames)
          << "frame " << frame << ", particle " << i;
  }
}

// The rings of a tube that belong to one particle alone are circles about it.
TEST(GlbExport, ATubeGoesThroughItsParticles) {
  const scenes::Scene scene = scene_of("rope_swing.toml");
  const GlbFile file(exported(scene, exporting::glb_writer));
  const std::size_t tube = file.node("rope tube");
  const auto& attributes = file.attributes_of(tube, 0);
  const auto joints = file.numbers(attributes["JOINTS_0"]);
  const auto weights = file.numbers(attributes["WEIGHTS_0"]);
  const double radius = scene.stage->connector_looks[0].diameter / 2;
  for (const double time : {0.0, 0.4, 0.75}) {
    const std::vector<Vec3> vertices = file.skinned(tube, 0, time);
    for (std::size_t particle = 1; particle < 20; ++particle) {
      Vec3 sum = Vec3::Zero();
      int count = 0;
      const Vec3 middle =
          file.world(file.node(fmt::format("rope.{}", particle)), time).translation();
      for (std::size_t i = 0; i < vertices.size(); ++i)
        for (std::size_t k = 4 * i; k < 4 * i + 4; ++k)
          if (weights[k] > 0.9999 && joints[k] == double(particle)) {
            sum += vertices[i];
            ++count;
            EXPECT_NEAR((vertices[i] - middle).norm(), radius, 2e-6);
          }
      ASSERT_GE(count, 8);
      EXPECT_LT((sum / count - middle).norm(), 2e-6);
    }
  }
}

// Blender's rest pose is that of the nodes: there a tube has to be as its mesh is, also at an end
// that never moves.
TEST(GlbExport, ATubesJointsRestWhereItsMeshWasMade) {
  for (const char* name : {"rope_swing.toml", "hose.toml"}) {
    const GlbFile file(exported(scene_of(name), exporting::glb_writer));
    ASSERT_FALSE(file.root()["skins"].empty());
    for (const auto& skin : file.root()["skins"]) {
      const auto inverse = file.numbers(skin["inverseBindMatrices"]);
      for (std::size_t k = 0; k < skin["joints"].size(); ++k) {
        const Eigen::Matrix4d bind = file.resting(skin["joints"][k]).matrix() *
                                     Eigen::Map<const Eigen::Matrix4d>(inverse.data() + 16 * k);
        EXPECT_LT((bind - Eigen::Matrix4d::Identity()).norm(), 1e-6) << name << ' ' << k;
      }
    }
  }
}

class DemoGlb : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = new scenes::Scene(scene_of("nunchaku.toml"));
    scene_->stage->scenery.clear();
    bytes_ = new std::string(exported(*scene_, exporting::glb_writer));
  }
  static void TearDownTestSuite() {
    delete scene_;
    delete bytes_;
  }
  static scenes::Scene* scene_;
  static std::string* bytes_;
};
scenes::Scene* DemoGlb::scene_ = nullptr;
std::string* DemoGlb::bytes_ = nullptr;

TEST_F(DemoGlb, IsSmall) {
  EXPECT_LT(bytes_->size(), 4'000'000u);
}

TEST_F(DemoGlb, ChainAndSticksAreWhereTheSimulationHadThem) {
  const GlbFile file(*bytes_);
  double at_frames = 0, between = 0, links = 0;
  std::size_t count = 0;
  const std::size_t first = file.node("chain.0"), link = file.node("chain link 0");
  for (const exporting::ExportState& state : states_of(*scene_)) {
    if (!state.frame && ++count % 8 != 0) continue;  // enough of them
    const double time = state.frame ? double(float(state.state.time)) : state.state.time;
    const auto& particles = state.state.connectors[0];
    for (std::size_t i = 0; i < particles.size(); ++i) {
      double& error = state.frame ? at_frames : between;
      error = std::max(error, (file.world(first + i, time).translation() - particles[i]).norm());
    }
    // A link ends where the next particle is.
    if (!state.frame) continue;
    const double length = (particles[1] - particles[0]).norm();
    links = std::max(links, (file.world(link, time) * Vec3(0, length, 0) - particles[1]).norm());
  }
  EXPECT_EQ(first + 10, file.node("chain.10"));
  EXPECT_LT(at_frames, kAtFrames);
  EXPECT_LT(between, kBetween);
  EXPECT_LT(links, 1e-5);
}

TEST_F(DemoGlb, TheSkinIsThatOfThePictures) {
  const GlbFile file(*bytes_);
  const scenes::Model& model = *scene_->stage->characters[0];
  const std::size_t skin_node = file.node("character skin");
  for (const int frame : {0, 200, 600}) {
    const double time = double(frame) / scene_->fps;
    const auto bones = mesh::bone_matrices(model, scene_->performances[0]->bones_at(time));
    std::vector<mesh::MovingVertex> expected;
    for (const std::size_t mesh : {std::size_t(0), std::size_t(7)}) {
      mesh::skin(model.meshes[mesh], bones, expected);
      const std::vector<Vec3> vertices = file.skinned(skin_node, mesh, double(float(time)));
      ASSERT_EQ(vertices.size(), expected.size());
      double most = 0;
      for (std::size_t i = 0; i < vertices.size(); ++i)
        most = std::max(most, (vertices[i] - expected[i].position.cast<double>()).norm());
      EXPECT_LT(most, 2e-4) << "mesh " << mesh << ", frame " << frame;
    }
  }
}

TEST_F(DemoGlb, CamerasAndTheLightLookWhereTheStageSays) {
  const GlbFile file(*bytes_);
  const std::vector<scenes::CameraKey>& keys = scene_->stage->shots[0].camera;
  const std::size_t node = file.node("camera of shot 1");
  for (const double time : {0.0, 2.5}) {
    const scenes::CameraView view = scenes::camera_at(keys, time);
    const Eigen::Affine3d place = file.world(node, time);
    EXPECT_LT((place.translation() - view.position).norm(), 1e-3);
    const Vec3 along = place.linear() * Vec3(0, 0, -1);
    EXPECT_LT((along - (view.target - view.position).normalized()).norm(), 1e-3);
    EXPECT_NEAR((place.linear() * Vec3::UnitX()).y(), 0, 1e-4);
  }
  const Vec3 light = file.world(file.node("key light"), 0).linear() * Vec3(0, 0, -1);
  EXPECT_LT((light - scene_->stage->light.direction.normalized()).norm(), 1e-6);
}

// The importer of scenes checks every index and offset, and reads it through assimp.
TEST_F(DemoGlb, IsReadAsAModel) {
  Folder folder;
  const scenes::Model model = scenes::load_model(folder.write("demo.glb", *bytes_));
  std::size_t vertices = 0, triangles = 0, weighted = 0;
  for (const scenes::Mesh& mesh : model.meshes) {
    vertices += mesh.vertices.size();
    triangles += mesh.indices.size() / 3;
    for (const scenes::Vertex& v : mesh.vertices) {
      const float sum = v.weights[0] + v.weights[1] + v.weights[2] + v.weights[3];
      if (sum != 0) {
        ASSERT_NEAR(sum, 1, 1e-5) << mesh.name;
      }
      weighted += sum != 0;
    }
  }
  EXPECT_GT(weighted, 30000u);
  EXPECT_GT(vertices, 32878u + 2 * 2680);
  EXPECT_GT(triangles, 64405u + 2 * 3600);
  EXPECT_GE(model.bone("RightHand"), 0);
}

TEST_F(DemoGlb, TheKhronosValidatorHasNothingToSay) {
  Folder folder;
  const std::string script =
      "const v = require('gltf-validator'), fs = require('fs');\n"
      "v.validateBytes(new Uint8Array(fs.readFileSync('demo.glb'))).then(r => {\n"
      "  console.log(JSON.stringify(r.issues));\n"
      "  const i = r.issues;\n"
      "  process.exit(i.numErrors + i.numWarnings + i.numInfos + i.numHints ? 1 : 0);\n});\n";
  folder.write("demo.glb", *bytes_);
  folder.write("validate.js", script);
  if (Child({"node", "-e", "require('gltf-validator')"}, folder.path()).wait().code != 0)
    GTEST_SKIP() << "gltf-validator is not installed";
  const ProgramResult outcome = Child({"node", "validate.js"}, folder.path()).wait();
  EXPECT_EQ(outcome.code, 0) << outcome.output << outcome.messages;
}

}  // namespace
}  // namespace taut
