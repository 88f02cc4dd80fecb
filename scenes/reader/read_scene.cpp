#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "scenes/files/standard_input.h"
#include "scenes/format/format.h"
#include "scenes/format/old_keys.h"
#include "scenes/reader/choreography.h"
#include "scenes/reader/reader.h"

namespace taut::scenes {
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
  const std::string able = methods_with(&MethodInfo::touches_obstacles);
  document.fail_at_key(
      obstacles->children.front(),
      fmt::format("the method {} knows no contact, expected one of: {}", method.name, able));
}

void refuse_touching_bodies(const Document& document, const MethodInfo& method) {
  if (method.touches_with_bodies) return;
  const std::string able = methods_with(&MethodInfo::touches_with_bodies);
  const Value* touching = document.root.find("touching");
  if (touching && !touching->children.empty()) {
    document.fail_at_key(touching->children.front(),
                         fmt::format("the method {} follows no free bodies that touch each other, "
                                     "expected one of: {}",
                                     method.name, able));
  }
  const Value *obstacles = document.root.find("obstacles"), *bodies = document.root.find("bodies");
  if (!obstacles || obstacles->children.empty() || !bodies) return;
  for (const Value& body : bodies->children) {
    const Value* key = body.find("contact");
    if (!key) continue;
    document.fail_at_key(*key, fmt::format("the method {} follows no free bodies that touch "
                                           "obstacles, expected one of: {}",
                                           method.name, able));
  }
}

void refuse_touching_connectors(const Document& document, const MethodInfo& method) {
  const Value* touching = document.root.find("touching");
  if (!touching || method.beads_touch_bodies) return;
  for (const Value& value : touching->children) {
    const Value* key = value.find("connectors");
    if (!key) continue;
    document.fail_at_key(*key,
                         fmt::format("the method {} follows no connectors that touch free "
                                     "bodies, expected one of: {}",
                                     method.name, methods_with(&MethodInfo::beads_touch_bodies)));
  }
}

/// The part of a scene that touches, in words; null: none.
const char* what_touches(const Document& document) {
  const auto is_there = [&](const char* name) {
    const Value* table = document.root.find(name);
    return table && !table->children.empty();
  };
  if (is_there("obstacles")) return "obstacles";
  return is_there("touching") ? "bodies that touch" : nullptr;
}

/// The key of a connector that makes its links stretch, bend or meet the air; null: none does.
/// With `but_damping`, bending_damping does not count.
const Value* material_key(const Value& connector, bool but_damping = false) {
  for (const std::string_view key :
       {"axial_stiffness", "bending_stiffness", "rest_curvature", "twisting_stiffness",
        "twisting_damping", "rest_twist", "material", "drag"}) {
    if (const Value* found = connector.find(key)) return found;
  }
  return but_damping ? nullptr : connector.find("bending_damping");
}

void refuse_materials(const Document& document, const MethodInfo& method) {
  const Value* connectors = document.root.find("connectors");
  const char* touching = what_touches(document);
  if (!connectors) return;
  for (const Value& connector : connectors->children) {
    const Value* key = material_key(connector);
    if (!key) continue;
    const Value* more = material_key(connector, method.damps_beside_contact);
    if (more && touching && !method.touches_beside_more) {
      document.fail_at_key(
          *more,
          fmt::format("stands in a scene with {}, where links of the method {} are rigid, "
                      "bend freely and meet no air, expected one of: {}",
                      touching, method.name, methods_with(&MethodInfo::touches_beside_more)));
    }
    if (method.follows_materials) continue;
    const std::string able = methods_with(&MethodInfo::follows_materials);
    document.fail_at_key(
        *key, fmt::format("is unknown to the method {}, expected one of: {}", method.name, able));
  }
}

/// The key that joins an end to a connector, or makes a net; null: none.
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
  const char* touching = what_touches(document);
  if (touching && !method.touches_beside_more) {
    document.fail_at_key(
        *key, fmt::format("stands in a scene with {}, where the method {} follows no connectors "
                          "that are joined, expected one of: {}",
                          touching, method.name, methods_with(&MethodInfo::touches_beside_more)));
  }
  if (method.follows_joints) return;
  const std::string able = methods_with(&MethodInfo::follows_joints);
  document.fail_at_key(*key, fmt::format("the method {} follows no connectors that are joined, "
                                         "expected one of: {}",
                                         method.name, able));
}

void refuse_touching_links(const Document& document, const MethodInfo& method) {
  const Value *connectors = document.root.find("connectors"),
              *obstacles = document.root.find("obstacles");
  if (!connectors || !obstacles || obstacles->children.empty()) return;
  for (const Value& connector : connectors->children) {
    if (method.touches_with_links || text_or(connector, "contact", "beads") != "links") continue;
    document.fail_at_key(*connector.find("contact"),
                         fmt::format("the method {} touches obstacles with beads alone, expected "
                                     "one of: {}",
                                     method.name, methods_with(&MethodInfo::touches_with_links)));
  }
}

void refuse_strings(const Document& document, const MethodInfo& method) {
  const Value* connectors = document.root.find("connectors");
  if (!connectors) return;
  for (const Value& connector : connectors->children) {
    const Value* key = connector.find("links");
    if (!key || key->text != "pull") continue;
    if (text_or(connector, "model", "links") == "span") {
      document.fail_at_key(*key, "needs model = \"links\", a massless span has none");
    }
    if (connector.find("length")->number == 0) {
      document.fail_at_key(*key, "needs links that have a length, a joint has none");
    }
    if (const Value* material = material_key(connector)) {
      document.fail_at_key(*key, fmt::format("stands beside {}, expected links that are rigid and "
                                             "bend freely, or strings",
                                             material->name));
    }
    for (const Value& other : connectors->children) {
      const bool spans = text_or(other, "model", "links") == "span";
      if (!spans && !material_key(other)) continue;
      document.fail_at_key(
          *key, fmt::format("stands in a scene with {}, which {}", other.path,
                            spans ? "is a massless span" : "stretches, bends or meets the air"));
    }
    if (joining_key(document.root)) {
      document.fail_at_key(*key, "stands in a scene in which connectors are joined");
    }
    if (method.follows_strings) continue;
    const std::string able = methods_with(&MethodInfo::follows_strings);
    document.fail_at_key(*key, fmt::format("the method {} follows no links that only pull, "
                                           "expected one of: {}",
                                           method.name, able));
  }
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
  rename_old_keys(document);
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
  scene.method = read_method(document, root.find("method"), scene.fps, scene.duration);
  scene.world.gravity = vec3_or(root, "gravity", scene.world.gravity);
  scene.world.air = read_air(document);
  Motions motions(document);
  scene.world.bodies = read_bodies(document, motions);
  read_connectors(document, motions, scene.world);
  read_nets(document, scene.world);
  read_obstacles(document, motions, scene.world);
  read_touching(document, scene.world);
  push_out_starts(document, scene.world);
  refuse_spans(document, *find_method(scene.method.name));
  refuse_obstacles(document, *find_method(scene.method.name));
  refuse_touching_bodies(document, *find_method(scene.method.name));
  refuse_touching_connectors(document, *find_method(scene.method.name));
  refuse_materials(document, *find_method(scene.method.name));
  refuse_joints(document, *find_method(scene.method.name));
  refuse_touching_links(document, *find_method(scene.method.name));
  refuse_strings(document, *find_method(scene.method.name));
  refuse_winches(document, *find_method(scene.method.name));
  finish(scene.world);
  check_obstacles(document, scene.world);
  check_touching(document, scene.world);
  scene.timeline = read_timeline(document, motions, scene.world, scene.duration);
  check_curvatures(document, scene.world, scene.timeline);
  if (const Value* table = root.find("choreography")) {
    read_choreography(document, *table, motions, scene);  // only to say what is wrong with it
  }
  if (plan) try_plan(document, *plan, scene);
  if (with_stage && root.find("stage")) read_stage(document, motions, scene);
  return scene;
}

}  // namespace taut::scenes
