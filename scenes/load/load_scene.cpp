#include "scenes/load/load_scene.h"

#include <fmt/format.h>

#include <algorithm>

#include "scenes/files/error.h"
#include "scenes/format/format.h"
#include "scenes/format/scene_format.h"
#include "scenes/load/plan_file.h"
#include "scenes/reader/common.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/scene.h"
#include "sim/run/reduced.h"

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

std::set<std::string> heavy_ropes(const World& world) {
  std::set<std::string> names;
  for (const Connector& connector : world.connectors) {
    // Of what has a number, spans of ropes alone have winches: those of pulleys that are driven.
    if (connector.winch && is_numbered(connector.name)) {
      names.emplace(written_name(connector.name));
    }
  }
  for (const Pulley& pulley : world.pulleys) {
    names.emplace(written_name(world.connectors[pulley.from].name));
  }
  for (const Connector& connector : world.connectors) {
    if (connector.mass == 0) names.erase(std::string(written_name(connector.name)));
  }
  return names;
}

std::vector<SceneChange> without_mass(const std::string& rope) {
  return {{fmt::format("connectors.{}.mass", rope), "0"},
          {fmt::format("connectors.{}.particles", rope), "2"}};
}

Scene load_planned(const std::filesystem::path& file, bool with_stage) {
  const Scene exact = load_scene(file, false);
  const std::optional<Plan>& plan = exact.plan;
  const auto again = [&](const char* key, const std::string& why) {
    fail_at(file, {"plan", key},
            fmt::format("{}; taut plan {} --tolerance {} --write makes one", why, file.string(),
                        plan ? plan->tolerance : "1px"));
  };
  if (!exact.strange_plan.empty()) {
    again("", fmt::format("its plan is of another version of taut or of the scene ({})",
                          exact.strange_plan));
  }
  if (!plan) again("", "has no plan");
  if (plan->stamp != plan_stamp(file)) again("stamp", "changed since its plan was made");
  if (plan->program != method_stamp(plan->method)) {
    again("program",
          "this program's method moves otherwise than the one that its plan was made by");
  }
  const std::set<std::string> heavy = heavy_ropes(exact.world);
  std::vector<SceneChange> changes;
  for (const auto& [connector, particles] : plan->particles) {
    if (particles > 0) {
      changes.push_back(
          {fmt::format("connectors.{}.particles", connector), fmt::to_string(particles)});
    } else if (heavy.contains(connector)) {
      std::ranges::copy(without_mass(connector), std::back_inserter(changes));
    }
  }
  Scene scene = load_scene(file, with_stage, changes);
  take_masses(scene.world, exact.world);
  for (Connector& connector : scene.world.connectors) {
    const std::string name(written_name(connector.name));
    const auto found = plan->particles.find(name);
    if (found != plan->particles.end() && found->second == 0 && !heavy.contains(name)) {
      connector.model = ConnectorModel::span;
    }
  }
  neglect(scene.world, plan->neglected);
  for (std::size_t b = 0; b < scene.world.bodies.size(); ++b) {
    Body& body = scene.world.bodies[b];
    if (std::ranges::find(plan->links, body.name) == plan->links.end()) continue;
    const std::string reason = why_no_link(scene.world, scene.timeline, b);
    if (!reason.empty()) {
      fail_at(file, {"plan", "links"},
              fmt::format("body {} cannot be a link: {}", body.name, reason));
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

namespace {

void add_named(const Document& document, const Value& table, const TableFormat& format,
               std::vector<std::filesystem::path>& files) {
  using Kind = KeyFormat::Type;
  const auto add = [&](const Value& value) {
    if (value.kind != Value::Kind::text) return;
    try {
      files.push_back(find_file(document, value));
    } catch (const BadScene&) {  // which is told when the scene is read
    }
  };
  for (const Value& member : table.children) {
    const KeyFormat* key = format.find(member.name);
    if (!key) continue;
    if (key->type == Kind::file) add(member);
    if (key->type == Kind::table) add_named(document, member, *key->table, files);
    for (const Value& element : member.children) {
      if (key->type == Kind::files) add(element);
      if (key->type == Kind::named || key->type == Kind::tables)
        add_named(document, element, *key->table, files);
    }
  }
}

}  // namespace

std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene) {
  std::vector<std::filesystem::path> files = {scene};
  try {
    const Document document = read_document(scene);
    if (!document.base.empty()) files.push_back(document.base);
    add_named(document, document.root, scene_format(), files);
  } catch (const BadScene&) {  // which is told when the scene is read
  }
  return files;
}

}  // namespace taut::scenes
