#include "scenes/scene.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "scenes/reader/format.h"
#include "scenes/reader/reader.h"
#include "scenes/standard_input.h"
#include "sim/run/coarser.h"

namespace taut {

int frame_count(double duration, int fps) {
  const double count = duration * fps, nearest = std::round(count);
  return static_cast<int>(std::abs(count - nearest) < 1e-9 * count ? nearest : std::ceil(count));
}

int Scene::frames() const {
  return frame_count(duration, fps);
}

namespace {

/// A method that follows links alone would take a massless span for one.
void refuse_spans(const Document& document, const MethodInfo& method) {
  const Value* connectors = document.root.find("connectors");
  if (!connectors || method.follows_spans) return;
  for (const Value& connector : connectors->children) {
    const Value* model = connector.find("model");
    if (!model || model->text != "span") continue;
    document.mismatch(
        *model, fmt::format("\"links\": the method {} follows no massless spans", method.name));
  }
}

void refuse_obstacles(const Document& document, const MethodInfo& method) {
  const Value* obstacles = document.root.find("obstacles");
  if (!obstacles || obstacles->children.empty() || method.touches_obstacles) return;
  std::vector<std::string_view> able;
  for (const MethodInfo& info : methods()) {
    if (info.touches_obstacles) able.push_back(info.name);
  }
  document.fail_at_key(obstacles->children.front(),
                       fmt::format("the method {} knows no contact, expected one of: {}",
                                   method.name, fmt::join(able, ", ")));
}

/// The key of a connector that makes its links stretch, bend or meet the air; null: none does.
const Value* material_key(const Value& connector) {
  for (const std::string_view key :
       {"axial_stiffness", "bending_stiffness", "bending_damping", "material", "drag"}) {
    if (const Value* found = connector.find(key)) return found;
  }
  return nullptr;
}

void refuse_materials(const Document& document, const MethodInfo& method) {
  const Value* connectors = document.root.find("connectors");
  const Value* obstacles = document.root.find("obstacles");
  if (!connectors) return;
  for (const Value& connector : connectors->children) {
    const Value* key = material_key(connector);
    if (!key) continue;
    if (obstacles && !obstacles->children.empty()) {
      document.fail_at_key(*key,
                           "stands in a scene with obstacles, where links are rigid, bend "
                           "freely and meet no air");
    }
    if (method.follows_materials) continue;
    std::vector<std::string_view> able;
    for (const MethodInfo& info : methods()) {
      if (info.follows_materials) able.push_back(info.name);
    }
    document.fail_at_key(*key, fmt::format("is unknown to the method {}, expected one of: {}",
                                           method.name, fmt::join(able, ", ")));
  }
}

/// What joins an end to a connector, or makes a net; null: nothing.
const Value* joining_key(const Value& root) {
  const Value* nets = root.find("nets");
  if (nets && !nets->children.empty()) return &nets->children.front();
  const Value* connectors = root.find("connectors");
  for (std::size_t i = 0; connectors && i < connectors->children.size(); ++i) {
    for (const char* end : {"from", "to"}) {
      if (const Value* key = connectors->children[i].find(end)->find("connector")) return key;
    }
  }
  return nullptr;
}

void refuse_joints(const Document& document, const MethodInfo& method) {
  const Value* key = joining_key(document.root);
  if (!key) return;
  const Value* obstacles = document.root.find("obstacles");
  if (obstacles && !obstacles->children.empty()) {
    document.fail_at_key(*key, "stands in a scene with obstacles, where connectors are not joined");
  }
  if (method.follows_joints) return;
  std::vector<std::string_view> able;
  for (const MethodInfo& info : methods()) {
    if (info.follows_joints) able.push_back(info.name);
  }
  document.fail_at_key(*key, fmt::format("the method {} follows no connectors that are joined, "
                                         "expected one of: {}",
                                         method.name, fmt::join(able, ", ")));
}

/// A plan is the program's own: one of another version's format spoils no scene.
std::optional<Value> take_plan(Document& document) {
  std::vector<Value>& all = document.root.children;
  const auto plan = std::ranges::find(all, "plan", &Value::name);
  if (plan == all.end()) return std::nullopt;
  Value taken = std::move(*plan);
  all.erase(plan);
  return taken;
}

void try_plan(const Document& document, const Value& plan, Scene& scene) {
  try {
    scene.plan = read_plan(document, plan, scene.fps);
  } catch (const BadScene& error) {
    scene.strange_plan = error.what();
  }
}

}  // namespace

Scene read_scene(Document document, bool with_stage) {
  const std::optional<Value> plan = take_plan(document);
  check_format(document);
  const Value& root = document.root;
  Scene scene;
  scene.file = document.file;
  const bool is_input = document.file == kStandardInput;
  scene.title = text_or(root, "title", is_input ? "standard input" : document.file.stem().string());
  scene.duration = root.find("duration")->number;
  scene.fps = static_cast<int>(number_or(root, "fps", scene.fps));
  if (const Value* size = root.find("size")) {
    scene.width = static_cast<int>(size->children[0].number);
    scene.height = static_cast<int>(size->children[1].number);
  }
  scene.method = read_method(document, root.find("method"), scene.fps);
  scene.world.gravity = vec3_or(root, "gravity", scene.world.gravity);
  scene.world.air = read_air(document);
  Motions motions(document);
  scene.world.bodies = read_bodies(document, motions);
  read_connectors(document, motions, scene.world);
  read_nets(document, scene.world);
  read_obstacles(document, motions, scene.world);
  refuse_spans(document, *find_method(scene.method.name));
  refuse_obstacles(document, *find_method(scene.method.name));
  refuse_materials(document, *find_method(scene.method.name));
  refuse_joints(document, *find_method(scene.method.name));
  finish(scene.world);
  check_obstacles(document, scene.world);
  scene.timeline = read_timeline(document, motions, scene.world, scene.duration);
  if (plan) try_plan(document, *plan, scene);
  if (with_stage && root.find("stage")) read_stage(document, motions, scene);
  return scene;
}

Simulation start(const Scene& scene) {
  return start(scene, scene.method);
}

Simulation start(const Scene& scene, const MethodChoice& method) {
  return {scene.world, make_method(method.name, method.settings), scene.timeline};
}

Scene load_scene(const std::filesystem::path& file, bool with_stage,
                 const std::vector<SceneChange>& changes) {
  Document document = read_document(file);
  for (const auto& [key, value] : changes) change(document, key, value);
  Scene scene = read_scene(document, with_stage);
  if (!scene.stage) Motions(document).check_characters();
  if (!scene.stage && with_stage) check_models(document);
  return scene;
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

}  // namespace taut
