#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/options/method_options.h"
#include "render/study/work_precision.h"

namespace taut::studies {
namespace {

/// The cheapest row of every contender that comes within `error` (m).
std::vector<const study::AccuracyRow*> cheapest_rows(const AccuracyStudy& study, double error) {
  std::vector<const study::AccuracyRow*> rows;
  for (const AccuracyBlock& block : study.blocks) {
    const auto row = study::cheapest(study::cost_and_error(block.rows, 0), error);
    rows.push_back(row ? &block.rows[*row] : nullptr);
  }
  return rows;
}

double milliseconds(const study::AccuracyRow& row) {
  return 1e3 * study::spread(row.cpu).median;
}

/// The row that comes nearest to the truth; null where none is done.
const study::AccuracyRow* nearest_row(const AccuracyBlock& block) {
  const study::AccuracyRow* nearest = nullptr;
  for (const study::AccuracyRow& row : block.rows) {
    if (row.end != study::Run::End::done) continue;
    if (!nearest || row.errors[0] < nearest->errors[0]) nearest = &row;
  }
  return nearest;
}

program::Json row_json(const study::AccuracyRow& row) {
  const study::Spread time = study::spread(row.cpu);
  return {{"cpu_ms_per_simulated_s", 1e3 * time.median},
          {"low_quartile_ms", 1e3 * time.low},
          {"high_quartile_ms", 1e3 * time.high},
          {"timings", row.cpu.size()},
          {"rms_error_m", row.errors[0]},
          {"penetration_m", row.penetration_max},
          {"energy_gained_j", row.energy_gain},
          {"settings", options::settings_json(row.candidate.settings)}};
}

}  // namespace

chart::Table costs_of_errors(const std::vector<AccuracyStudy>& studies,
                             const std::vector<double>& errors) {
  chart::Table table{{"ms per simulated second"}, {}};
  std::vector<std::vector<std::string>> rows;
  for (const AccuracyBlock& block : studies.front().blocks) rows.push_back({block.contender.label});
  for (const AccuracyStudy& study : studies) {
    for (const double error : errors) {
      table.columns.push_back(fmt::format("{}: {:g} mm", study.title, 1e3 * error));
      const auto best = cheapest_rows(study, error);
      double least = INFINITY;
      for (const study::AccuracyRow* row : best) {
        if (row) least = std::min(least, milliseconds(*row));
      }
      for (std::size_t i = 0; i < best.size(); ++i) {
        const std::string missing(study.blocks[i].contender.method->missing);
        rows[i].push_back(!missing.empty() ? missing
                          : !best[i]
                              ? "-"
                              : fmt::format("{} ({}x)", options::rounded(milliseconds(*best[i])),
                                            options::rounded(milliseconds(*best[i]) / least)));
      }
    }
  }
  for (auto& row : rows) table.add(std::move(row));
  return table;
}

chart::Table cheapest_settings(const std::vector<AccuracyStudy>& studies,
                               const std::vector<double>& errors) {
  chart::Table table{{"scene", "method", "error asked for (m)", "settings", "error (m)",
                      "CPU per simulated second (s)", "low quartile (s)", "high quartile (s)",
                      "timings", "penetration (m)", "energy gained (J)"},
                     {}};
  for (const AccuracyStudy& study : studies) {
    for (const double error : errors) {
      const auto best = cheapest_rows(study, error);
      for (std::size_t i = 0; i < best.size(); ++i) {
        if (!best[i]) continue;
        const study::Spread time = study::spread(best[i]->cpu);
        table.add({study.scene, study.blocks[i].contender.label, fmt::format("{:g}", error),
                   describe(best[i]->candidate.settings), fmt::format("{:.3g}", best[i]->errors[0]),
                   fmt::format("{:.4g}", time.median), fmt::format("{:.4g}", time.low),
                   fmt::format("{:.4g}", time.high), std::to_string(best[i]->cpu.size()),
                   fmt::format("{:.2g}", best[i]->penetration_max),
                   fmt::format("{:.2g}", best[i]->energy_gain)});
      }
    }
  }
  return table;
}

chart::Table errors_not_attained(const std::vector<AccuracyStudy>& studies,
                                 const std::vector<double>& errors) {
  chart::Table table{{"scene", "empty for", "nearest (m)", "settings", "others"}, {}};
  const double least = *std::ranges::min_element(errors);
  for (const AccuracyStudy& study : studies) {
    for (const AccuracyBlock& block : study.blocks) {
      if (block.rows.empty() || study::cheapest(study::cost_and_error(block.rows, 0), least))
        continue;
      const study::AccuracyRow* nearest = nearest_row(block);
      const auto ended = std::ranges::find_if(block.rows, [](const study::AccuracyRow& row) {
        return row.end != study::Run::End::done;
      });
      table.add({study.scene, block.contender.label,
                 nearest ? fmt::format("{:.3g}", nearest->errors[0]) : "none",
                 nearest ? describe(nearest->candidate.settings) : "",
                 ended == block.rows.end() ? "" : ended->reason});
    }
  }
  return table;
}

program::Json work_precision_json(const AccuracyStudy& study, const std::vector<double>& errors) {
  program::Json json = {{"scene", study.scene},
                        {"title", study.title},
                        {"horizon_s", study.horizon},
                        {"self_error_m", study.self_error}};
  for (const AccuracyBlock& block : study.blocks) {
    program::Json entry = {{"method", block.contender.label}};
    const std::string missing(block.contender.method->missing);
    if (!missing.empty()) entry["missing"] = missing;
    for (const double error : errors) {
      const auto found = study::cheapest(study::cost_and_error(block.rows, 0), error);
      program::Json point = {{"error_asked_m", error}, {"cpu_ms_per_simulated_s", nullptr}};
      if (found) point.update(row_json(block.rows[*found]));
      entry["work_precision"].push_back(std::move(point));
    }
    const study::AccuracyRow* nearest = nearest_row(block);
    entry["least_rms_error_m"] = program::number_or_null(nearest ? nearest->errors[0] : INFINITY);
    if (nearest) entry["nearest"] = row_json(*nearest);
    json["methods"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace taut::studies
