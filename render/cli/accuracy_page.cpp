#include "render/cli/accuracy_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace taut::cli {
namespace {

std::optional<std::size_t> reaching(const AccuracyBlock& block, double error) {
  return cheapest(cost_and_error(block.rows, 0), error);
}

double cost(const AccuracyRow& row) {
  return spread(row.cpu).median;
}

std::string percent(double share) {
  return fmt::format("{}%", rounded(100 * share));
}

const char* outcome(const AccuracyRow& row) {
  switch (row.end) {
    case Run::End::done:
      return "done";
    case Run::End::diverged:
      return "diverged";
    case Run::End::over_cap:
      return "over its CPU cap";
  }
  return "";
}

/// The cheapest method at a middling error, in a sentence.
std::string finding(const AccuracyStudy& study) {
  constexpr double kAsked = 1e-3;
  const AccuracyBlock* best = nullptr;
  const AccuracyBlock* second = nullptr;
  const auto at = [&](const AccuracyBlock& block) {
    return cost(block.rows[*reaching(block, kAsked)]);
  };
  for (const AccuracyBlock& block : study.blocks) {
    if (!reaching(block, kAsked)) continue;
    if (!best || at(block) < at(*best)) {
      second = best;
      best = &block;
    } else if (!second || at(block) < at(*second)) {
      second = &block;
    }
  }
  if (!best) return fmt::format("No method comes within {} of the length", percent(kAsked));
  std::string line = fmt::format("For an error of {} of the length {} is cheapest", percent(kAsked),
                                 best->contender.label);
  if (second) {
    line += fmt::format(": {} times cheaper than {}, the next", rounded(at(*second) / at(*best)),
                        second->contender.label);
  }
  return line;
}

std::string circumstances(const AccuracyStudy& study) {
  return fmt::format(
      "{}, {} particles: RMS error of all particles in the first {} s, where the truth is "
      "predictable (its own error: {} of the length).",
      study.title, study.particles, rounded(study.horizon), percent(study.self_error));
}

}  // namespace

Table points_table(const AccuracyStudy& study) {
  Table table{{"method", "settings", "outcome", "error (share of length)",
               "CPU per simulated second (s)", "low quartile (s)", "high quartile (s)", "timings",
               "steps per second", "solves per second", "largest stretch", "on the front"},
              {}};
  for (const AccuracyBlock& block : study.blocks) {
    if (block.rows.empty()) {
      table.add({block.contender.label, "", std::string(block.contender.method->missing), "", "",
                 "", "", "", "", "", "", ""});
    }
    const std::vector<std::size_t> front = pareto_front(cost_and_error(block.rows, 0));
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      const AccuracyRow& row = block.rows[i];
      const Spread time = spread(row.cpu);
      const auto text = [&](double value) {
        return row.end == Run::End::done ? fmt::format("{:.9g}", value) : std::string();
      };
      const bool best = std::ranges::find(front, i) != front.end();
      table.add({block.contender.label, describe(row.candidate.settings), outcome(row),
                 text(row.errors[0]), text(time.median), text(time.low), text(time.high),
                 std::to_string(row.cpu.size()), text(row.steps), text(row.solves),
                 text(row.stretch_max), best ? "yes" : "no"});
    }
  }
  return table;
}

Table reach_table(const AccuracyStudy& study) {
  Table table{{"method"}, {}};
  for (const double target : study.targets) {
    table.columns.push_back(fmt::format("ms/s for {:g}", target));
  }
  table.columns.push_back("least error");
  table.columns.push_back("settings of the finest target reached");
  for (const AccuracyBlock& block : study.blocks) {
    std::vector<std::string> row{block.contender.label};
    std::string settings = block.rows.empty() ? std::string(block.contender.method->missing) : "";
    for (const double target : study.targets) {
      const auto found = reaching(block, target);
      row.push_back(found ? rounded(1e3 * cost(block.rows[*found])) : "-");
      if (found) settings = describe(block.rows[*found].candidate.settings);
    }
    double least = INFINITY;
    for (const AccuracyRow& one : block.rows) least = std::min(least, one.errors[0]);
    row.push_back(rounded(least));
    row.push_back(settings);
    table.add(std::move(row));
  }
  return table;
}

Chart accuracy_chart(const AccuracyStudy& study) {
  Chart chart;
  chart.title = finding(study);
  chart.subtitle = circumstances(study) +
                   " Lines: each method's best settings; faint: the rest. Bars: quartiles.";
  chart.width = 1200;
  chart.height = 820;
  Panel panel;
  panel.x = {"CPU time per simulated second (ms), one thread; left is faster", true};
  panel.y = {"RMS position error (share of the length); lower is better", true};
  panel.y.maximum = 3;
  for (const AccuracyBlock& block : study.blocks) {
    const std::vector<std::size_t> best = pareto_front(cost_and_error(block.rows, 0));
    Series front{block.contender.label, block.contender.style, true, true, false, {}};
    Series rest{"", block.contender.style, false, true, true, {}};
    for (const std::size_t i : best) {
      const Spread time = spread(block.rows[i].cpu);
      front.points.push_back({1e3 * time.median, block.rows[i].errors[0], 1e3 * time.low,
                              1e3 * time.high, kAuto, kAuto});
    }
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      if (block.rows[i].end != Run::End::done) continue;
      if (std::ranges::find(best, i) != best.end()) continue;
      rest.points.push_back({1e3 * cost(block.rows[i]), block.rows[i].errors[0]});
    }
    panel.series.push_back(std::move(front));
    panel.series.push_back(std::move(rest));
  }
  panel.rules.push_back({1e3, true, "real time"});
  if (study.self_error > 0)
    panel.rules.push_back({study.self_error, false, "the truth's own error"});
  chart.panels = {std::move(panel)};
  return chart;
}

std::string accuracy_page(const AccuracyStudy& study, const std::string& svg) {
  return fmt::format(
      R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{0}: speed against accuracy</title>
<style>
body {{ font: 15px/1.5 "DejaVu Sans", sans-serif; max-width: 1200px; margin: 2em auto; padding: 0 1em; }}
svg {{ width: 100%; height: auto; }}
table {{ border-collapse: collapse; font-size: 13px; display: block; overflow-x: auto; }}
th, td {{ padding: 2px 10px; border-bottom: 1px solid #ddd; text-align: left; }}
.number {{ text-align: right; font-variant-numeric: tabular-nums; }}
</style></head><body>
<h1>{0}: speed against accuracy</h1>
<p>{1}</p>
<p>Scene: {2}. {3}.</p>
{4}
<h2>What an error costs</h2>
<p>Milliseconds of CPU time per simulated second of the cheapest settings tried that reach an RMS
error, as a share of the length.</p>
{5}
<h2>Every run</h2>
{6}</body></html>
)",
      escape_html(study.title), escape_html(circumstances(study)), escape_html(study.scene),
      escape_html(machine()), svg.substr(std::min(svg.size(), svg.find("<svg"))),
      to_html(reach_table(study)), to_html(points_table(study)));
}

std::string accuracy_json(const AccuracyStudy& study) {
  nlohmann::ordered_json json = {{"scene", study.scene},
                                 {"machine", machine()},
                                 {"horizon", study.horizon},
                                 {"self_error", study.self_error}};
  json["methods"] = nlohmann::ordered_json::array();
  for (const AccuracyBlock& block : study.blocks) {
    nlohmann::ordered_json one = {{"method", block.contender.label}};
    for (const double target : study.targets) {
      const auto found = reaching(block, target);
      nlohmann::ordered_json reach = {{"error", target}, {"ms_per_second", nullptr}};
      if (found) {
        reach["ms_per_second"] = 1e3 * cost(block.rows[*found]);
        reach["settings"] = describe(block.rows[*found].candidate.settings);
      }
      one["reach"].push_back(std::move(reach));
    }
    json["methods"].push_back(std::move(one));
  }
  return json.dump(2) + "\n";
}

}  // namespace taut::cli
