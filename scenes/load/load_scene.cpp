#include "scenes/load/load_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/format/format_keys.h"
#include "scenes/format/old_keys.h"
#include "scenes/load/plan_file.h"
#include "scenes/reader/choreography.h"
#include "scenes/reader/reader.h"
#include "sim/run/bodies_as_links.h"
#include "sim/run/coarser.h"

namespace taut::scenes {

Scene load_scene(const std::filesystem::path& file, bool with_stage,
                 const std::vector<SceneChange>& changes) {
  Document document = read_document(file);
  for (const auto& [key, value] : changes) change(document, key, value);
  Scene scene = read_scene(document, with_stage);
  if (!scene.stage) Motions(document).check_characters();
  if (!scene.stage && with_stage) check_models(document);
  return scene;
}

std::vector<std::string> old_keys(const std::filesystem::path& file) {
  Document document = read_document(file);
  return rename_old_keys(document);
}

namespace {

/// Whoever asks for pixels is shown no point farther from where it is than that.
void take_exposures(const Plan& plan, Stage& stage) {
  if (plan.exposures == 0 || !plan.tolerance.ends_with("px")) return;
  stage.exposures = plan.exposures;
  stage.exposures_apart = 2 * std::stod(plan.tolerance);
}

}  // namespace

Scene load_planned(const std::filesystem::path& file, bool with_stage) {
  const Scene exact = load_scene(file, false);
  const std::optional<Plan>& plan = exact.plan;
  const auto again = [&](const std::string& why) {
    throw BadScene(fmt::format("{}: {}; taut plan {} --tolerance {} --write makes one",
                               file.string(), why, file.string(), plan ? plan->tolerance : "1px"));
  };
  if (!exact.strange_plan.empty()) {
    again(fmt::format("its plan is of another version of taut or of the scene ({})",
                      exact.strange_plan));
  }
  if (!plan) again("has no plan");
  if (plan->stamp != plan_stamp(file)) again("changed since its plan was made");
  if (plan->program != method_stamp(plan->method)) {
    again("this program's method moves otherwise than the one that its plan was made by");
  }
  std::vector<SceneChange> changes;
  for (const auto& [connector, particles] : plan->particles) {
    if (particles == 0) continue;
    changes.push_back(
        {fmt::format("connectors.{}.particles", connector), fmt::to_string(particles)});
  }
  Scene scene = load_scene(file, with_stage, changes);
  take_masses(scene.world, exact.world);
  for (Connector& connector : scene.world.connectors) {
    const auto found = plan->particles.find(connector.name.substr(0, connector.name.find('#')));
    if (found != plan->particles.end() && found->second == 0) {
      connector.model = ConnectorModel::span;
    }
  }
  neglect(scene.world, plan->neglected);
  for (std::size_t b = 0; b < scene.world.bodies.size(); ++b) {
    Body& body = scene.world.bodies[b];
    if (std::ranges::find(plan->links, body.name) == plan->links.end()) continue;
    const std::string reason = why_no_link(scene.world, scene.timeline, b);
    if (!reason.empty()) {
      throw BadScene(fmt::format("{}: [plan]: body {} cannot be a link: {}", file.string(),
                                 body.name, reason));
    }
    body.model = BodyModel::link;
  }
  scene.method = plan->method;
  if (scene.stage) take_exposures(*plan, *scene.stage);
  return scene;
}

std::optional<Choreographed> load_choreography(const std::filesystem::path& file,
                                               const std::vector<SceneChange>& changes) {
  Document document = read_document(file);
  for (const auto& [key, value] : changes) change(document, key, value);
  rename_old_keys(document);
  std::vector<Value>& all = document.root.children;
  const auto found = std::ranges::find(all, "choreography", &Value::name);
  if (found == all.end()) return std::nullopt;
  check_format(document, *found, choreography_format());
  const Value table = std::move(*found);
  all.erase(found);
  const Scene scene = read_scene(document, false);
  return read_choreography(document, table, Motions(document), scene);
}

}  // namespace taut::scenes
