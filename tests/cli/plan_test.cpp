// Plans against all that could have been planned, and against truths that the planner never saw.
#include "render/plan/plan.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "render/study/study_target.h"
#include "scenes/load/load_scene.h"
#include "scenes/load/plan_file.h"
#include "sim/evaluation/accuracy.h"
#include "tests/support/folder.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

const fs::path kScenes = TAUT_SOURCE_DIR "/scenes";

/// The output of `taut plan` on a scene, as JSON.
nlohmann::json plan_of(const fs::path& scene, const std::string& options) {
  const Folder folder;
  const fs::path file = folder.path() / "plan.json";
  const std::string command = fmt::format("cd {} && {} plan {} {} --json -q > {}", TAUT_SOURCE_DIR,
                                          TAUT_PROGRAM, scene.string(), options, file.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return nlohmann::json::parse(read_file(file));
}

/// The distance measured by a tolerance's unit.
study::Distance distance_of(const scenes::Scene& scene, const std::string& tolerance) {
  if (tolerance.ends_with("px")) return studies::pixels_of(scene)->distance;
  return [](const Vec3& at, const Vec3& truth, double) { return 1e3 * (at - truth).norm(); };
}

/// The planned motion stays within the tolerance of the truth, which is solved far more finely than
/// the planner does.
void expect_within(const fs::path& file) {
  const scenes::Scene exact = scenes::load_scene(file, true),
                      planned = scenes::load_planned(file, false);
  const scenes::Plan& plan = *exact.plan;
  const study::Distance distance = distance_of(exact, plan.tolerance);
  const World world = planning::few_copies(exact.world, exact.timeline);
  Simulation truth(world, make_method("truth", {{"local_error", 1e-11}}), exact.timeline);
  Simulation found(planning::few_copies(planned.world, planned.timeline),
                   make_method(planned.method.name, planned.method.settings), planned.timeline);
  const study::SamplePoints sample_points(world, truth.state()), own(found.world(), found.state());
  double error = 0;
  for (const double time : study::frame_times(plan.until, exact.fps)) {
    truth.advance_to(time);
    found.advance_to(time);
    const std::vector<Vec3> at = own.places(sample_points, found.state());
    const std::vector<Vec3> right = sample_points.places(sample_points, truth.state());
    for (std::size_t i = 0; i < at.size(); ++i) {
      error = std::max(error, distance(at[i], right[i], time));
    }
  }
  EXPECT_LE(error, std::stod(plan.tolerance)) << file;
}

/// The same of a scene's text, planned here.
void expect_planned_within(const std::string& scene, const std::string& tolerance) {
  const Folder folder;
  const fs::path file = folder.write("scene.toml", scene);
  plan_of(file, "--tolerance " + tolerance + " --write");
  expect_within(file);
}

TEST(LongPlannedScenes, StayWithinTheirToleranceOfAnIndependentTruth) {
  std::size_t planned = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".toml") continue;
    const scenes::Scene scene = scenes::load_scene(entry.path(), false);
    // Where things come to lie on something, the reference solution takes too long.
    if (!scene.plan && !scene.world.obstacles.empty()) continue;
    ASSERT_TRUE(scene.plan.has_value()) << entry.path();
    ASSERT_EQ(scene.plan->stamp, scenes::plan_stamp(entry.path()))
        << entry.path() << " changed since";
    if (scene.plan->until > 0) expect_within(entry.path());
    ++planned;
  }
  EXPECT_GE(planned, 12u);
}

TEST(PlannedScenes, AlsoThoseThatNobodyHasSeen) {
  std::mt19937 random(7);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int i = 0; i < 3; ++i) {
    const double length = between(0.1, 1.5), angle = between(0, 1.2);
    expect_planned_within(fmt::format(R"(duration = 1.0
[connectors.rope]
length = {}
mass = {}
particles = {}
from = {{ fixed = [0, 2, 0] }}
to = {{ point_mass = {} }}
start = {{ direction = [{}, {}, 0] }}
)",
                                      length, between(0.01, 0.2), int(between(4, 40)),
                                      between(0.05, 0.5), std::cos(angle), -std::sin(angle)),
                          "2mm");
  }
}

TEST(PlannedScenes, AlsoAmongObstacles) {
  expect_planned_within(R"(duration = 0.5
[connectors.rope]
length = 0.6
mass = 0.1
particles = 7
radius = 0.01
from = { fixed = [0, 1, 0] }
to = { point_mass = 0.2 }
start = { direction = [0.8, -0.6, 0] }
[obstacles.peg]
shape = { sphere = { diameter = 0.1 } }
position = [0.05, 0.7, 0]
)",
                        "5mm");
}

TEST(PlannedScenes, AlsoJoinedOnes) {
  expect_planned_within(R"(duration = 0.5
[connectors.trunk]
length = 0.5
mass = 0.1
particles = 6
from = { fixed = [0, 1, 0] }
to = { point_mass = 0.1 }
start = { direction = [0.8, -0.6, 0] }
[connectors.branch]
length = 0.3
mass = 0.05
particles = 4
from = { connector = "trunk", at = 0.3 }
to = { point_mass = 0.1 }
)",
                        "5mm");
}

// The cords of a net have numbers, and are no copies of one another.
TEST(PlannedScenes, AlsoNets) {
  expect_planned_within(R"(duration = 0.3
[nets.ladder]
kind = "ladder"
origin = [0, 2, 0]
across = [1, 0, 0]
down = [0.5, -1, 0.2]
size = [0.3, 0.9]
cells = [1, 6]
links = 2
mass = 1.0
held = "upper corners"
)",
                        "5mm");
}

// Spans of a rope have numbers, too. Where it is light enough, only their lengths count.
TEST(LongPlannedScenes, AlsoRopesOverPulleysWhichMayBeMassless) {
  const auto scene = [](double mass) {
    return fmt::format(R"(duration = 0.5
[bodies.load]
mass = 5.0
shape = {{ sphere = {{ diameter = 0.2 }} }}
position = [0.3, 1.0, 0.0]
velocity = [0.2, 0.0, 0.1]
[pulleys]
lead = {{ fixed = [0.6, 2.0, 0.0], inertia = 0.1 }}
block = {{ body = "load", point = [0.0, 0.1, 0.0] }}
[connectors.rope]
length = 2.397368
mass = {}
particles = 5
from = {{ fixed = [0.0, 2.0, 0.0] }}
over = ["block", "lead"]
to = {{ fixed = [0.6, 1.5, 0.0], winch = [{{ t = 0.0, speed = 0.0 }}, {{ t = 0.4, speed = -0.5 }}] }}
)",
                       mass);
  };
  const Folder folder;
  const fs::path file = folder.write("scene.toml", scene(5e-5));
  plan_of(file, "--tolerance 1mm --write");
  expect_within(file);
  const scenes::Scene light = scenes::load_scene(file, false);
  ASSERT_TRUE(light.plan.has_value());
  EXPECT_EQ(light.plan->particles.at("rope"), 0u);
  const World world = scenes::load_planned(file, false).world;
  EXPECT_EQ(world.pulleys.size(), 2u);
  for (const Connector& span : world.connectors) {
    EXPECT_EQ(span.mass, 0) << span.name;
    EXPECT_EQ(span.particles(), 2u) << span.name;
  }
  expect_planned_within(scene(1.0), "0.5mm");
}

/// A scene of any kind: a rope, chain or stick, with a light or a very heavy load or another rope,
/// hanging, driven, pinned or cut, in a plane or in space, seen from near or far.
std::string any_scene(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto one_of = [&](int count) {
    return std::uniform_int_distribution<int>(0, count - 1)(random);
  };
  const double length = between(0.1, 1.2), angle = between(0, 1.3), turn = between(0, 3);
  const double mass = between(0.01, 0.2);
  const bool in_space = one_of(2) == 0, driven = one_of(3) == 0, pinned = one_of(5) == 0;
  const bool cut = one_of(6) == 0, has_tail = one_of(4) == 0;
  const int particles = 3 + one_of(30), end = one_of(3);
  const std::string direction =
      fmt::format("[{}, {}, {}]", std::cos(angle) * std::cos(in_space ? turn : 0), -std::sin(angle),
                  in_space ? std::cos(angle) * std::sin(turn) : 0.0);
  std::string text = fmt::format("duration = {}\n", between(0.5, 1.5));
  if (driven) {
    text += fmt::format(
        "[paths.hand]\ncircle = {{ centre = [0, 1.1, 0], start = [0, 1, 0], axis = [{}, 0, 1], "
        "frequency = {}, ramp = 0.4 }}\n",
        in_space ? between(0, 1) : 0.0, between(0.3, 1.5));
  }
  if (end == 2) {
    text += fmt::format(
        "[bodies.load]\nmass = {}\nshape = {{ cylinder = {{ length = 0.3, diameter = 0.03 }} }}\n"
        "hangs = {}\n",
        between(0.05, 0.5), driven ? "[0, -1, 0]" : direction);
  }
  if (has_tail) {
    text += fmt::format(
        "[connectors.tail]\nlength = {}\nmass = {}\nparticles = {}\nfrom = {}\n"
        "to = {{ free = true }}\nstart = {{ direction = {} }}\n",
        length / 2, mass / 2, 3 + one_of(10),
        end == 2 ? "{ body = \"load\", point = [0, -0.15, 0] }" : "{ fixed = [0.2, 1, 0] }",
        driven ? "[0, -1, 0]" : direction);
  }
  text += fmt::format(
      "[connectors.rope]\nlength = {}\nmass = {}\nparticles = {}\nfrom = {}\n"
      "to = {}\nstart = {{ direction = {} }}\n",
      length, mass, particles, driven ? "{ path = \"hand\" }" : "{ fixed = [0, 1, 0] }",
      end == 0   ? "{ free = true }"
      : end == 1 ? fmt::format("{{ point_mass = {} }}", mass * std::pow(10, between(-1, 3)))
                 : "{ body = \"load\", point = [0, 0.15, 0] }",
      driven ? "[0, -1, 0]" : direction);
  if (pinned) {
    text += fmt::format("[[pins]]\nconnector = \"rope\"\nat = {}\nfrom = {}\nuntil = 0.45\n",
                        length * between(0.3, 0.7), between(0.05, 0.4));
  }
  if (cut) {
    text += fmt::format("[[cuts]]\nconnector = \"rope\"\nat = {}\nt = {}\n",
                        length * between(0.2, 0.8), between(0.1, 0.45));
  }
  return text + fmt::format(
                    "[stage]\ncamera = [{{ t = 0, position = [0.3, 1, {}], target = [0, 0.8, "
                    "0] }}]\n",
                    between(1.5, 8));
}

TEST(LongPlanned, ScenesOfEveryKind) {
  constexpr std::array kTolerances = {"0.2px", "1px", "3px", "10px", "0.2mm", "3mm"};
  std::mt19937 random(20);
  int foretold = 0;
  for (std::size_t i = 0; i < 20; ++i) {
    const Folder folder;
    const std::string scene = any_scene(random);
    const char* const tolerance = kTolerances[i % kTolerances.size()];
    SCOPED_TRACE(fmt::format("{}\n{}", tolerance, scene));
    folder.write("scene.toml", scene);
    const nlohmann::json plan =
        plan_of(folder.path() / "scene.toml", fmt::format("--tolerance {} --write", tolerance));
    if (!(plan.at("until").get<double>() > 0)) continue;
    expect_within(folder.path() / "scene.toml");
    ++foretold;
  }
  EXPECT_GE(foretold, 15);
}

/// Runs everything that the planner gives up early or never tries, until it costs more than two
/// thirds of the plan.
void expect_nearly_the_cheapest(const char* name, const char* tolerance) {
  const nlohmann::json plan = plan_of(kScenes / name, fmt::format("--tolerance {}", tolerance));
  const double enough = plan.at("cycles_per_second").get<double>() / 1.5;
  const scenes::Scene scene = scenes::load_scene(kScenes / name, true);
  const study::Tolerance asked{distance_of(scene, tolerance), std::stod(tolerance)};
  const double metres = plan.at("scored_metres").get<double>();
  const study::ReferenceSolution reference =
      study::solve_reference({planning::few_copies(scene.world, scene.timeline),
                              study::frame_times(scene.duration, scene.fps), scene.timeline},
                             metres, 1e9, [](double) {});
  std::size_t tried = 0;
  for (const planning::SceneModel& one : planning::models_of(scene, {}, {})) {
    for (const MethodChoice& candidate : planning::all_candidates(one.model.world, scene.fps)) {
      const study::Trial trial = study::attempt(one.model, candidate, reference, asked, enough);
      EXPECT_NE(trial.end, study::Trial::End::within)
          << name << ": " << planning::describe(one, scene) << ", " << describe(candidate)
          << " costs " << trial.cycles << " of " << 1.5 * enough;
      ++tried;
    }
  }
  EXPECT_GT(tried, 500u);
}

TEST(LongPlan, CostsAtMostHalfMoreThanTheCheapestOfAll) {
  expect_nearly_the_cheapest("rope_swing.toml", "1px");
  expect_nearly_the_cheapest("two_bodies.toml", "1px");
  expect_nearly_the_cheapest("bench_stick.toml", "1mm");
}

}  // namespace
}  // namespace taut
