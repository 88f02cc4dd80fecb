// taut choreograph: the hand's path that leads a free body through given points.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "render/base/atomic_file.h"
#include "render/options/scene_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "scenes/load/load_scene.h"
#include "sim/choreography/choreography.h"
#include "sim/choreography/flat_fit.h"
#include "sim/motion/stop.h"

namespace taut::cli {
namespace choreograph_command {
namespace {

namespace fs = std::filesystem;

struct Options {
  options::SceneOptions inputs;
  std::string scene, out;
  bool as_it_stands = false;
  double budget = 600;  // s of CPU time
};

/// As csv() writes them, so that what is certified is what is read.
std::vector<PathKey> rounded(std::vector<PathKey> keys) {
  const auto cut = [](double number, double decimals) {
    const double scale = std::pow(10, decimals);
    return std::round(number * scale) / scale;
  };
  for (PathKey& key : keys) {
    key.time = cut(key.time, 6);
    for (double& x : key.position) x = cut(x, 7);
    for (double& x : key.rotation.coeffs()) x = cut(x, 8);
  }
  return keys;
}

std::string csv(const std::vector<PathKey>& keys) {
  std::string text = "t,x,y,z,qw,qx,qy,qz\n";
  for (const PathKey& key : keys) {
    text += fmt::format("{:.6f},{:.7f},{:.7f},{:.7f},{:.8f},{:.8f},{:.8f},{:.8f}\n", key.time,
                        key.position.x(), key.position.y(), key.position.z(), key.rotation.w(),
                        key.rotation.x(), key.rotation.y(), key.rotation.z());
  }
  return text;
}

struct Certificate {
  std::vector<double> misses;  // m, of each waypoint
  choreography::HandMotion hand;

  double worst() const { return *std::ranges::max_element(misses); }
};

bool keeps_to(const choreography::HandMotion& hand, const choreography::HandLimits& limits) {
  return hand.reach <= limits.reach && hand.speed <= limits.speed &&
         hand.acceleration <= limits.acceleration;
}

std::string as_text(const Certificate& found, const scenes::Choreographed& asked) {
  const auto& waypoints = asked.problem.waypoints;
  const auto worst = std::ranges::max_element(found.misses);
  return fmt::format(
      "{} waypoints, passed within {:.2f} mm, the worst at {:.3f} s (asked: {:g} mm)\n"
      "hand: at most {:.3f} m from the shoulder, {:.2f} m/s, {:.1f} m/s^2{}\n",
      waypoints.size(), 1e3 * *worst, waypoints[std::size_t(worst - found.misses.begin())].time,
      1e3 * asked.within, found.hand.reach, found.hand.speed, found.hand.acceleration,
      keeps_to(found.hand, asked.problem.limits) ? "" : ", beyond its limits");
}

std::string as_json(const Options& options, const Certificate& found,
                    const scenes::Choreographed& asked, const fs::path& file) {
  nlohmann::ordered_json json = {{"scene", options.scene},
                                 {"file", file.string()},
                                 {"within_m", asked.within},
                                 {"worst_m", found.worst()},
                                 {"keeps_limits", keeps_to(found.hand, asked.problem.limits)},
                                 {"hand_reach_m", found.hand.reach},
                                 {"hand_speed_m_s", found.hand.speed},
                                 {"hand_acceleration_m_s2", found.hand.acceleration}};
  json["waypoints"] = nlohmann::ordered_json::array();
  for (std::size_t k = 0; k < found.misses.size(); ++k) {
    json["waypoints"].push_back(
        {{"t_s", asked.problem.waypoints[k].time}, {"missed_by_m", found.misses[k]}});
  }
  return program::json_text(json) + '\n';
}

/// In a world whose hand has its path.
Certificate certify(const scenes::Choreographed& asked, const World& world) {
  const auto path = choreography::hand_path(world, asked.problem.body);
  return {choreography::misses(asked.problem, world, asked.within),
          choreography::motion_of_hand(asked.problem, path->keys())};
}

/// With the path that stands in the scene's file, and all that the scene's bodies touch.
Certificate certify_scene(const Options& options, const scenes::Choreographed& asked) {
  const scenes::Scene scene =
      scenes::load_scene(options.scene, false, options::scene_changes(options.inputs.set));
  return certify(asked, scene.world);
}

std::vector<PathKey> find(const Options& options, const scenes::Choreographed& asked, bool quiet) {
  program::Progress progress("choreographing", "rounds", choreography::kMostRounds, quiet);
  std::uint64_t rounds = 0;
  double nearest = INFINITY;
  const auto watch = [&](double miss) {
    nearest = std::min(nearest, miss);
    progress.update(++rounds);
  };
  const WorkLimit limit({.cpu_time = options.budget});
  try {
    return rounded(choreography::choreograph(asked.problem, asked.within, watch, check_stop).keys);
  } catch (const OverLimit&) {
    throw program::Misuse(
        fmt::format("{}: no path is found within --budget {} s of CPU time: {} of {} rounds{}",
                    options.scene, options.budget, rounds, choreography::kMostRounds,
                    rounds > 0 ? fmt::format(" came within {:.2f} mm, asked for {:g} mm",
                                             1e3 * nearest, 1e3 * asked.within)
                               : ""));
  }
}

int run(const Options& options, const program::Common& common) {
  const auto asked =
      scenes::load_choreography(options.scene, options::scene_changes(options.inputs.set));
  if (!asked) {
    throw program::Misuse(fmt::format("{}: has no [choreography]", options.scene));
  }
  const fs::path file = options.out.empty() ? asked->file : fs::path(options.out);
  if (options.as_it_stands) {
    const Certificate found = certify_scene(options, *asked);
    if (common.json) {
      render::write_output(as_json(options, found, *asked, asked->file));
    } else {
      program::write_text(as_text(found, *asked));
    }
    return found.worst() <= asked->within ? program::kDone : program::kUsage;
  }
  render::AtomicFile output(file);
  const std::vector<PathKey> keys = find(options, *asked, common.quiet);
  const Certificate found = certify(
      *asked, choreography::with_hand_path(asked->problem.world, asked->problem.body, keys));
  const std::size_t before =
      choreography::hand_path(asked->problem.world, asked->problem.body)->keys().size();
  if (common.json) {
    render::write_output(as_json(options, found, *asked, file));
  } else {
    program::write_text(as_text(found, *asked));
  }
  if (!(found.worst() <= asked->within)) {
    throw program::Misuse(fmt::format(
        "{}: comes within {:.2f} mm, asked for {:g} mm; {} is not written. More time between the "
        "waypoints, wider limits or a larger `within` make it easier",
        options.scene, 1e3 * found.worst(), 1e3 * asked->within, file.string()));
  }
  output.write(csv({keys.begin() + std::ptrdiff_t(before), keys.end()}));
  output.commit();
  if (!options.out.empty()) return program::kDone;
  const double stands = certify_scene(options, *asked).worst();
  if (stands > asked->within) {
    throw program::Misuse(fmt::format(
        "{}: what leads the body also touches it: in the scene a waypoint is missed by {:.2f} mm. "
        "Waypoints farther away, or limits.clearance, keep it off",
        options.scene, 1e3 * stands));
  }
  return program::kDone;
}

}  // namespace
}  // namespace choreograph_command

void add_choreograph(CLI::App& app, program::Program& program) {
  using namespace choreograph_command;
  program::Command command =
      program::add_command(app, program, "choreograph",
                           "Find the hand's path that guides a free stick through given points",
                           R"(  taut choreograph scenes/choreography/turning_eight.toml
  taut choreograph scenes/choreography/turning_eight.toml --as-it-stands
  taut choreograph scenes/choreography/turning_eight.toml -o path.csv --json

The scene's [choreography] prescribes times and positions for a point of a free body, such as the
tip of a stick on a chain. The command finds a path of the hand, within its limits of reach, speed
and acceleration, that guides the point there, and writes it to the file that the scene names. All
commands then use it.

The result is measured: `direct` simulates the scene with the path as written, and the command
prints the distance from each waypoint. A path with larger distances than the scene asks for is not
written. --json lists every waypoint. Exit codes: 0 found, 2 no path comes so near, 3 bad scene,
6 the file cannot be written, 130 interrupted)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->inputs);
  command.add_option("--out,-o", options->out, "Output file; default: the one that the scene names")
      .type_name("FILE");
  command
      .add_option("--budget", options->budget,
                  fmt::format("CPU time of the search, s; default: {}", options->budget))
      .positive();
  command.add_flag("--as-it-stands", options->as_it_stands,
                   "Only measure the scene's present path");
  command.callback([options, &program] {
    program.run = [options, &program] {
      return options::for_each_scene(options->inputs, program.common,
                                     [&](const std::string& scene) {
                                       Options one = *options;
                                       one.scene = scene;
                                       return run(one, program.common);
                                     });
    };
  });
}

}  // namespace taut::cli
