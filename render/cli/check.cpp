// taut check: what is wrong with a scene, and what it would do.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "render/atomic_file.h"
#include "render/cli/command.h"
#include "render/cli/method_options.h"
#include "render/cli/needs.h"
#include "render/cli/plan_table.h"
#include "scenes/schema.h"

namespace taut::cli {

namespace {

struct Options {
  std::string scene;
  bool schema = false;
  std::vector<std::string> plans;
};

using Json = nlohmann::ordered_json;

constexpr int kSamples = 4;  // per pixel, as taut render takes them

std::size_t triangles(const Model& model) {
  std::size_t count = 0;
  for (const Mesh& mesh : model.meshes) count += mesh.indices.size() / 3;
  return count;
}

std::string held_by(const World& world, const Connector& connector, std::size_t particle) {
  for (const Hold& hold : connector.holds) {
    if (hold.particle != particle) continue;
    if (hold.to.kind == Attachment::Kind::fixed) return "a fixed point";
    if (hold.to.kind == Attachment::Kind::path) return "a path";
    return world.bodies[hold.to.body].name;
  }
  return "nothing";
}

/// The models that the stage draws, each with its use.
std::vector<std::pair<std::string, const Model*>> models(const Scene& scene) {
  std::vector<std::pair<std::string, const Model*>> list;
  const Stage& stage = *scene.stage;
  for (const auto& model : stage.scenery) list.emplace_back("scenery", model.get());
  for (std::size_t i = 0; i < stage.body_models.size(); ++i) {
    if (const Model* model = stage.body_models[i].get()) {
      list.emplace_back("body " + scene.world.bodies[i].name, model);
    }
  }
  for (const auto& model : stage.characters) list.emplace_back("character", model.get());
  return list;
}

/// Adds a member whose name is new: looking whether it is takes a pass over all others.
void append(Json& object, const std::string& name, Json member) {
  using Members = Json::object_t::Container;
  static_cast<Members&>(object.get_ref<Json::object_t&>()).emplace_back(name, std::move(member));
}

Json as_json(const Scene& scene) {
  Json json = {{"scene", scene.file.string()}, {"title", scene.title},
               {"duration", scene.duration},   {"fps", scene.fps},
               {"frames", scene.frames()},     {"size", {scene.width, scene.height}}};
  json["method"] = scene.method.name;
  json["settings"] = settings_json(full_settings(scene.method));
  if (const double steps = steps_per_frame(scene); steps > 0) {
    json["steps_per_frame"] = std::uint64_t(steps);
  }
  json["bodies"] = Json::object();
  for (const Body& body : scene.world.bodies) {
    append(json["bodies"], body.name,
           {{"driven", body.driven()}, {"mass", body.mass_properties.mass}});
  }
  json["connectors"] = Json::object();
  for (const Connector& connector : scene.world.connectors) {
    append(json["connectors"], connector.name,
           {{"length", connector.length},
            {"mass", connector.mass},
            {"particles", connector.particles()}});
  }
  if (scene.stage) json["clip_frames"] = std::uint64_t(clip_length(scene));
  json["pins"] = scene.timeline.pins.size();
  json["cuts"] = scene.timeline.cuts.size();
  json["simulate"] = needs_json(simulation_needs(scene));
  if (scene.stage) json["render"] = needs_json(clip_needs(scene, clip_length(scene), kSamples));
  json["stage"] = scene.stage.has_value();
  if (scene.stage) {
    json["models"] = Json::array();
    for (const auto& [use, model] : models(scene)) {
      json["models"].push_back({{"use", use},
                                {"name", model->name},
                                {"triangles", triangles(*model)},
                                {"bones", model->bones.size()}});
    }
  }
  return json;
}

std::string as_text(const Scene& scene) {
  std::string text;
  const auto line = [&text](const std::string& words) { text += words + '\n'; };
  const World& world = scene.world;
  line(fmt::format("{}: {} s, {} frames at {} per second", scene.title, scene.duration,
                   scene.frames(), scene.fps));
  const double steps = steps_per_frame(scene);
  line(fmt::format("method {}{} ({})", scene.method.name,
                   steps > 0 ? fmt::format(", {:.0f} steps a frame", steps) : "",
                   settings_text(full_settings(scene.method))));
  for (const Body& body : world.bodies) {
    line(fmt::format("body {}: {:.6g} kg, {}", body.name, body.mass_properties.mass,
                     body.driven() ? "driven" : "free"));
  }
  for (const Connector& connector : world.connectors) {
    line(fmt::format("connector {}: {} m, {} kg, {} particles, held by {} and {}", connector.name,
                     connector.length, connector.mass, connector.particles(),
                     held_by(world, connector, 0),
                     held_by(world, connector, connector.particles() - 1)));
  }
  for (const TimedPin& pin : scene.timeline.pins) {
    line(fmt::format("pin: {} at {} m, from {} s until {} s", world.connectors[pin.connector].name,
                     pin.along, pin.from, pin.until));
  }
  for (const TimedCut& cut : scene.timeline.cuts) {
    line(fmt::format("cut: {} at {} m, at {} s", world.connectors[cut.connector].name, cut.along,
                     cut.time));
  }
  if (!scene.strange_plan.empty()) {
    line(fmt::format("plan: of another version of taut or of the scene; plan it again ({})",
                     scene.strange_plan));
  }
  if (scene.plan) {
    const Plan& plan = *scene.plan;
    line(plan.stamp != plan_stamp(scene.file) ? "plan: of the scene as it was; it changed since"
         : plan.program != method_stamp(plan.method)
             ? "plan: by another version of its method; plan it again"
             : fmt::format("plan: {} by {} (--planned)", certificate(plan), plan.method.name));
  }
  line(fmt::format("taut simulate takes {}", needs_text(simulation_needs(scene))));
  if (!scene.stage) {
    line("no stage: it can be simulated, not rendered");
    return text;
  }
  line(fmt::format("stage: {}x{}; the clip has {:.0f} frames in {} shots", scene.width,
                   scene.height, clip_length(scene), scene.stage->shots.size()));
  line(fmt::format("taut render takes {}",
                   needs_text(clip_needs(scene, clip_length(scene), kSamples))));
  for (const auto& [use, model] : models(scene)) {
    line(fmt::format("{}: {}, {} triangles{}", use, model->name, triangles(*model),
                     model->bones.empty() ? "" : fmt::format(", {} bones", model->bones.size())));
  }
  return text;
}

int run(const Options& options, const Common& common) {
  if (options.schema) {
    write_output(scene_schema());
    return kDone;
  }
  if (!options.plans.empty()) {
    write_output(to_markdown(plan_table(options.plans)));
    return kDone;
  }
  if (options.scene.empty()) throw Misuse("check: expected a scene file, --plans or --schema");
  const Scene scene = load_scene(options.scene, true);
  write_output(common.json ? as_json(scene).dump(2) + '\n' : as_text(scene));
  return kDone;
}

}  // namespace

void add_check(CLI::App& app, Program& program) {
  CLI::App& command =
      add_command(app, program, "check", "What is wrong with a scene, and what it would do",
                  R"(  taut check scenes/nunchaku.toml
  taut check scenes/nunchaku.toml --json
  taut check --plans scenes/*.toml                 their plans, as a table in Markdown
  taut check --schema > scenes/scene.schema.json   the JSON Schema, for editors)");
  const auto options = std::make_shared<Options>();
  command.add_option("scene", options->scene, "A scene file");
  command.add_option("--plans", options->plans, "Write a table of these scenes' plans instead");
  command.add_flag("--schema", options->schema, "Write the JSON Schema of scene files instead");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
