#include "render/study/accuracy_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "render/chart/html_page.h"
#include "render/options/method_options.h"
#include "render/program/output.h"

namespace taut::studies {
namespace {

constexpr std::size_t kShare = 0, kPixels = 1;  // the metrics of a row
constexpr double kAsked = 1e-3;                 // of the length, a middling error

std::optional<std::size_t> reaching(const AccuracyBlock& block, double error,
                                    std::size_t metric = kShare) {
  return study::cheapest(study::cost_and_error(block.rows, metric), error);
}

double least_error(const AccuracyBlock& block) {
  double least = INFINITY;
  for (const study::AccuracyRow& row : block.rows) least = std::min(least, row.errors[kShare]);
  return least;
}

double cost(const study::AccuracyRow& row) {
  return study::spread(row.cpu).median;
}

/// From the least to the most of a row's timings, and at least as far as the machine was unsteady:
/// the few timings of one row may agree by chance.
study::Spread drawn_spread(const AccuracyStudy& study, const study::AccuracyRow& row) {
  study::Spread time = study::spread(row.cpu);
  time.least = std::min(time.least, time.median * (1 - study.unsteadiness));
  time.most = std::max(time.most, time.median * (1 + study.unsteadiness));
  return time;
}

/// An error below the truth's own cannot be told, and one above the length has nothing of the
/// motion left.
bool is_shown(const AccuracyStudy& study, const study::AccuracyRow& row) {
  const double error = row.errors[kShare];
  return row.end == study::Run::End::done && error >= study.self_error && error <= 1;
}

/// Methods that stay above a middling error at all their settings.
std::string stuck(const AccuracyStudy& study) {
  std::vector<std::string> names;
  for (const AccuracyBlock& block : study.blocks) {
    const double least = least_error(block);
    if (!block.contender.candidate.settings.empty() || !std::isfinite(least) || least <= kAsked) {
      continue;
    }
    names.push_back(fmt::format("{} {}", block.contender.label, options::percent(least)));
  }
  if (names.empty()) return "";
  return fmt::format(" The least errors of methods that stay above {}: {}.",
                     options::percent(kAsked), fmt::join(names, ", "));
}

std::string circumstances(const AccuracyStudy& study) {
  return fmt::format(
      "{}, {} particles: RMS error of all particles in the first {} s, where the truth is "
      "predictable (its own error: {} of the length).",
      study.title, study.particles, options::rounded(study.horizon),
      options::percent(study.self_error));
}

}  // namespace

std::string accuracy_finding(const AccuracyStudy& study) {
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
  if (!best)
    return fmt::format("No method keeps its error below {} of the length",
                       options::percent(kAsked));
  std::string line = fmt::format("{} keeps its error below {} of the length at the least cost",
                                 best->contender.label, options::percent(kAsked));
  if (second) {
    line += fmt::format(": {} costs {} times as much", second->contender.label,
                        options::rounded(at(*second) / at(*best)));
  }
  return line;
}

chart::Table points_table(const AccuracyStudy& study, bool exact) {
  chart::Table table{
      {"method", "settings", "outcome", "error (share of length)", "CPU per simulated second (s)",
       "spread from (s)", "spread to (s)", "timings", "steps per second", "solves per second",
       "largest stretch", "on the front", "reason"},
      {}};
  if (study.in_pixels) table.columns.push_back("error (px)");
  for (const AccuracyBlock& block : study.blocks) {
    if (block.rows.empty()) {
      std::vector<std::string> cells(table.columns.size());
      cells[0] = block.contender.label;
      cells[2] = block.contender.method->missing;
      table.add(std::move(cells));
    }
    const std::vector<std::size_t> front =
        study::pareto_front(study::cost_and_error(block.rows, 0));
    for (std::size_t i = 0; i < block.rows.size(); ++i) {
      const study::AccuracyRow& row = block.rows[i];
      const study::Spread time = drawn_spread(study, row);
      const auto text = [&](double value) {
        return row.end == study::Run::End::done ? fmt::format("{:.9g}", value) : std::string();
      };
      const auto error = [&](double value) {
        return exact && row.end == study::Run::End::done ? fmt::format("{}", value) : text(value);
      };
      const bool best = std::ranges::find(front, i) != front.end();
      std::vector<std::string> cells{block.contender.label,
                                     describe(row.candidate.settings),
                                     study::text_of(row.end),
                                     error(row.errors[kShare]),
                                     text(time.median),
                                     text(time.least),
                                     text(time.most),
                                     std::to_string(row.cpu.size()),
                                     text(row.steps),
                                     text(row.solves),
                                     text(row.stretch_max),
                                     best ? "yes" : "no",
                                     row.reason};
      if (study.in_pixels) cells.push_back(error(row.errors[kPixels]));
      table.add(std::move(cells));
    }
  }
  return table;
}

chart::Table work_precision_table(const AccuracyStudy& study) {
  chart::Table table{{"method"}, {}};
  for (const double target : study.targets) {
    table.columns.push_back(fmt::format("ms/s for {:g}", target));
  }
  if (study.in_pixels) table.columns.push_back("ms/s for 1 px");
  table.columns.push_back("least error");
  table.columns.push_back("settings of the finest target reached");
  for (const AccuracyBlock& block : study.blocks) {
    std::vector<std::string> row{block.contender.label};
    std::string settings = block.rows.empty() ? std::string(block.contender.method->missing) : "";
    for (const double target : study.targets) {
      const auto found = reaching(block, target);
      row.push_back(found ? options::rounded(1e3 * cost(block.rows[*found])) : "-");
      if (found) settings = describe(block.rows[*found].candidate.settings);
    }
    if (study.in_pixels) {
      const auto found = reaching(block, 1, kPixels);
      row.push_back(found ? options::rounded(1e3 * cost(block.rows[*found])) : "-");
    }
    const double least = least_error(block);
    row.push_back(least < study.self_error ? "below " + options::rounded(study.self_error)
                                           : options::rounded(least));
    row.push_back(settings);
    table.add(std::move(row));
  }
  return table;
}

chart::Table best_table(const AccuracyStudy& study) {
  chart::Table table{{"error asked for", "cheapest", "settings", "ms per simulated second", "next",
                      "times as dear"},
                     {}};
  struct Attained {
    const AccuracyBlock* block;
    std::size_t row;
    double cost;
  };
  const auto add = [&](const std::string& name, double error, std::size_t metric) {
    std::vector<Attained> reached;
    for (const AccuracyBlock& block : study.blocks) {
      if (const auto row = reaching(block, error, metric)) {
        reached.push_back({&block, *row, cost(block.rows[*row])});
      }
    }
    std::ranges::sort(reached, {}, &Attained::cost);
    if (reached.empty()) return table.add({name, "-", "", "-", "-", "-"});
    const Attained& best = reached.front();
    const bool more = reached.size() > 1;
    table.add({name, best.block->contender.label,
               describe(best.block->rows[best.row].candidate.settings),
               options::rounded(1e3 * best.cost), more ? reached[1].block->contender.label : "-",
               more ? options::rounded(reached[1].cost / best.cost) : "-"});
  };
  for (const double target : study.targets)
    add(options::percent(target) + " of the length", target, kShare);
  if (study.in_pixels) add("1 px", 1, kPixels);
  return table;
}

namespace {

chart::Panel error_panel(const AccuracyStudy& study, std::size_t metric) {
  chart::Panel panel;
  panel.x = {"CPU time per simulated second (ms), one thread; left is faster", true};
  panel.y = {metric == kShare ? "RMS position error (share of the length); lower is better"
                              : "RMS position error (px of the scene's camera); lower is better",
             true};
  const auto command = [&](const study::AccuracyRow& row) {
    return options::score_command({study.scene, study.set}, row.candidate, study.share);
  };
  for (const AccuracyBlock& block : study.blocks) {
    std::vector<study::AccuracyRow> rows;
    std::ranges::copy_if(block.rows, std::back_inserter(rows),
                         [&](const study::AccuracyRow& row) { return is_shown(study, row); });
    const std::vector<std::size_t> best = study::pareto_front(study::cost_and_error(rows, metric));
    chart::Series front{
        options::legend_name(block.contender), block.contender.style, true, true, false, {}};
    chart::Series rest{"", block.contender.style, false, true, true, {}};
    for (const std::size_t i : best) {
      const study::Spread time = drawn_spread(study, rows[i]);
      front.points.push_back({1e3 * time.median, rows[i].errors[metric], 1e3 * time.least,
                              1e3 * time.most, chart::kAuto, chart::kAuto, command(rows[i])});
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (std::ranges::find(best, i) != best.end()) continue;
      rest.points.push_back({1e3 * cost(rows[i]), rows[i].errors[metric], chart::kAuto,
                             chart::kAuto, chart::kAuto, chart::kAuto, command(rows[i])});
    }
    panel.series.push_back(std::move(front));
    panel.series.push_back(std::move(rest));
  }
  panel.rules.push_back({1e3, true, "real time"});
  if (metric == kPixels) panel.rules.push_back({1, false, "one pixel"});
  if (metric == kShare && study.self_error > 0) {
    panel.rules.push_back({study.self_error, false, "the truth's own error"});
  }
  return panel;
}

}  // namespace

chart::Chart accuracy_chart(const AccuracyStudy& study) {
  chart::Chart chart;
  chart.title = accuracy_finding(study);
  chart.subtitle = circumstances(study) +
                   " Lines: each method's best settings; faint: the rest. Points: the median of a "
                   "run's timings; bars: all of them";
  if (study.unsteadiness > 0) {
    chart.subtitle +=
        fmt::format(", and at least {} either way", options::percent(study.unsteadiness));
  }
  chart.subtitle += ". Left out: errors above the length or below the truth's own." + stuck(study);
  chart.width = study.in_pixels ? 1500 : 1200;
  chart.height = 820;
  chart.panels.push_back(error_panel(study, kShare));
  if (study.in_pixels) {
    chart.panels.push_back(error_panel(study, kPixels));
    chart.columns = 2;
  }
  return chart;
}

std::string accuracy_section(const AccuracyStudy& study) {
  return fmt::format(
      R"({}
<h3>What to use</h3>
{}
<h3>What an error costs</h3>
<p>Milliseconds of CPU time per simulated second of the cheapest settings tried that reach an RMS
error, as a share of the length.</p>
{}
)",
      chart::html_chart(accuracy_chart(study)), chart::to_html(best_table(study)),
      chart::to_html(work_precision_table(study)));
}

std::string accuracy_page(const AccuracyStudy& study) {
  std::string model;
  if (!study.model.rows.empty()) {
    model = fmt::format(
        "<h2>What few particles miss</h2>\n<p>A chain of n particles is not the continuous rope "
        "that it stands for. This error is the model's: no solver and no step removes it.</p>\n{}\n"
        "{}",
        chart::html_chart(model_chart(study.model, study.title)),
        chart::to_html(model_table(study.model)));
  }
  return chart::html_page(
      study.title + ": speed against accuracy",
      fmt::format("<p>Scene: {}. {}.</p>\n{}{}\n<h2>Every run</h2>\n{}",
                  chart::escape_html(study.scene), chart::escape_html(options::machine()),
                  accuracy_section(study), model, chart::to_html(points_table(study, false))));
}

std::string accuracy_json(const AccuracyStudy& study) {
  nlohmann::ordered_json json = {{"scene", study.scene},
                                 {"machine", options::machine()},
                                 {"horizon_s", study.horizon},
                                 {"self_error", study.self_error}};
  json["methods"] = nlohmann::ordered_json::array();
  for (const AccuracyBlock& block : study.blocks) {
    nlohmann::ordered_json one = {{"method", block.contender.label}};
    const std::string missing(block.contender.method->missing);
    if (!missing.empty()) one["missing"] = missing;
    for (const double target : study.targets) {
      const auto found = reaching(block, target);
      nlohmann::ordered_json point = {{"error", target}, {"cpu_ms_per_simulated_s", nullptr}};
      if (found) {
        point["cpu_ms_per_simulated_s"] = 1e3 * cost(block.rows[*found]);
        point["settings"] = options::settings_json(block.rows[*found].candidate.settings);
      }
      one["work_precision"].push_back(std::move(point));
    }
    if (study.in_pixels) {
      const auto found = reaching(block, 1, kPixels);
      one["cpu_ms_per_simulated_s_for_1_px"] = nullptr;
      if (found) one["cpu_ms_per_simulated_s_for_1_px"] = 1e3 * cost(block.rows[*found]);
    }
    one["least_error"] = nullptr;
    if (const double least = least_error(block); std::isfinite(least)) {
      one["least_error"] = std::max(least, study.self_error);
    }
    json["methods"].push_back(std::move(one));
  }
  for (const ModelRow& row : study.model.rows) {
    json["model_error"].push_back(
        {{"particles", row.particles}, {"links", row.links}, {"span", row.span}});
  }
  return program::json_text(json) + "\n";
}

}  // namespace taut::studies
