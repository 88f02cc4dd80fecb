// Exports for other programs, read back: every number is the simulation's own.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"
#include "tests/cli/export_scenes.h"
#include "tests/support/folder.h"
#include "tests/support/glb.h"
#include "tests/support/npz.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

class Export : public testing::Test {
 protected:
  Export() {
    folder_.write("cut.toml", kPinnedAndCut);
    folder_.write("link.toml", kBodyAsLink);
  }
  ProgramResult run(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "export");
    return run_taut(std::move(arguments), folder_.path());
  }
  /// The bytes of an export of a scene of the folder.
  std::string exported(const std::string& scene, const std::string& format) const {
    const ProgramResult outcome = run({scene, "--to", format, "-o", "-"});
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
    return outcome.output;
  }
  std::vector<Snapshot> states(const std::string& name) const {
    const scenes::Scene scene = scenes::load_scene(folder_.path() / name, false);
    Simulation simulation = scenes::start(scene);
    std::vector<Snapshot> result;
    for (int frame = 0; frame < scene.frames(); ++frame) {
      simulation.advance_to(double(frame) / scene.fps);
      result.push_back(simulation.state());
    }
    return result;
  }

  Folder folder_;
};

TEST_F(Export, ArraysAreTheStates) {
  auto arrays = read_npz(exported("cut.toml", "npz"));
  const std::vector<Snapshot> expected = states("cut.toml");
  ASSERT_EQ(expected.size(), 25u);
  EXPECT_EQ(arrays["times.npy"].shape, "(25,)");
  EXPECT_EQ(arrays["connectors/rope/positions.npy"].shape, "(25, 9, 3)");
  EXPECT_EQ(arrays["connectors/rope'/velocities.npy"].shape, "(25, 4, 3)");
  EXPECT_EQ(arrays["bodies/held/positions.npy"].shape, "(25, 3)");
  EXPECT_EQ(arrays["bodies/free/rotations.npy"].shape, "(25, 4)");
  EXPECT_EQ(arrays.size(), 1u + 2 * 3 + 2 * 2);
  const auto next = [](const NumpyArray& array, std::size_t& at) { return array.numbers.at(at++); };
  const char* names[] = {"cord", "rope", "rope'"};
  std::array<std::size_t, 3> at{};
  std::size_t turned = 0;
  for (std::size_t frame = 0; frame < expected.size(); ++frame) {
    EXPECT_EQ(arrays["times.npy"].numbers[frame], expected[frame].time);
    ASSERT_EQ(expected[frame].connectors.size(), 3u);
    for (std::size_t c = 0; c < 3; ++c)
      for (const Vec3& p : expected[frame].connectors[c])
        for (const double number : p) {
          const auto& array = arrays[fmt::format("connectors/{}/positions.npy", names[c])];
          EXPECT_EQ(next(array, at[c]), number);
        }
    const Quat& q = expected[frame].bodies[0].rotation;
    for (const double part : {q.w(), q.x(), q.y(), q.z()})
      EXPECT_EQ(next(arrays["bodies/free/rotations.npy"], turned), part);
  }
}

// Central differences of a run that stops more often; XPBD's own velocities are differences of its
// steps.
TEST_F(Export, VelocitiesAreThoseOfTheShownParticles) {
  for (const char* name : {"cut.toml", "link.toml"}) {
    scenes::Scene scene = scenes::load_scene(folder_.path() / name, false);
    if (scene.world.connectors.size() == 1) scene.world.bodies[0].model = BodyModel::link;
    const ShownVelocities velocities(scene.world, scene.timeline);
    constexpr double kStep = 0.0005;
    int compared = 0;
    for (const double time : {0.05, 0.12, 0.19}) {
      Simulation simulation = scenes::start(scene);
      std::vector<Snapshot> around;
      std::vector<std::vector<Vec3>> middle;
      for (int i = -1; i <= 1; ++i) {
        simulation.advance_to(time + i * kStep);
        around.push_back(simulation.state());
        if (i == 0) middle = velocities.of(simulation);
      }
      ASSERT_EQ(middle.size(), around[0].connectors.size());
      for (std::size_t c = 0; c < middle.size(); ++c) {
        ASSERT_EQ(middle[c].size(), around[0].connectors[c].size());
        for (std::size_t i = 0; i < middle[c].size(); ++i) {
          const Vec3 difference =
              (around[2].connectors[c][i] - around[0].connectors[c][i]) / (2 * kStep);
          EXPECT_LT((difference - middle[c][i]).norm(), 0.02 + 0.02 * difference.norm())
              << name << " at " << time << " s, connector " << c << ", particle " << i;
          compared += difference.norm() > 0.1;
        }
      }
    }
    EXPECT_GT(compared, 10) << name;
  }
}

TEST_F(Export, NumpyReadsTheArrays) {
  ASSERT_EQ(run({"cut.toml", "-o", "cut.npz", "-q"}).code, 0);
  const std::string script =
      "import numpy\n"
      "a = numpy.load('cut.npz')\n"
      "assert a['connectors/cord/positions'].shape == (25, 3, 3)\n"
      "assert abs(a['times'][-1] - 0.48) < 1e-12 and len(a.files) == 11\n"
      "import zipfile\n"
      "assert zipfile.ZipFile('cut.npz').testzip() is None\n";
  folder_.write("load.py", script);
  if (Child({"python3", "-c", "import numpy"}, folder_.path()).wait().code != 0)
    GTEST_SKIP() << "numpy is not installed";
  const ProgramResult outcome = Child({"python3", "load.py"}, folder_.path()).wait();
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
}

TEST_F(Export, TheTableIsThatOfSimulate) {
  const ProgramResult simulated =
      run_taut({"simulate", "cut.toml", "--no-estimate", "-q"}, folder_.path());
  ASSERT_EQ(simulated.code, 0);
  EXPECT_EQ(exported("cut.toml", "csv"), simulated.output);
}

TEST_F(Export, APointCacheHasEveryParticle) {
  const std::string bytes = exported("cut.toml", "pc2");
  const auto at = [&]<typename T>(std::size_t offset, T) {
    T value{};
    EXPECT_LE(offset + sizeof value, bytes.size());
    std::memcpy(&value, bytes.data() + offset, std::min(sizeof value, bytes.size() - offset));
    return value;
  };
  EXPECT_EQ(bytes.substr(0, 12), std::string("POINTCACHE2", 12));
  EXPECT_EQ(at(12, 0), 1);
  EXPECT_EQ(at(16, 0), 3 + 9 + 4);
  EXPECT_EQ(at(20, 0.f), 0);
  EXPECT_EQ(at(24, 0.f), 1);
  EXPECT_EQ(at(28, 0), 25);
  std::size_t offset = 32;
  for (const Snapshot& state : states("cut.toml"))
    for (const auto& particles : state.connectors)
      for (const Vec3& particle : particles)
        for (const double number : particle) {
          EXPECT_EQ(at(offset, 0.f), float(number));
          offset += sizeof(float);
        }
  EXPECT_EQ(bytes.size(), offset);
}

TEST_F(Export, FilesAreTheSameBytesEachTime) {
  for (const char* format : {"glb", "usda", "npz", "csv", "pc2"}) {
    const std::string file = fmt::format("a.{}", format);
    const ProgramResult outcome = run({"link.toml", "-o", file, "-q"});
    EXPECT_EQ(outcome.output, file + "\n");
    EXPECT_EQ(read_file(folder_.path() / file), exported("link.toml", format)) << format;
    EXPECT_EQ(run({"link.toml", "--to", format, "-q"}).output,
              fmt::format("out/link/link.{}\n", format));
    EXPECT_EQ(read_file(folder_.path() / "out/link" / fmt::format("link.{}", format)),
              read_file(folder_.path() / file));
  }
}

/// The fenced blocks of that language in the room's page; the shorter clip stands for the demo.
std::vector<std::string> examples(const std::string& language) {
  const std::string page = read_file(TAUT_SOURCE_DIR "/render/export/README.md");
  const std::string open = "```" + language + "\n", close = "```\n";
  std::vector<std::string> blocks;
  for (std::size_t at = page.find(open); at != std::string::npos; at = page.find(open, at)) {
    at += open.size();
    const std::size_t end = page.find(close, at);
    std::string& block = blocks.emplace_back(page.substr(at, end - at));
    const std::string demo = "scenes/nunchaku.toml";
    for (std::size_t k; (k = block.find(demo)) != std::string::npos;)
      block.replace(k, demo.size(), "scenes/nunchaku_paper.toml");
    at = end;
  }
  return blocks;
}

TEST_F(Export, TheExamplesOfThePageRun) {
  for (const char* name : {"scenes", "assets"})
    fs::create_directory_symlink(fs::path(TAUT_SOURCE_DIR) / name, folder_.path() / name);
  fs::create_directories(folder_.path() / "build/release");
  fs::create_symlink(TAUT_PROGRAM, folder_.path() / "build/release/taut");
  const auto passes = [&](std::vector<std::string> command, const std::string& example) {
    const ProgramResult outcome = Child(std::move(command), folder_.path()).wait();
    EXPECT_EQ(outcome.code, 0) << example << outcome.messages;
  };
  const std::vector<std::string> shell = examples("sh"), python = examples("python");
  ASSERT_GE(shell.size(), 5u);
  for (const std::string& example : shell) passes({"sh", "-e", "-c", example}, example);
  ASSERT_GE(python.size(), 1u);
  if (Child({"python3", "-c", "import numpy"}, folder_.path()).wait().code != 0)
    GTEST_SKIP() << "numpy is not installed";
  for (const std::string& example : python) passes({"python3", "-c", example}, example);
}

TEST_F(Export, SaysWhatItMade) {
  const ProgramResult outcome = run({"link.toml", "-o", "a.npz", "--json", "--fps", "100"});
  ASSERT_EQ(outcome.code, 0) << outcome.messages;
  const auto json = nlohmann::json::parse(outcome.output);
  EXPECT_EQ(json.at("file"), "a.npz");
  EXPECT_EQ(json.at("frames"), 20);
  EXPECT_EQ(json.at("bytes"), fs::file_size(folder_.path() / "a.npz"));
  const auto glb = nlohmann::json::parse(run({"cut.toml", "-o", "a.glb", "--json"}).output);
  EXPECT_LT(glb.at("particles_between_frames_off_by_m"), 1e-4);
  EXPECT_GE(glb.at("keys"), 25);
}

TEST_F(Export, SeveralScenesShareAFolder) {
  const ProgramResult outcome =
      run({"cut.toml", "link.toml", "--to", "csv", "-o", "rows", "-q", "--set", "duration=0.35"});
  EXPECT_EQ(outcome.output, "rows/cut.csv\nrows/link.csv\n") << outcome.messages;
  EXPECT_EQ(read_file(folder_.path() / "rows/link.csv"),
            run({"link.toml", "--to", "csv", "-o", "-", "--set", "duration=0.35"}).output);
  EXPECT_EQ(run({"cut.toml", "link.toml", "-o", "rows.csv"}).code, 2);
}

// A scene that says nothing of pictures has boxes, a camera and a light.
TEST_F(Export, ASceneWithoutAStageHasWhatPicturesOfItHave) {
  const GlbFile file(exported("link.toml", "glb"));
  EXPECT_TRUE(file.root()["nodes"][file.node("stick")].contains("mesh"));
  EXPECT_TRUE(file.root()["nodes"][file.node("camera")].contains("camera"));
  EXPECT_FALSE(file.root()["nodes"][file.node("key light")]["extensions"].empty());
}

TEST_F(Export, MisuseAndFailuresLeaveNothing) {
  const auto fails = [&](int code, const std::string& says, std::vector<std::string> arguments) {
    const bool json = arguments.back() == "--json";
    const ProgramResult outcome = run(std::move(arguments));
    EXPECT_EQ(outcome.code, code);
    EXPECT_EQ(outcome.output.empty(), !json);
    EXPECT_NE(outcome.messages.find(says), std::string::npos) << outcome.messages;
  };
  fails(2, "no format is given, expected --to with one of glb, usda, npz, csv, pc2, bvh",
        {"link.toml"});
  fails(2, "swing.abc: its suffix names no format", {"link.toml", "-o", "swing.abc"});
  fails(2, "--to", {"link.toml", "--to", "abc"});
  fails(2, "standard output is the JSON's", {"link.toml", "--to", "npz", "-o", "-", "--json"});
  fails(3, "none.toml", {"none.toml", "--to", "npz"});
  fails(3, "link.toml:1:1: has 0 characters on its stage", {"link.toml", "-o", "a.bvh"});
  fails(6, "cannot be created", {"link.toml", "-o", "cut.toml/a.npz"});
  fails(3, "of memory", {"cut.toml", "-o", "a.npz", "--max-memory", "10kB"});
  folder_.write("burst.toml", [] {
    std::string scene = kPinnedAndCut;
    return scene.replace(scene.find("name = \"xpbd\"\nstep = 0.0005"), 27,
                         "name = \"springs\"\nstep = 0.01\nstiffness = 1e9");
  }());
  fails(7, "diverged", {"burst.toml", "-o", "a.csv", "-q"});
  for (const auto& entry : fs::directory_iterator(folder_.path()))
    EXPECT_EQ(entry.path().extension(), ".toml") << entry.path();
}

}  // namespace
}  // namespace taut
