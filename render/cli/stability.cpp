// taut stability: where each method fails, as maps.
#include "sim/study/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/progress.h"
#include "render/cli/study_options.h"
#include "render/interrupt.h"
#include "sim/truth/truth.h"

namespace taut::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostForTruth = 64;  // particles; beyond, the truth costs more than the map

struct Options {
  StudyOptions study;
};

/// What a map varies beside the step: values, and the changes to the scene that each asks for.
struct Variation {
  std::string name, label;
  bool log = true;
  std::vector<double> values;
  std::function<std::vector<SceneChange>(double)> changes;
};

/// Mass (kg) at the last particle, beside its own.
double load_of(const Scene& scene) {
  const Connector& rope = scene.world.connectors.front();
  const std::size_t last = rope.particles() - 1;
  for (const Hold& hold : rope.holds) {
    if (hold.particle != last) continue;
    const bool free =
        hold.to.kind == Attachment::Kind::body && !scene.world.bodies[hold.to.body].driven();
    return free ? scene.world.bodies[hold.to.body].mass_properties.mass : 0;
  }
  return rope.particle_mass.back() - rope.mass / static_cast<double>(rope.particles());
}

std::vector<double> thinned(std::vector<double> values, bool quick) {
  if (!quick) return values;
  return {values.front(), values[values.size() / 2], values.back()};
}

std::string vector_text(const Vec3& v) {
  return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
}

std::vector<Variation> axes_of(const Scene& scene, bool quick) {
  const Connector& rope = scene.world.connectors.front();
  std::vector<Variation> axes;
  if (const double load = load_of(scene); load > 0) {
    axes.push_back({"mass_ratio", "load / rope (mass)", true,
                    thinned({1, 10, 100, 1e3, 1e4, 1e5, 1e6}, quick),
                    [key = connector_key(scene, "mass"), load](double ratio) {
                      return std::vector<SceneChange>{{key, fmt::format("{:.17g}", load / ratio)}};
                    }});
  }
  axes.push_back({"particles", "particles", true, thinned({2, 5, 11, 41, 161, 641, 1000}, quick),
                  [key = connector_key(scene, "particles")](double n) {
                    return std::vector<SceneChange>{{key, fmt::format("{:.0f}", n)}};
                  }});
  const bool fixed = !rope.holds.empty() && rope.holds.front().particle == 0 &&
                     rope.holds.front().to.kind == Attachment::Kind::fixed;
  if (fixed && rope.holds.size() == 1) {
    axes.push_back({"start_angle", "start, degrees from hanging", false,
                    thinned({5, 30, 60, 90, 120, 150, 175}, quick),
                    [key = connector_key(scene, "start")](double degrees) {
                      const double a = degrees * std::numbers::pi / 180;
                      return std::vector<SceneChange>{
                          {key, fmt::format("{{ direction = {} }}",
                                            vector_text({std::sin(a), -std::cos(a), 0}))}};
                    }});
    axes.push_back(
        {"driven_speed", "peak speed of the driven end (m/s)", true,
         thinned({0.1, 0.3, 1, 3, 10, 30, 100}, quick),
         [from = connector_key(scene, "from"), at = rope.holds.front().to.point,
          travel = rope.length / 2](double speed) {
           // From rest to rest over `travel`; a quintic's peak speed is 15/8 of its mean.
           const double time = 1.875 * travel / speed;
           return std::vector<SceneChange>{
               {"paths.study",
                fmt::format("{{ keys = [ {{ t = 0, position = {}, ease = true }}, "
                            "{{ t = {:.17g}, position = {}, ease = true }} ] }}",
                            vector_text(at), time, vector_text(at + Vec3(0, travel, 0)))},
               {from, "{ path = \"study\" }"}};
         }});
  }
  return axes;
}

/// The setting that a map's height shows: the step, or what a method without one offers to sweeps.
const SettingInfo* height_of(const MethodInfo& method) {
  const SettingInfo* other = nullptr;
  for (const SettingInfo& setting : method.settings) {
    if (!std::holds_alternative<double>(setting.fallback)) continue;
    if (setting.name == "step" && (other == nullptr || !setting.sweep.empty())) return &setting;
    if (!setting.sweep.empty() && !other) other = &setting;
  }
  return other;
}

std::vector<double> heights(const SettingInfo& setting, bool quick) {
  std::vector<double> values;
  if (setting.name == "step") {
    for (double step = 1.0 / 60; step > 1.0 / 20000; step /= 2) values.push_back(step);
  } else {
    for (const Setting& value : setting.sweep) values.push_back(std::get<double>(value));
  }
  return thinned(std::move(values), quick);
}

struct MapCell {
  std::string method;
  double x = 0, y = 0;
  std::string setting;
  Judgement judgement;
  std::string reason;
};

struct Column {
  double value = 0;
  Problem problem;
  std::optional<Reference> reference;
};

Column column_of(const Options& options, const Variation& axis, double value) {
  Scene scene = study_scene(options.study, axis.changes(value));
  const double duration = options.study.quick ? 0.5 : 1.0;
  Column column{value, {scene.world, frame_times(duration, scene.fps)}, {}};
  const Connector& rope = scene.world.connectors.front();
  if (options.study.quick || rope.particles() > kMostForTruth) return column;
  TruthOptions settings;
  settings.scored_error = 0.01 * rope.length;
  settings.local_error = 1e-9;
  settings.second_accuracy = 1e-5;
  try {
    Truth truth = solve_truth(scene.world, column.problem.times, settings);
    column.reference = {std::move(truth.frames), truth.horizon, truth.self_error};
  } catch (const Diverged&) {
    // No truth: the map does without "accurate" in this column.
  }
  return column;
}

/// The edges around log- or evenly spaced values, half way to the neighbours.
std::pair<double, double> edges(const std::vector<double>& sorted, std::size_t i, bool log) {
  const auto f = [&](double v) { return log ? std::log(v) : v; };
  const auto g = [&](double v) { return log ? std::exp(v) : v; };
  const double here = f(sorted[i]);
  const double step = sorted.size() > 1 ? f(sorted[1]) - f(sorted[0]) : 1;
  const double low = i > 0 ? (f(sorted[i - 1]) + here) / 2 : here - step / 2;
  const double last = sorted.size() > 1 ? here - f(sorted[i > 0 ? i - 1 : 0]) : step;
  const double high = i + 1 < sorted.size() ? (here + f(sorted[i + 1])) / 2 : here + last / 2;
  return {g(low), g(high)};
}

std::vector<CellKind> kinds() {
  // Dark to light from bad to good, so that print without colour keeps the order.
  return {{std::string(name_of(Verdict::over_cap)), "-", 0xdddddd},
          {std::string(name_of(Verdict::failed)), "F", 0x3b0f70},
          {std::string(name_of(Verdict::stretched)), "S", 0x8c2981},
          {std::string(name_of(Verdict::over_damped)), "D", 0xde4968},
          {std::string(name_of(Verdict::accurate)), "A", 0xfcfdbf},
          {std::string(name_of(Verdict::plausible)), "P", 0xfe9f6d}};
}

Panel panel_of(const Contender& contender, const Variation& axis,
               const std::vector<Column>& columns, const std::vector<MapCell>& cells, bool quick) {
  Panel panel;
  panel.title = contender.label;
  panel.x = {axis.label, axis.log};
  if (!contender.method->missing.empty()) {
    panel.remarks.push_back({0.5, 0.5, std::string(contender.method->missing)});
    return panel;
  }
  const SettingInfo* setting = height_of(*contender.method);
  panel.y = {fmt::format("{} ({})", setting->name, setting->unit), true};
  std::vector<double> ys = heights(*setting, quick);
  std::ranges::sort(ys);
  for (const MapCell& cell : cells) {
    if (cell.method != contender.label) continue;
    const auto i =
        static_cast<std::size_t>(std::ranges::find(axis.values, cell.x) - axis.values.begin());
    const auto j = static_cast<std::size_t>(std::ranges::find(ys, cell.y) - ys.begin());
    const auto x = edges(axis.values, i, axis.log), y = edges(ys, j, true);
    panel.cells.push_back(
        {x.first, x.second, y.first, y.second, static_cast<std::size_t>(cell.judgement.verdict)});
  }
  if (!contender.method->longest_step || setting->name != "step") return panel;
  Settings full = contender.candidate.settings;
  for (const SettingInfo& info : contender.method->settings) {
    full.try_emplace(std::string(info.name), info.fallback);
  }
  Series law{"theory: " + std::string(contender.method->longest_step_law),
             {0x000000, 1, 0},
             true,
             false,
             false,
             {}};
  for (const Column& column : columns) {
    const double step = contender.method->longest_step(column.problem.world, full);
    if (step > 0 && std::isfinite(step)) law.points.push_back({column.value, step});
  }
  panel.series.push_back(std::move(law));
  return panel;
}

std::string finding(const std::vector<MapCell>& cells, const std::vector<Contender>& contenders,
                    const Variation& axis) {
  std::string best, worst;
  double most = -1, least = 2;
  for (const Contender& contender : contenders) {
    double good = 0, all = 0;
    for (const MapCell& cell : cells) {
      if (cell.method != contender.label) continue;
      ++all;
      good += cell.judgement.verdict == Verdict::accurate ||
              cell.judgement.verdict == Verdict::plausible;
    }
    if (all == 0) continue;
    if (good / all > most) most = good / all, best = contender.label;
    if (good / all < least) least = good / all, worst = contender.label;
  }
  return fmt::format("Over {}, {} holds in most cells ({:.0f}%), {} in fewest ({:.0f}%)",
                     axis.label, best, 100 * most, worst, 100 * least);
}

int run(const Options& options, const Common& common) {
  const Scene scene = study_scene(options.study);
  const std::vector<Contender> contenders = chosen_contenders(options.study);
  const std::vector<Variation> axes = axes_of(scene, options.study.quick);
  const std::filesystem::path folder = study_folder(options.study);
  std::size_t total = 0;
  for (const Variation& axis : axes) {
    for (const Contender& one : contenders) {
      const SettingInfo* setting = height_of(*one.method);
      if (one.method->missing.empty() && setting) {
        total += axis.values.size() * heights(*setting, options.study.quick).size();
      }
    }
  }
  // Most cells take far less than their share, so a cell may take several.
  const double cap =
      8 * options.study.budget / static_cast<double>(std::max<std::size_t>(1, total));
  const Clock::time_point start = Clock::now();
  Progress progress("mapping", "cells", total, common.quiet);
  std::size_t done = 0;
  Table table{{"map", "value", "method", "setting", "at", "class", "energy gained", "energy lost",
               "stretch", "error (share of length)", "reason"},
              {}};
  for (const Variation& axis : axes) {
    std::vector<Column> columns;
    for (const double value : axis.values) {
      stop_if_interrupted();
      columns.push_back(column_of(options, axis, value));
    }
    std::vector<MapCell> cells;
    for (const Contender& one : contenders) {
      const SettingInfo* setting = height_of(*one.method);
      if (!one.method->missing.empty() || !setting) continue;
      for (const Column& column : columns) {
        for (const double y : heights(*setting, options.study.quick)) {
          stop_if_interrupted();
          Candidate candidate = one.candidate;
          candidate.settings[std::string(setting->name)] = y;
          const double spent = std::chrono::duration<double>(Clock::now() - start).count();
          const double left = std::max(0.0, options.study.budget - spent);
          const Run result = taut::run(column.problem, candidate, std::min(cap, left));
          const Reference* reference = column.reference ? &*column.reference : nullptr;
          cells.push_back({one.label, column.value, y, std::string(setting->name),
                           judge(column.problem, result, reference), result.reason});
          progress.update(++done);
        }
      }
    }
    for (const MapCell& cell : cells) {
      const Judgement& j = cell.judgement;
      table.add({axis.name, rounded(cell.x), cell.method, cell.setting, rounded(cell.y),
                 std::string(name_of(j.verdict)), rounded(j.gain), rounded(j.loss),
                 rounded(j.stretch), rounded(j.error), cell.reason});
    }
    Chart chart;
    chart.title = finding(cells, contenders, axis);
    chart.subtitle =
        fmt::format("{}: class of {} s by settings. CPU cap {} s a cell. {}", scene.title,
                    rounded(columns.front().problem.duration()), rounded(cap), machine());
    chart.columns = std::min<std::size_t>(4, contenders.size());
    const std::size_t rows = (contenders.size() + chart.columns - 1) / chart.columns;
    chart.width = 1400;
    chart.height = static_cast<int>(160 + 290 * rows);
    chart.kinds = kinds();
    for (const Contender& one : contenders) {
      chart.panels.push_back(panel_of(one, axis, columns, cells, options.study.quick));
    }
    write_chart(chart, folder / ("stability_" + axis.name));
  }
  write_csv(table, folder / "stability");
  if (common.json) {
    nlohmann::ordered_json json = {{"scene", options.study.scene}};
    for (const auto& row : table.rows) json["cells"].push_back(row);
    write_output(json.dump(2) + "\n");
  }
  if (!common.quiet)
    fmt::print(stderr, "{}/stability: .csv, a .svg and .png per map\n", folder.string());
  return kDone;
}

}  // namespace

void add_stability(CLI::App& app, Program& program) {
  CLI::App& command = add_command(app, program, "stability", "Where each method fails, as maps",
                                  R"(  taut stability scenes/rope_swing.toml
  taut stability scenes/rope_swing.toml --quick
  taut stability scenes/rope_swing.toml --methods springs,direct --budget 120)");
  const auto options = std::make_shared<Options>();
  add_study_options(command, options->study, 480);
  command.callback([options, &program] {
    program.run = [options, &program] {
      if (options->study.quick) options->study.budget = std::min(options->study.budget, 20.0);
      return run(*options, program.common);
    };
  });
}

}  // namespace taut::cli
