#include "render/cli/plan_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

#include "render/cli/method_options.h"
#include "render/cli/study_options.h"
#include "render/table.h"

namespace taut::cli {
namespace {

std::string outcome(const Trial& trial, const std::string& unit) {
  switch (trial.end) {
    case Trial::End::within:
      return fmt::format("{} {} off", rounded(trial.error), unit);
    case Trial::End::beyond:
      return fmt::format("at least {} {} off", rounded(trial.error), unit);
    case Trial::End::dearer:
      return "dearer";
    case Trial::End::diverged:
      return "cannot run it";
  }
  return "";
}

/// What came nearest to being chosen of the trials that `wanted` names: the cheapest within, else
/// one that was only too dear, else the least error.
const Trial* nearest(const Search& search, const auto& wanted) {
  const Trial* best = nullptr;
  for (const Trial& trial : search.trials) {
    if (!wanted(trial)) continue;
    const auto rank = [](const Trial& t) {
      const bool by_work = t.end == Trial::End::within;
      return std::tuple(by_work                       ? 0
                        : t.end == Trial::End::dearer ? 1
                        : t.end == Trial::End::beyond ? 2
                                                      : 3,
                        by_work ? t.work : t.error);
    };
    if (!best || rank(trial) < rank(*best)) best = &trial;
  }
  return best;
}

/// Models beyond the tolerance however well they are solved, and of every other method what came
/// nearest to being chosen.
Table left_out(const Planned& planned) {
  Table table{{"model", "method", "outcome"}, {}};
  const auto method_of = [&](const Trial& trial) {
    return planned.models[trial.model].model.candidates[trial.candidate].method;
  };
  for (const SceneModel& model : planned.models) {
    if (!model.model.candidates.empty()) continue;
    table.add({describe(model, planned.scene), "any",
               fmt::format("{} {} off", rounded(model.error), planned.asked.unit)});
  }
  for (const MethodInfo& method : methods()) {
    if (method.name == planned.candidate().method) continue;
    const Trial* trial =
        nearest(planned.search, [&](const Trial& t) { return method_of(t) == method.name; });
    if (!trial) continue;
    const SceneModel& model = planned.models[trial->model];
    table.add({describe(model, planned.scene), describe(model.model.candidates[trial->candidate]),
               outcome(*trial, planned.asked.unit)});
  }
  return table;
}

std::string times_less(double before, double now) {
  return now <= before ? fmt::format("{} times less", rounded(before / now))
                       : fmt::format("{} times more", rounded(now / before));
}

}  // namespace

std::string plan_text(const Planned& planned) {
  const Scene& scene = planned.scene;
  std::string text = fmt::format("{}: {}\n", scene.file.string(), certificate(planned.plan));
  const auto line = [&](const char* what, const std::string& is) {
    text += fmt::format("  {:<10}{}\n", what, is);
  };
  line("model", describe(planned.model(), scene));
  line("method", describe(planned.candidate()));
  line("error", fmt::format("{} {} at most, of every particle and the ends of every body in {} "
                            "frames (the truth's own: {} {})",
                            rounded(planned.best.error), planned.asked.unit,
                            std::ranges::count_if(planned.truth.frames,
                                                  [&](const Snapshot& frame) {
                                                    return frame.time <= planned.truth.horizon;
                                                  }),
                            rounded(planned.asked.per_metre * planned.truth.self_error),
                            planned.asked.unit));
  line("work", times_less(planned.work_as_written, planned.best.work) +
                   fmt::format(" than as it is written ({}, {} {} off)",
                               describe(Candidate{scene.method.name, scene.method.settings}),
                               rounded(planned.error_as_written), planned.asked.unit));
  line("measured",
       fmt::format("{} ms of CPU time per simulated second, {}", rounded(1e3 * planned.cost),
                   times_less(planned.cost_as_written, planned.cost)));
  const Afterwards& after = planned.after;
  line("later", fmt::format("stretch {} at most{}", rounded(after.stretch),
                            after.energy ? fmt::format(", energy within {}% of what can move",
                                                       rounded(100 * *after.energy))
                                         : ""));
  if (after.true_speeds.most > 0) {
    line("", fmt::format("speeds of particles (quartiles, m/s): {} {} {}; of the truth {} {} {}",
                         rounded(after.speeds.low), rounded(after.speeds.median),
                         rounded(after.speeds.high), rounded(after.true_speeds.low),
                         rounded(after.true_speeds.median), rounded(after.true_speeds.high)));
  }
  return text + "\nLeft out:\n" + to_text(left_out(planned));
}

std::string plan_json(const Planned& planned) {
  nlohmann::ordered_json json = {{"scene", planned.scene.file.string()},
                                 {"tolerance", planned.plan.tolerance},
                                 {"certificate", certificate(planned.plan)},
                                 {"until", planned.plan.until},
                                 {"error", planned.plan.error},
                                 {"method", planned.plan.method.name},
                                 {"settings", settings_json(planned.plan.method.settings)},
                                 {"particles", planned.plan.particles},
                                 {"work", planned.best.work},
                                 {"work_as_written", planned.work_as_written},
                                 {"ms_per_second", 1e3 * planned.cost},
                                 {"ms_per_second_as_written", 1e3 * planned.cost_as_written},
                                 {"error_as_written", planned.error_as_written},
                                 {"stretch", planned.after.stretch},
                                 {"energy", nullptr}};
  if (planned.after.energy) json["energy"] = *planned.after.energy;
  for (const auto& row : left_out(planned).rows) {
    json["left_out"].push_back({{"model", row[0]}, {"method", row[1]}, {"outcome", row[2]}});
  }
  return json.dump(2) + "\n";
}

}  // namespace taut::cli
