// Plans against all that could have been planned, and against truths that the planner never saw.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <random>

#include "render/cli/plan_models.h"
#include "render/cli/study_target.h"
#include "scenes/scene.h"
#include "sim/study/marks.h"
#include "tests/support/folder.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

const fs::path kScenes = TAUT_SOURCE_DIR "/scenes";

/// What `taut plan` says of a scene, as JSON.
nlohmann::json plan_of(const fs::path& scene, const std::string& options) {
  const Folder folder;
  const fs::path file = folder.path() / "plan.json";
  const std::string command = fmt::format("cd {} && {} plan {} {} --json -q > {}", TAUT_SOURCE_DIR,
                                          TAUT_PROGRAM, scene.string(), options, file.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  return nlohmann::json::parse(read_file(file));
}

/// What one unit of a tolerance measures.
Distance distance_of(const Scene& scene, const std::string& tolerance) {
  if (tolerance.ends_with("px")) return cli::pixels_of(scene)->distance;
  return [](const Vec3& at, const Vec3& truth, double) { return 1e3 * (at - truth).norm(); };
}

/// The planned motion stays within the tolerance of the truth, which is solved far more finely than
/// the planner does.
void expect_within(const fs::path& file) {
  const Scene exact = load_scene(file, true), planned = load_planned(file, false);
  const Plan& plan = *exact.plan;
  const Distance distance = distance_of(exact, plan.tolerance);
  const World world = cli::few_copies(exact.world);
  Simulation truth(world, make_method("truth", {{"local_error", 1e-11}}), exact.timeline);
  Simulation found(cli::few_copies(planned.world),
                   make_method(planned.method.name, planned.method.settings), planned.timeline);
  const Marks marks(world, truth.state()), own(found.world(), found.state());
  double error = 0;
  for (const double time : frame_times(plan.until, exact.fps)) {
    truth.advance_to(time);
    found.advance_to(time);
    const std::vector<Vec3> at = own.places(marks, found.state());
    const std::vector<Vec3> right = marks.places(marks, truth.state());
    for (std::size_t i = 0; i < at.size(); ++i) {
      error = std::max(error, distance(at[i], right[i], time));
    }
  }
  EXPECT_LE(error, std::stod(plan.tolerance)) << file;
}

TEST(PlannedScenes, StayWithinTheirToleranceOfAnIndependentTruth) {
  std::size_t planned = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(kScenes)) {
    if (entry.path().extension() != ".toml") continue;
    const Scene scene = load_scene(entry.path(), false);
    ASSERT_TRUE(scene.plan.has_value()) << entry.path();
    ASSERT_EQ(scene.plan->stamp, plan_stamp(entry.path())) << entry.path() << " changed since";
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
    const Folder folder;
    const double length = between(0.1, 1.5), angle = between(0, 1.2);
    folder.write("scene.toml", fmt::format(R"(duration = 1.0
[connectors.rope]
length = {}
mass = {}
particles = {}
from = {{ fixed = [0, 2, 0] }}
to = {{ point_mass = {} }}
start = {{ direction = [{}, {}, 0] }}
)",
                                           length, between(0.01, 0.2), int(between(4, 40)),
                                           between(0.05, 0.5), std::cos(angle), -std::sin(angle)));
    plan_of(folder.path() / "scene.toml", "--tolerance 2mm --write");
    expect_within(folder.path() / "scene.toml");
  }
}

/// Runs everything to its end that the planner gives up early or never tries.
void expect_nearly_the_cheapest(const char* name, const char* tolerance) {
  const nlohmann::json plan = plan_of(kScenes / name, fmt::format("--tolerance {}", tolerance));
  const Scene scene = load_scene(kScenes / name, true);
  const Tolerance asked{distance_of(scene, tolerance), std::stod(tolerance)};
  const double metres = plan.at("scored_metres").get<double>();
  const Exact exact = solve_exactly(
      {cli::few_copies(scene.world), frame_times(scene.duration, scene.fps), scene.timeline},
      metres, 1e9, [](double) {});
  double cheapest = INFINITY;
  for (const cli::SceneModel& one : cli::models_of(scene)) {
    for (const Candidate& candidate : cli::all_candidates(one.model.world, scene.fps)) {
      const Trial trial = attempt(one.model, candidate, exact, asked, INFINITY);
      if (trial.end == Trial::End::within) cheapest = std::min(cheapest, trial.work);
    }
  }
  EXPECT_LE(1e6 * plan.at("predicted_ms_per_second").get<double>(), 1.5 * cheapest) << name;
}

TEST(LongPlan, CostsAtMostHalfMoreThanTheCheapestOfAll) {
  expect_nearly_the_cheapest("rope_swing.toml", "1px");
  expect_nearly_the_cheapest("two_bodies.toml", "1px");
  expect_nearly_the_cheapest("bench_stick.toml", "1mm");
}

}  // namespace
}  // namespace taut
