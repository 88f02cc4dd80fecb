// USD and BVH, read back by readers of the test's own: everything is where the simulation and the
// character had it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <sstream>

#include "render/export/frame_writer.h"
#include "scenes/files/error.h"
#include "scenes/load/load_scene.h"
#include "tests/cli/export_scenes.h"
#include "tests/cli/kept_states.h"
#include "tests/support/folder.h"

namespace taut {
namespace {

using Samples = std::map<double, std::vector<double>>;

/// The time samples of an attribute of a prim, as numbers.
Samples samples(const std::string& usda, const std::string& prim, const std::string& attribute) {
  const std::size_t in = usda.find(" \"" + prim + "\"\n");
  std::istringstream lines(usda.substr(usda.find(attribute + ".timeSamples = {\n", in)));
  std::string line;
  std::getline(lines, line);
  Samples result;
  while (std::getline(lines, line) && line.find('}') == std::string::npos) {
    std::ranges::replace_if(
        line, [](char c) { return std::string("()[],:").find(c) < 6; }, ' ');
    std::istringstream numbers(line);
    double code = 0;
    numbers >> code;
    for (double number; numbers >> number;) result[code].push_back(number);
  }
  return result;
}

/// Straight between samples, as USD has it.
std::vector<double> sample_at(const Samples& samples, double code) {
  const auto after = samples.lower_bound(code - 1e-9);
  if (std::abs(after->first - code) < 1e-9) return after->second;
  const auto before = std::prev(after);
  const double u = (code - before->first) / (after->first - before->first);
  std::vector<double> value;
  for (std::size_t i = 0; i < after->second.size(); ++i)
    value.push_back((1 - u) * before->second[i] + u * after->second[i]);
  return value;
}

void expect_particles(const scenes::Scene& scene, const std::string& usda,
                      const std::vector<std::string>& prims) {
  std::vector<Samples> curves;
  for (const std::string& prim : prims) curves.push_back(samples(usda, prim, "points"));
  double at_frames = 0, between = 0;
  for (const exporting::ExportState& state : states_of(scene))
    for (std::size_t c = 0; c < prims.size(); ++c) {
      const auto numbers = sample_at(curves[c], state.state.time * scene.fps);
      ASSERT_EQ(numbers.size(), 3 * state.state.connectors[c].size());
      for (std::size_t i = 0; 3 * i < numbers.size(); ++i) {
        const Vec3 at(numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]);
        double& error = state.frame ? at_frames : between;
        error = std::max(error, (at - state.state.connectors[c][i]).norm());
      }
    }
  EXPECT_LT(at_frames, 1e-6);
  EXPECT_LT(between, 1e-4);
  EXPECT_GT(between, 0);
}

TEST(UsdaExport, ParticlesAreWhereTheSimulationHadThem) {
  for (const auto& [file, connector] :
       {std::pair("rope_swing.toml", "rope"), {"two_bodies.toml", "cord"}}) {
    const scenes::Scene scene = scene_of(file);
    expect_particles(scene, exported(scene, exporting::usda_writer), {connector});
  }
}

TEST(UsdaExport, ASceneWithoutAStageHasItsConnectorsAndBodies) {
  Folder folder;
  const scenes::Scene scene = scenes::load_scene(folder.write("cut.toml", kPinnedAndCut), false);
  ASSERT_FALSE(scene.stage);
  const std::string usda = exported(scene, exporting::usda_writer);
  expect_particles(scene, usda, {"cord", "rope", "rope_"});
  EXPECT_NE(usda.find("def Xform \"free\""), std::string::npos);
}

TEST(UsdaExport, BodiesTurnAndCamerasLookAsTheyDo) {
  const scenes::Scene scene = scene_of("two_bodies.toml");
  const std::string usda = exported(scene, exporting::usda_writer);
  EXPECT_EQ(usda.substr(0, 10), "#usda 1.0\n");
  EXPECT_NE(usda.find("upAxis = \"Y\""), std::string::npos);
  const Samples positions = samples(usda, "right", "xformOp:translate"),
                turns = samples(usda, "right", "xformOp:orient");
  Simulation simulation = scenes::start(scene);
  for (int frame = 0; frame < scene.frames(); ++frame) {
    simulation.advance_to(double(frame) / scene.fps);
    const Pose pose = simulation.state().bodies[1];
    const auto p = sample_at(positions, frame), q = sample_at(turns, frame);
    EXPECT_LT((Vec3(p[0], p[1], p[2]) - pose.position).norm(), 1e-6);
    EXPECT_LT(Quat(q[0], q[1], q[2], q[3]).angularDistance(pose.rotation), 1e-6);
  }
  const auto focal = samples(usda, "camera", "focalLength");
  const scenes::CameraView view = scenes::camera_at(scene.stage->camera, 0);
  EXPECT_NEAR(2 * std::atan(12 / focal.at(0)[0]), view.field_of_view, 1e-6);
}

TEST(UsdaExport, CamerasWithALensHaveItsStopAndFocus) {
  scenes::Scene scene = scene_of("two_bodies.toml");
  EXPECT_EQ(exported(scene, exporting::usda_writer).find("fStop"), std::string::npos);
  scenes::CameraKey& key = scene.stage->camera.at(0);
  key.relative_aperture = 0.5;
  key.focus = 2.25;
  const std::string usda = exported(scene, exporting::usda_writer);
  EXPECT_EQ(samples(usda, "camera", "fStop").at(0)[0], 2);
  EXPECT_EQ(samples(usda, "camera", "focusDistance").at(0)[0], 2.25);
}

/// The contents of a BVH file: joints with their parents and offsets, and rows of channels.
struct Bvh {
  std::vector<std::string> names;
  std::vector<int> parents;
  std::vector<Vec3> offsets;
  std::vector<std::vector<double>> rows;

  explicit Bvh(const std::string& text) {
    std::istringstream in(text);
    std::vector<int> open;
    for (std::string word; in >> word && word != "MOTION";) {
      if (word == "ROOT" || word == "JOINT") {
        in >> word;
        names.push_back(word);
        parents.push_back(open.empty() ? -1 : open.back());
        offsets.emplace_back();
        open.push_back(int(names.size()) - 1);
      } else if (word == "End") {
        open.push_back(-1);
      } else if (word == "OFFSET") {
        Vec3 v;
        in >> v.x() >> v.y() >> v.z();
        if (open.back() >= 0) offsets[std::size_t(open.back())] = v;
      } else if (word == "}") {
        open.pop_back();
      }
    }
    std::string word;
    std::size_t frames = 0;
    double time = 0;
    in >> word >> frames >> word >> word >> time;
    rows.resize(frames, std::vector<double>(3 + 3 * names.size()));
    for (auto& row : rows)
      for (double& number : row) in >> number;
    EXPECT_TRUE(in);
  }

  std::vector<Vec3> positions(std::size_t frame) const {
    const std::vector<double>& row = rows[frame];
    std::vector<Eigen::Affine3d> places;
    std::vector<Vec3> result;
    for (std::size_t i = 0; i < names.size(); ++i) {
      constexpr double kDegree = std::numbers::pi / 180;
      const double* const angle = &row[3 + 3 * i];
      Eigen::Affine3d place =
          parents[i] < 0 ? Eigen::Affine3d(Eigen::Translation3d(row[0], row[1], row[2]))
                         : places[std::size_t(parents[i])] * Eigen::Translation3d(offsets[i]);
      place.rotate(Eigen::AngleAxisd(angle[0] * kDegree, Vec3::UnitZ()) *
                   Eigen::AngleAxisd(angle[1] * kDegree, Vec3::UnitX()) *
                   Eigen::AngleAxisd(angle[2] * kDegree, Vec3::UnitY()));
      places.push_back(place);
      result.push_back(place.translation());
    }
    return result;
  }
};

TEST(BvhExport, EveryJointIsWhereTheCharacterHasIt) {
  for (const char* name : {"nunchaku.toml", "earring.toml"}) {
    const scenes::Scene scene = scene_of(name);
    const Bvh bvh(exported(scene, exporting::bvh_writer));
    const scenes::Model& model = *scene.stage->characters[0];
    ASSERT_EQ(bvh.names.size(), model.bones.size());
    ASSERT_EQ(int(bvh.rows.size()), scene.frames());
    double most = 0;
    for (std::size_t frame = 0; frame < bvh.rows.size(); frame += 7) {
      const auto bones = scene.performances[0]->bones_at(double(frame) / scene.fps);
      const std::vector<Vec3> positions = bvh.positions(frame);
      for (std::size_t i = 0; i < positions.size(); ++i)
        most = std::max(
            most, (positions[i] - bones[std::size_t(model.bone(bvh.names[i]))].position).norm());
    }
    EXPECT_LT(most, 1e-5) << name;
  }
}

TEST(BvhExport, ASceneWithoutACharacterIsRefused) {
  const scenes::Scene scene = scene_of("rope_swing.toml");
  try {
    exporting::bvh_writer(scene, [](std::string_view) {});
    FAIL();
  } catch (const scenes::BadScene& error) {
    EXPECT_NE(std::string(error.what()).find("has 0 characters on its stage, expected one"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace taut
