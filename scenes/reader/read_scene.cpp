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
  refuse_unfollowed(document, scene);
  finish(scene.world);
  check_obstacles(document, scene.world);
  check_touching(document, scene.world);
  scene.timeline = read_timeline(document, motions, scene.world, scene.duration);
  refuse_unfollowed(document, scene);
  check_curvatures(document, scene.world, scene.timeline);
  if (const Value* table = root.find("choreography")) {
    read_choreography(document, *table, motions, scene);  // only to say what is wrong with it
  }
  if (plan) try_plan(document, *plan, scene);
  if (with_stage && root.find("stage")) read_stage(document, motions, scene);
  return scene;
}

}  // namespace taut::scenes
