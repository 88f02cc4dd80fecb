#include "render/study/answer_costs.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/base/interrupt.h"
#include "render/options/study_options.h"
#include "sim/measure/measure.h"

namespace taut::studies {
namespace {

constexpr double kFirstSteps = 4, kFirstEngineSteps = 32;  // of a scene, at the coarsest step
constexpr std::size_t kMostRuns = 24;
constexpr int kRunsWithoutGain = 4;

bool is_complete(Verdict::Kind kind) {
  return kind == Verdict::Kind::passes || kind == Verdict::Kind::fails;
}

/// Whether a quantity is a coordinate of a place.
bool is_place(std::string_view quantity) {
  const std::size_t dot = quantity.rfind('.');
  if (dot == std::string_view::npos) return false;
  const std::string_view axis = quantity.substr(dot + 1), of = quantity.substr(0, dot);
  if (axis != "x" && axis != "y" && axis != "z") return false;
  if (of == "momentum" || of == "angular_momentum") return false;
  return !of.ends_with(".hold") && !of.ends_with(".moment") && !of.ends_with(".contact");
}

/// The largest error of a place, as a share of the length.
double error_of(const AnswerCase& of, const Verdict& verdict) {
  double largest = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < verdict.values.size(); ++i) {
    if (!is_place(of.answers[i].quantity)) continue;
    const double error = std::abs(verdict.values[i] - of.answers[i].value) / length_of(of);
    largest = std::isnan(error) ? std::numeric_limits<double>::infinity()
                                : std::max(std::isnan(largest) ? 0.0 : largest, error);
  }
  return largest;
}

/// The largest tolerance of a place, as a share of the length: smaller errors tell no order.
double floor_of(const AnswerCase& of) {
  double largest = 0;
  for (const Answer& answer : of.answers) {
    if (is_place(answer.quantity)) largest = std::max(largest, answer.tolerance / length_of(of));
  }
  return largest;
}

bool is_better(const Verdict& one, const Verdict& other) {
  if (is_complete(one.kind) != is_complete(other.kind)) return is_complete(one.kind);
  return is_complete(one.kind) ? one.share < other.share : false;
}

/// Runs at `value`, and at halves of it.
using RunAt = std::function<Verdict(double value, double cpu_cap)>;

Verdict refine(const AnswerCase& of, bool is_of_step, double value, double cpu_cap,
               const RunAt& run) {
  Verdict best;
  std::vector<Verdict::Run> runs;
  int without_gain = 0;
  for (double spent = 0; runs.size() < kMostRuns; value /= 2) {
    render::stop_if_interrupted();
    Verdict now = run(value, cpu_cap - spent);
    if (now.kind == Verdict::Kind::not_followed) return now;
    spent += now.cpu;
    runs.push_back({is_of_step, value, now.kind, error_of(of, now), now.cpu});
    const double cost = now.cpu;
    const Verdict::Kind kind = now.kind;
    if (runs.size() == 1 || is_better(now, best)) {
      best = std::move(now);
      without_gain = 0;
    } else if (is_complete(best.kind)) {
      ++without_gain;
    }
    if (kind == Verdict::Kind::broken || kind == Verdict::Kind::passes ||
        without_gain == kRunsWithoutGain)
      break;
    if (spent + 2 * cost > cpu_cap) break;
  }
  best.runs = std::move(runs);
  return best;
}

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
}

std::string in_ms(const std::optional<double>& seconds) {
  return seconds ? options::rounded(1e3 * *seconds) : "-";
}

std::optional<double> least_error(const Verdict& verdict) {
  std::optional<double> least;
  for (const Verdict::Run& run : verdict.runs) {
    if (is_complete(run.kind) && run.error < least.value_or(INFINITY)) least = run.error;
  }
  return least;
}

}  // namespace

double length_of(const AnswerCase& of) {
  return length_scale(of.scene.world);
}

Verdict refined(const AnswerCase& of, const Engine& engine, double cpu_cap) {
  return refine(of, true, of.scene.duration / kFirstEngineSteps, cpu_cap,
                [&](double step, double cap) { return verify(of, engine, step, cap); });
}

Verdict refined(const AnswerCase& of, const options::Contender& contender,
                const std::vector<std::string>& set, double cpu_cap) {
  const auto runs_of = [&](const char* key) -> RunAt {
    return [&, key](double value, double cap) {
      std::vector<std::string> with = set;
      with.push_back(fmt::format("{}={:.17g}", key, value));
      Verdict verdict = verify(of, contender, with, cap);
      constexpr double kShort = 2e-3;  // s: the clock tells it badly
      for (int more = 0; more < 2 && verdict.cpu < kShort && is_complete(verdict.kind); ++more) {
        verdict.cpu = std::min(verdict.cpu, verify(of, contender, with, cap).cpu);
      }
      return verdict;
    };
  };
  const auto setting = [&](std::string_view key) {
    const auto found = std::ranges::find(contender.method->settings, key, &SettingInfo::name);
    return found == contender.method->settings.end() ? nullptr : &*found;
  };
  const SettingInfo *step = setting("step"), *tolerance = setting("tolerance");
  if (!step) {
    Verdict verdict = verify(of, contender, set, cpu_cap);
    if (verdict.kind != Verdict::Kind::not_followed)
      verdict.runs.push_back({false, 0, verdict.kind, error_of(of, verdict), verdict.cpu});
    return verdict;
  }
  Verdict best = refine(of, true, std::min(of.scene.duration / kFirstSteps, step->maximum),
                        cpu_cap / 2, runs_of("step"));
  if (!tolerance || best.kind == Verdict::Kind::not_followed) return best;
  Verdict other = refine(of, false, std::min(length_of(of) / 10, tolerance->maximum), cpu_cap / 2,
                         runs_of("tolerance"));
  std::vector<Verdict::Run> runs = std::move(best.runs);
  runs.insert(runs.end(), other.runs.begin(), other.runs.end());
  if (is_better(other, best)) best = std::move(other);
  best.runs = std::move(runs);
  return best;
}

std::optional<double> order_of(const AnswerCase& of, const Verdict& verdict) {
  std::vector<double> orders;
  const double least = floor_of(of);
  const auto tells = [&](const Verdict::Run& run) {
    return run.is_of_step && is_complete(run.kind) && run.error > least && run.error < kErrors[0];
  };
  for (std::size_t i = 1; i < verdict.runs.size(); ++i) {
    const Verdict::Run &coarse = verdict.runs[i - 1], &fine = verdict.runs[i];
    if (!tells(coarse) || !tells(fine)) continue;
    orders.push_back(std::log(coarse.error / fine.error) / std::log(coarse.value / fine.value));
  }
  return median(std::move(orders));
}

std::optional<double> cost_of(const Verdict& verdict, double error) {
  std::optional<double> least;
  for (const Verdict::Run& run : verdict.runs) {
    if (is_complete(run.kind) && run.error <= error)
      least = std::min(run.cpu, least.value_or(INFINITY));
  }
  return least;
}

chart::Table costs_table(const std::vector<Verified>& all) {
  chart::Table table{{"case", "method", "verdict", "order", "ms for 10%", "ms for 1%",
                      "ms for 0.1%", "least error"},
                     {}};
  for (const Verified& one : all) {
    for (const auto& [method, verdict] : one.verdicts) {
      const auto order = order_of(one.of, verdict);
      const auto least = least_error(verdict);
      std::vector<std::string> row{
          one.of.name, method, text_of(verdict.kind),
          order ? fmt::format("{:.1f}", std::round(10 * *order) / 10 + 0.0) : "-"};
      for (const double error : kErrors) row.push_back(in_ms(cost_of(verdict, error)));
      row.push_back(least ? options::percent(*least) : "-");
      table.add(std::move(row));
    }
  }
  return table;
}

void add_costs(program::Json& entry, const AnswerCase& of, const Verdict& verdict) {
  const auto or_null = [](const std::optional<double>& value) {
    return value ? program::number_or_null(*value) : program::Json(nullptr);
  };
  entry["order"] = or_null(order_of(of, verdict));
  entry["least_error"] = or_null(least_error(verdict));
  entry["costs"] = program::Json::array();
  for (const double error : kErrors) {
    entry["costs"].push_back({{"error", error}, {"cpu_s", or_null(cost_of(verdict, error))}});
  }
  entry["runs"] = program::Json::array();
  for (const Verdict::Run& run : verdict.runs) {
    entry["runs"].push_back({{run.is_of_step ? "step_s" : "tolerance_m", run.value},
                             {"verdict", text_of(run.kind)},
                             {"error", program::number_or_null(run.error)},
                             {"cpu_s", run.cpu}});
  }
}

chart::Chart costs_chart(const std::vector<Verified>& all,
                         const std::vector<chart::Style>& styles) {
  const auto with_places = std::ranges::count_if(all, [](const Verified& one) {
    return std::ranges::any_of(one.of.answers, is_place, &Answer::quantity);
  });
  chart::Chart made;
  made.columns = std::size(kErrors);
  made.width = 1320;
  made.height = 560;
  made.title =
      fmt::format("How many of {} known answers each method gives, by CPU time", with_places);
  made.subtitle =
      "A case counts from the CPU time of the cheapest run whose places are within the error, as a "
      "share of the length.";
  for (const double error : kErrors) {
    chart::Panel panel;
    panel.title = fmt::format("error of {}", options::percent(error));
    panel.x = {.label = "CPU time per simulated second, ms", .log = true};
    panel.y = {.label = "cases",
               .minimum = 0,
               .maximum = double(std::max<std::ptrdiff_t>(with_places, 1))};
    for (std::size_t m = 0; m < styles.size(); ++m) {
      std::vector<double> costs;
      for (const Verified& one : all) {
        const auto cost = cost_of(one.verdicts[m].second, error);
        if (cost) costs.push_back(1e3 * std::max(*cost, 1e-9) / one.of.scene.duration);
      }
      std::ranges::sort(costs);
      chart::Series series{.name = all.front().verdicts[m].first,
                           .style = styles[m],
                           .markers = false,
                           .points = {}};
      for (std::size_t i = 0; i < costs.size(); ++i) {
        series.points.push_back({.x = costs[i], .y = double(i)});
        series.points.push_back({.x = costs[i], .y = double(i + 1)});
      }
      if (!series.points.empty()) panel.series.push_back(std::move(series));
    }
    made.panels.push_back(std::move(panel));
  }
  return made;
}

}  // namespace taut::studies
