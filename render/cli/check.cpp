// taut check: what is wrong with a scene, and what it would do.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/method_options.h"
#include "scenes/scene.h"
#include "scenes/schema.h"

namespace taut::cli {

namespace {

struct Options {
  std::string scene;
  bool schema = false;
};

/// What a scene would do, as pairs of a name and a line or a number.
nlohmann::ordered_json summary(const Scene& scene) {
  nlohmann::ordered_json json;
  json["scene"] = scene.file.string();
  json["title"] = scene.title;
  json["duration"] = scene.duration;
  json["fps"] = scene.fps;
  json["frames"] = scene.frames();
  json["method"] = scene.method.name;
  const Settings settings = full_settings(scene.method);
  for (const auto& [name, value] : settings) {
    std::visit([&](const auto& v) { json["settings"][name] = v; }, value);
  }
  if (const auto step = settings.find("step"); step != settings.end()) {
    if (const double* seconds = std::get_if<double>(&step->second); seconds && *seconds > 0) {
      json["steps_per_frame"] = step_count(1.0 / scene.fps, *seconds);
    }
  }
  for (const Body& body : scene.world.bodies) {
    json["bodies"][body.name] = body.driven() ? "driven" : "free";
  }
  for (const Connector& connector : scene.world.connectors) {
    json["connectors"][connector.name] = {{"length", connector.length},
                                          {"particles", connector.particles()}};
  }
  json["pins"] = scene.pins.size();
  json["stage"] = scene.stage.has_value();
  if (scene.stage) json["size"] = {scene.width, scene.height};
  return json;
}

void list_models(nlohmann::ordered_json& json, const char* kind,
                 const std::vector<std::shared_ptr<const Model>>& models) {
  for (const auto& model : models) {
    if (!model) continue;
    std::size_t triangles = 0;
    for (const Mesh& mesh : model->meshes) triangles += mesh.indices.size() / 3;
    json["models"].push_back({{"use", kind},
                              {"name", model->name},
                              {"triangles", triangles},
                              {"bones", model->bones.size()}});
  }
}

/// Names and values in lines for people.
void print_lines(const nlohmann::ordered_json& json, const std::string& indent, std::string& text) {
  for (const auto& [name, value] : json.items()) {
    const std::string label = json.is_array() ? "-" : name + ":";
    if (value.is_structured() && !value.empty()) {
      text += fmt::format("{}{}\n", indent, label);
      print_lines(value, indent + "  ", text);
    } else {
      text += fmt::format("{}{} {}\n", indent, label,
                          value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
}

int run(const Options& options, const Common& common) {
  if (options.schema) {
    write_output(scene_schema());
    return kDone;
  }
  if (options.scene.empty()) throw Misuse("check: expected a scene file or --schema");
  const Scene scene = load_scene(options.scene, true);
  nlohmann::ordered_json json = summary(scene);
  if (scene.stage) {
    list_models(json, "scenery", scene.stage->scenery);
    list_models(json, "body", scene.stage->body_models);
    list_models(json, "character", scene.stage->characters);
  }
  std::string text;
  if (common.json) {
    text = json.dump(2) + '\n';
  } else {
    print_lines(json, "", text);
  }
  write_output(text);
  return kDone;
}

}  // namespace

void add_check(CLI::App& app, Program& program) {
  CLI::App& command =
      add_command(app, program, "check", "What is wrong with a scene, and what it would do",
                  R"(  taut check scenes/nunchaku.toml
  taut check scenes/nunchaku.toml --json
  taut check --schema > scenes/scene.schema.json   the JSON Schema, for editors)");
  const auto options = std::make_shared<Options>();
  command.add_option("scene", options->scene, "A scene file");
  command.add_flag("--schema", options->schema, "Write the JSON Schema of scene files instead");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
