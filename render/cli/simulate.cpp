// taut simulate: a trajectory without pictures.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/export/csv.h"
#include "render/options/method_options.h"
#include "render/options/needs.h"
#include "render/options/scene_options.h"
#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/report/report_page.h"
#include "render/study/scoring.h"
#include "scenes/files/files.h"
#include "scenes/scene/scene.h"
#include "sim/contact/capsule.h"
#include "sim/evaluation/run.h"
#include "sim/links/tension.h"
#include "sim/measure/measure.h"
#include "sim/run/forces.h"
#include "sim/run/simulation.h"

namespace taut::cli {

namespace simulate_command {
namespace {

namespace fs = std::filesystem;

struct Options {
  options::SceneOptions inputs;
  std::string scene;  // of the inputs, the one that is simulated now
  std::string csv, forces;
  std::string sweep;  // KEY=FROM:UNTIL:COUNT
  std::string swept;  // KEY=VALUE of this run
  std::string from_state, save_state;
  double until = 0;  // s; 0: the scene's duration
  int fps = 0;       // 0: the scene's
  bool no_estimate = false;
  double max_memory = 0;
  std::optional<double> score;  // share of the length
  options::MethodOptions method;
};

/// How connectors that touch wind about each other, or one about itself.
struct Winding {
  std::size_t a = 0, b = 0;  // connectors; the same: its writhe
  double start = 0, end = 0;
};

/// The largest forces at any frame (N), and when (s) and where they were.
struct LargestForces {
  struct Largest {
    double force = 0, time = 0;
    std::string of, part;
  };
  Largest tension, hold, contact;
  int none = 0;  // frames in which no forces satisfy the laws

  void add(const World& world, const Forces& now) {
    const auto raise = [&](Largest& to, double force, const Named& at) {
      if (force > to.force) to = {force, now.time, at.name, at.part};
    };
    for (const Forces::Link& at : now.links) {
      raise(tension, std::abs(at.tension), named(world, at));
    }
    for (const Forces::Hold& at : now.holds) {
      raise(hold, at.force.norm(), named(world, at));
    }
    for (const Forces::Contact& at : now.contacts) {
      raise(contact, at.force.norm(), named(world, at.one));
    }
  }
};

/// The measurements of a run; drift, stretch and penetration at frame times.
struct Report {
  int frames = 0;
  double stepping = 0;      // CPU s, in advance() alone
  double stretch = 0;       // largest share of a link's length
  double drift = 0;         // J, largest change of energy that no intervention explains
  double energy_scale = 0;  // J
  double penetration = 0;   // m
  std::vector<Winding> windings;
  std::optional<LargestForces> forces;
};

double winding(const World& world, const Winding& of) {
  const Curve one = curve_of(world, of.a);
  return of.a == of.b ? writhe(one) : linking_number(one, curve_of(world, of.b));
}

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Calls visit(connector, end) for every winch.
template <typename Visit>
void each_winch(const World& world, Visit visit) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (const std::size_t end : {0u, 1u}) {
      const auto& winch = world.connectors[c].winch;
      if (winch && winch->paths[end]) visit(c, end);
    }
  }
}

std::string header(const scenes::Scene& scene, bool estimated) {
  std::string line = exporting::csv_header(scene);
  each_winch(scene.world, [&](std::size_t c, std::size_t end) {
    line += fmt::format(",{}.{}.tension", scene.world.connectors[c].name, end == 0 ? "from" : "to");
  });
  return line + (estimated ? ",error_estimate\n" : "\n");
}

std::string row(const Simulation& simulation, const studies::SelfEstimate& estimate) {
  std::string line = exporting::csv_row(simulation.state());
  const World& world = simulation.world();
  each_winch(world, [&](std::size_t c, std::size_t end) {
    line += fmt::format(",{:.17g}", winch_tension(world, c, end));
  });
  if (estimate.exists()) line += fmt::format(",{:.17g}", estimate.error());
  return line + '\n';
}

/// Where the rows go: a file, standard output, or nowhere.
class Rows {
 public:
  Rows(const std::string& file, bool to_output) : to_output_(to_output && file.empty()) {
    if (!file.empty()) file_.emplace(file);
  }
  bool wanted() const { return file_ || to_output_; }
  void write(const std::string& text) {
    if (file_) file_->write(text);
    if (to_output_) render::write_output(text);
  }
  void finish() {
    if (file_) file_->commit();
  }

 private:
  std::optional<render::AtomicFile> file_;
  bool to_output_;
};

/// Where the forces go: a file, or nowhere.
class ForceFile {
 public:
  explicit ForceFile(const std::string& file) {
    if (file.empty()) return;
    file_.emplace(file);
    rows_ = exporting::force_writer(file, [this](std::string_view text) { file_->write(text); });
  }
  bool wanted() const { return rows_ != nullptr; }
  void add(const World& world, const Forces& forces, std::span<const Event> events) {
    rows_->add(world, forces, events);
  }
  void finish() {
    if (!rows_) return;
    rows_->finish();
    file_->commit();
  }

 private:
  std::optional<render::AtomicFile> file_;
  std::unique_ptr<exporting::ForceWriter> rows_;
};

/// The frames of a run: from the first after the state that it goes on from, until its end.
struct Frames {
  int first = 0, until = 0;
};
Frames frames_of(const scenes::Scene& scene, const Simulation& simulation, const Options& options) {
  constexpr double kSame = 1e-6;  // of a frame
  Frames frames{.until = scene.frames()};
  if (options.until > 0) {
    const double last = std::floor(options.until * scene.fps + kSame);
    frames.until = std::min(frames.until, static_cast<int>(last) + 1);
  }
  if (!options.from_state.empty()) {
    const double next = std::floor(simulation.world().time * scene.fps + kSame) + 1;
    frames.first = static_cast<int>(std::min<double>(next, frames.until));
  }
  return frames;
}

/// Goes on from the state in a file.
void load_state(const Options& options, Simulation& simulation) {
  constexpr std::size_t kLargest = std::size_t{1} << 30;
  const std::string bytes =
      scenes::read_regular_file(options.from_state, kLargest, "a state that --save-state wrote");
  try {
    simulation.load(bytes);
  } catch (const BadState& bad) {
    throw scenes::bad_asset(options.from_state, bad.what());
  }
  if (options.until > 0 && options.until < simulation.world().time) {
    throw program::Misuse(
        fmt::format("--until {}: the state of {} is at {} s, expected a later time", options.until,
                    options.from_state, simulation.world().time));
  }
}

Report simulate(const scenes::Scene& scene, Simulation& simulation, studies::SelfEstimate& estimate,
                Rows& rows, ForceFile& force_file, const Options& options, bool quiet) {
  const World& world = simulation.world();
  study::EnergyBalance balance(scene.timeline);
  const Frames frames = frames_of(scene, simulation, options);
  Report report;
  report.energy_scale = energy_scale(world);
  constexpr std::size_t kMostWindings = 100;
  for (const ConnectorPair& pair : world.connector_pairs) {
    if (report.windings.size() == kMostWindings) break;
    Winding made{.a = pair.a, .b = pair.b};
    made.start = winding(world, made);
    report.windings.push_back(made);
  }
  report.frames = frames.until - frames.first;
  program::Progress progress("simulating", "frames", static_cast<std::uint64_t>(report.frames),
                             quiet);
  if (rows.wanted()) rows.write(header(scene, estimate.exists()));
  if (force_file.wanted()) report.forces.emplace();
  for (int frame = frames.first; frame < frames.until; ++frame) {
    render::stop_if_interrupted();
    const double before = cpu_seconds();
    try {
      simulation.advance_to(static_cast<double>(frame) / scene.fps);
    } catch (const Diverged&) {
      rows.finish();  // those until then are worth having
      force_file.finish();
      throw;
    }
    report.stepping += cpu_seconds() - before;
    estimate.follow(simulation);
    report.drift = larger(report.drift, std::abs(balance.next(world)));
    report.stretch = larger(report.stretch, stretch_max(world));
    report.penetration = larger(report.penetration, contact::penetration_max(world));
    if (rows.wanted()) rows.write(row(simulation, estimate));
    if (report.forces) {
      Forces forces;
      try {
        forces = forces_of(world);
      } catch (const Diverged&) {
        ++report.forces->none;
      }
      report.forces->add(world, forces);
      force_file.add(world, forces, simulation.method().events());
    }
    progress.update(static_cast<std::uint64_t>(frame - frames.first) + 1);
  }
  if (options.until > simulation.world().time) simulation.advance_to(options.until);
  rows.finish();
  force_file.finish();
  for (Winding& made : report.windings) made.end = winding(world, made);
  return report;
}

std::string json_text(const scenes::Scene& scene, const Simulation& simulation,
                      const Report& report, const studies::SelfEstimate& estimate,
                      const std::string& swept) {
  const Counters& counters = simulation.method().counters();
  // The last frame's time is what was simulated; a scene of one frame simulates nothing.
  const double simulated = simulation.world().time;
  nlohmann::ordered_json json;
  json["scene"] = scene.file.string();
  if (!swept.empty()) {
    const auto [key, value] = options::set_pair(swept);
    json["swept"] = {{"key", key}, {"value", std::stod(value)}};
  }
  json["method"] = scene.method.name;
  json["settings"] = options::settings_json(with_defaults(scene.method));
  json["frames"] = report.frames;
  json["stepping_ms_per_second"] =
      simulated > 0 ? nlohmann::ordered_json(1e3 * report.stepping / simulated) : nullptr;
  json["steps"] = counters.steps;
  json["solves"] = counters.solves;
  json["rejected"] = counters.rejected;
  json["handed_over"] = counters.handed_over;
  json["stretch_max"] = report.stretch;
  json["penetration_max_m"] = report.penetration;
  for (const Winding& winding : report.windings) {
    const auto name = [&](std::size_t c) { return simulation.world().connectors[c].name; };
    if (winding.a == winding.b) {
      json["windings"].push_back({{"connector", name(winding.a)},
                                  {"writhe_at_start", winding.start},
                                  {"writhe", winding.end}});
    } else {
      json["windings"].push_back({{"connector", name(winding.a)},
                                  {"other_connector", name(winding.b)},
                                  {"linking_number_at_start", winding.start},
                                  {"linking_number", winding.end}});
    }
  }
  for (const Simulation::Break& found : scene.breaks) {
    json["breaks"].push_back({{"connector", found.connector},
                              {"link", found.link},
                              {"t", found.cut.time},
                              {"tension_N", found.tension}});
  }
  if (report.forces) {
    const auto add = [&](const char* key, const LargestForces::Largest& largest) {
      json[key] = nullptr;
      if (!(largest.force > 0)) return;
      json[key] = {
          {"N", largest.force}, {"t", largest.time}, {"of", largest.of}, {"part", largest.part}};
    };
    add("largest_tension", report.forces->tension);
    add("largest_hold_force", report.forces->hold);
    add("largest_contact_force", report.forces->contact);
    json["frames_without_forces"] = report.forces->none;
  }
  json["energy_drift"] = nullptr;
  if (is_closed(simulation.world()) && report.energy_scale > 0) {
    json["energy_drift"] = report.drift / report.energy_scale;
  }
  json["energy_drift_is"] =
      "largest change of the mechanical energy at any frame, as a share of energy_scale, since the "
      "start or the last pin, release or cut, which change it; null where something driven does "
      "work, or dampers or the air take it";
  json["energy_scale"] = report.energy_scale;
  estimate.add_to(json);
  json["state_hash"] = fmt::format("{:016x}", state_hash(simulation.world()));
  return program::json_text(json) + '\n';
}

/// Several scenes share a folder, and so do the values of a sweep.
std::string csv_file(const Options& options) {
  const bool sweeps = !options.swept.empty(), several = options.inputs.several();
  if (options.csv.empty() || !(several || sweeps)) return options.csv;
  if (options.csv.ends_with(".csv")) {
    throw program::Misuse(fmt::format("--csv {}: one file for several {}, expected a folder",
                                      options.csv, several ? "scenes" : "values"));
  }
  if (sweeps) {
    const fs::path folder = options::results_folder(options.scene, options.csv, several);
    return (folder / (options.swept + ".csv")).string();
  }
  return options::results_folder(options.scene, options.csv, true).string() + ".csv";
}

void refuse_wrong_forces(const Options& options) {
  const std::string& file = options.forces;
  const auto refuse = [&](const char* why) {
    throw program::Misuse(fmt::format("--forces {}: {}", file, why));
  };
  if (file.empty()) return;
  if (options.inputs.several()) refuse("one file for several scenes, expected one scene");
  if (!options.swept.empty()) refuse("one file for several values, expected no --sweep");
  if (file == "-" || render::is_standard_output(file)) {
    refuse("standard output is the trajectory's, expected a file");
  }
  if (file == options.csv) refuse("the trajectory's file (--csv), expected another");
}

void refuse_wrong_states(const Options& options, const scenes::Scene& scene) {
  for (const auto& [option, file] : {std::pair("--save-state", options.save_state),
                                     std::pair("--from-state", options.from_state)}) {
    if (file.empty()) continue;
    if (options.inputs.several()) {
      throw program::Misuse(
          fmt::format("{} {}: one file for several scenes, expected one scene", option, file));
    }
    if (options.score) throw program::Misuse(fmt::format("{}: does not go with --score", option));
  }
  if (options.until > scene.duration) {
    throw program::Misuse(fmt::format("--until {}: expected at most the scene's duration, {} s",
                                      options.until, scene.duration));
  }
}

/// How far off the run is, in place of its trajectory.
int score(const scenes::Scene& scene, const Options& options, const program::Common& common) {
  if (!options.csv.empty() || !options.forces.empty())
    throw program::Misuse("--score: makes no trajectory, expected neither --csv nor --forces");
  options::refuse_beyond({.memory = options::simulation_needs(scene).memory}, scene,
                         options.max_memory, "", "", common.quiet);
  if (!common.quiet) program::note("solving the truth\n");
  const program::Json json = report::run_score(scene, *options.score);
  if (common.json) {
    render::write_output(program::json_text(json) + "\n");
    return program::kDone;
  }
  const auto value = [&](const char* key) {
    return json[key].is_null() ? std::string("-") : options::rounded(json[key].get<double>());
  };
  render::write_output(program::table_text(
      {{"method", "RMS error (share of length)", "ms per simulated second", "truth until (s)"},
       {{scene.method.name, value("rms_error"), value("cpu_ms_per_simulated_s"),
         value("horizon_s")}}}));
  return program::kDone;
}

int run(const Options& options, const program::Common& common) {
  scenes::Scene scene = options::load_chosen(options.scene, false, options.method);
  if (options.fps > 0) scene.fps = options.fps;
  scene.method = options::chosen_method(options.method, scene);
  scenes::settle_breaks(scene);
  refuse_wrong_forces(options);
  refuse_wrong_states(options, scene);
  if (options.score) return score(scene, options, common);
  const bool to_output = options.csv == "-" || render::is_standard_output(options.csv);
  if (!options.swept.empty() && !(options.save_state + options.from_state).empty()) {
    throw program::Misuse("--sweep: goes with neither --save-state nor --from-state");
  }
  if (!options.swept.empty() && (to_output || (options.csv.empty() && !common.json))) {
    throw program::Misuse("--sweep: several trajectories, expected --csv FOLDER or --json");
  }
  if (to_output && common.json) {
    throw program::Misuse(
        fmt::format("--csv {}: standard output is the JSON's (--json)", options.csv));
  }
  const std::string csv = to_output ? "" : csv_file(options);
  const fs::path folder = fs::path(csv).has_parent_path() ? fs::path(csv).parent_path() : ".";
  options::refuse_beyond(options::simulation_needs(scene), scene, options.max_memory,
                         csv.empty() ? "" : folder, "", common.quiet);
  Simulation simulation = start(scene);
  if (!options.from_state.empty()) load_state(options, simulation);
  // A run beside this one would have to go all the way from the start.
  studies::SelfEstimate estimate(scene, !options.no_estimate && options.from_state.empty());
  Rows rows(csv, to_output || !common.json);
  ForceFile force_file(options.forces);
  const Report report =
      simulate(scene, simulation, estimate, rows, force_file, options, common.quiet);
  if (!options.save_state.empty()) {
    render::AtomicFile state(options.save_state);
    state.write(simulation.save());
    state.commit();
  }
  if (common.json)
    render::write_output(json_text(scene, simulation, report, estimate, options.swept));
  if (report.forces && report.forces->none > 0 && !common.quiet) {
    program::note("{}: {} of {} frames have no rows: no forces satisfy the laws in their states\n",
                  options.forces, report.forces->none, report.frames);
  }
  if (!csv.empty() && !common.quiet) {
    program::note("{}: {} frames, method {}\n{}", csv, report.frames, scene.method.name,
                  program::Lines{estimate.line()});
  }
  return program::kDone;
}

}  // namespace
}  // namespace simulate_command

void add_simulate(CLI::App& app, program::Program& program) {
  using namespace simulate_command;
  program::Command command = program::add_command(
      app, program, "simulate", "Compute a scene's trajectory, without pictures",
      fmt::format(R"(  taut simulate scenes/rope_swing.toml > swing.csv
  taut simulate scenes/rope_swing.toml --csv swing.csv --json
  taut simulate scenes/rope_swing.toml --method springs --step 1e-4 --set stiffness=5000 --json
  taut simulate scenes/rope_swing.toml --method xpbd --step 1e-4 --score 1e-4
  taut simulate scenes/rope_swing.toml --until 1 --save-state swing.state > first.csv
  taut simulate scenes/rope_swing.toml --from-state swing.state > rest.csv
  taut simulate scenes/rope_swing.toml --sweep connectors.rope.length=0.3:0.6:4 --json

One row per frame: t, every particle of every connector (NAME.0.x,NAME.0.y,NAME.0.z,...), every
body's own frame (NAME.x,NAME.y,NAME.z,NAME.qw,NAME.qx,NAME.qy,NAME.qz), the tension at the drum of
every winch (NAME.from.tension, NAME.to.tension), error_estimate. SI units. Particles that pins add
have no columns; the part cut off a connector has columns from the start, as NAME'.

--forces writes a row for each link, hold, clamp and contact of each frame: t, what (tension, hold,
moment, contact), of (a connector or body), part (a particle: 3, a link: 3-4), with (what holds or
touches it), with_part, x, y, z, fx, fy, fz (on the first; of a tension: on its link's first
particle), size (N; of a clamp's moment N m). The forces follow from the state of the frame by the
scene's laws. The events since the last frame precede them, with their times, as far as the method
reports events (direct: all; impulse and others: those of massless spans): taut and slack of spans
and of links that only pull; hit, leave, slide and stick of contacts; impulse. The size of a hit or
impulse is in N s. --json then has the largest forces. FILE.npz has the rows as arrays for
numpy.load() (t, what, of, part, with, with_part, place, force, size), FILE.json as a list of
objects.

{}
The estimate is the last column, if the method has one (inf once the second run diverges); --json
has error_estimate_m (the largest and the final value), predictable_until_s and
estimate_ms_per_second (CPU time, which stepping_ms_per_second excludes).)",
                  studies::kEstimateHelp));
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->inputs, false);
  command.add_option("--csv", options->csv,
                     "File for the trajectory, or folder for several scenes; -, the default "
                     "without --json: standard output");
  command.add_option("--forces", options->forces,
                     "File for tensions, forces of holds and contacts, and events; by its suffix "
                     ".npz for NumPy, .json, else CSV");
  command.add_option("--until", options->until, "End time, s, instead of the scene's duration")
      .range(1e-9, 1e9);
  command.add_option("--save-state", options->save_state,
                     "File for the state at the end, for --from-state");
  command.add_option("--from-state", options->from_state,
                     "Continue from the state in this file, with the frame after it; without an "
                     "estimate of the error");
  command
      .add_option(
          "--sweep", options->sweep,
          "Run each of COUNT evenly spaced values of a key; --csv is a folder, --json a list")
      .type_name("KEY=FROM:UNTIL:COUNT");
  command.add_option("--fps", options->fps, "Frames per second; default: the scene's")
      .range(1, 1000);
  options::add_method_options(command, options->method);
  command
      .add_option("--score", options->score,
                  "Instead of a trajectory, the error against the truth, which resolves errors "
                  "down to this share of the length")
      .range(1e-9, 1.0);
  command.add_flag("--no-estimate", options->no_estimate, "Do not estimate the run's own error");
  options::add_memory_option(command, options->max_memory);
  command.callback([options, &program] {
    program.run = [options, &program] {
      return options::for_each_run(options->inputs, options::sweep_values(options->sweep),
                                   program.common,
                                   [&](const std::string& scene, const std::string& swept) {
                                     Options one = *options;
                                     one.scene = scene;
                                     one.swept = swept;
                                     if (!swept.empty()) one.method.set.push_back(swept);
                                     return run(one, program.common);
                                   });
    };
  });
}

}  // namespace taut::cli
