#include "render/plan/plan_table.h"

#include <fmt/format.h>

#include "render/options/method_options.h"
#include "render/options/study_options.h"
#include "scenes/load/load_scene.h"
#include "scenes/load/plan_file.h"

namespace taut::planning {
namespace {

std::string model_of(const scenes::Plan& plan) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto& [connector, particles] : plan.particles) {
    add(particles > 0 ? fmt::format("{}: {} particles", connector, particles)
                      : connector + ": a massless span");
  }
  for (const std::string& body : plan.links) add(body + " a link");
  for (const Physics one : plan.neglected) add(fmt::format("no {}", name_of(one)));
  if (plan.exposures > 0) add(fmt::format("{} exposures", plan.exposures));
  return text;
}

std::string found_of(const scenes::Plan& plan) {
  const std::string unit(scenes::read_length(plan.tolerance)->unit);
  std::string text = plan.until > 0 ? fmt::format("{} {} until {} s", options::rounded(plan.error),
                                                  unit, options::rounded(plan.until))
                                    : "not predictable";
  if (const auto& later = plan.afterwards) {
    text += fmt::format("; then energy {}%", options::rounded(100 * later->energy));
  }
  return text;
}

std::vector<std::string> row_of(const scenes::Scene& scene) {
  const std::string name = scene.file.stem().string();
  if (!scene.plan) {
    const char* const why = scene.strange_plan.empty() ? "has no plan" : "cannot be read";
    return {name, "-", "-", "-", why};
  }
  const scenes::Plan& plan = *scene.plan;
  const bool changed = plan.stamp != scenes::plan_stamp(scene.file);
  const bool moves_otherwise = plan.program != scenes::method_stamp(plan.method);
  return {name, plan.tolerance, model_of(plan), describe(plan.method),
          changed           ? "the scene changed since"
          : moves_otherwise ? "the method moves otherwise since"
                            : found_of(plan)};
}

}  // namespace

chart::Table plan_table(const std::vector<std::string>& scenes) {
  chart::Table table{{"scene", "asked", "model", "method", "found"}, {}};
  for (const std::string& scene : scenes) table.add(row_of(scenes::load_scene(scene, false)));
  return table;
}

program::Json plans_json(const std::vector<std::string>& files) {
  program::Json list = program::Json::array();
  for (const std::string& file : files) {
    const scenes::Scene scene = scenes::load_scene(file, false);
    program::Json one = {{"scene", file}, {"plan", nullptr}, {"strange", scene.strange_plan}};
    if (scene.plan) {
      const scenes::Plan& plan = *scene.plan;
      one["plan"] = {{"tolerance", plan.tolerance},
                     {"error", plan.error},
                     {"error_unit", scenes::read_length(plan.tolerance)->unit},
                     {"until_s", plan.until},
                     {"method", plan.method.name},
                     {"settings", options::settings_json(plan.method.settings)},
                     {"particles", plan.particles},
                     {"bodies_as_links", plan.links},
                     {"neglected", names_of(plan.neglected)},
                     {"exposures", plan.exposures},
                     {"scene_changed", plan.stamp != scenes::plan_stamp(scene.file)},
                     {"method_changed", plan.program != scenes::method_stamp(plan.method)}};
    }
    list.push_back(std::move(one));
  }
  return {{"scenes", std::move(list)}};
}

}  // namespace taut::planning
