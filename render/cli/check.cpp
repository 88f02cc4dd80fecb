// taut check: the faults of a scene, and its expected run.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>

#include "render/base/atomic_file.h"
#include "render/base/bounded.h"
#include "render/cli/check_cheaper.h"
#include "render/cli/check_connectors.h"
#include "render/cli/check_features.h"
#include "render/cli/check_records.h"
#include "render/cli/check_time.h"
#include "render/film/caption.h"
#include "render/options/method_options.h"
#include "render/options/needs.h"
#include "render/options/scene_options.h"
#include "render/plan/plan_table.h"
#include "render/program/command.h"
#include "render/program/json.h"
#include "render/program/output.h"
#include "render/program/program.h"
#include "scenes/files/error.h"
#include "scenes/format/schema.h"
#include "scenes/load/default_stage.h"
#include "scenes/load/faults.h"
#include "scenes/load/load_scene.h"
#include "scenes/load/plan_file.h"
#include "scenes/load/warnings.h"
#include "scenes/scene/names.h"
#include "sim/motion/printable.h"
#include "sim/motion/stop.h"

namespace taut::cli {
namespace check_command {
namespace {

struct Options {
  options::SceneOptions inputs;
  bool schema = false, features = false;
  std::vector<std::string> plans;
};

constexpr int kSamples = 4;      // per pixel, as taut render takes them
constexpr double kWhole = 1;     // s of CPU time, of the whole check
constexpr double kLeast = 0.25;  // s of CPU time, whatever reading the scene takes
// Of what reading leaves of it.
constexpr double kPiece = 0.84;   // a piece of the run
constexpr double kCheaper = 0.1;  // a cheaper method, to compare with
constexpr double kLook = 0.06;    // the camera and what it shows, at least

constexpr double kLookedAt = 1e9;  // bytes; what takes more is not simulated for a look

/// What is known of a scene.
struct Known {
  scenes::Scene scene;
  bool staged = false;  // its file has a stage
  RunTime time;
  std::optional<Cheaper> cheaper;
  std::vector<std::string> warnings;
};

std::size_t triangles(const scenes::Model& model) {
  std::size_t count = 0;
  for (const scenes::Mesh& mesh : model.meshes) count += mesh.indices.size() / 3;
  return count;
}

std::string_view kind_of(const Obstacle& obstacle) {
  static constexpr std::array<std::string_view, 5> kKinds{"plane", "sphere", "capsule", "cylinder",
                                                          "box"};
  return kKinds[static_cast<std::size_t>(obstacle.shape.kind)];
}

/// The connectors and bodies that pass through an obstacle; of copies the first.
std::vector<std::string> ignored_by(const Obstacle& obstacle, const World& world) {
  std::vector<std::string> names;
  for (const Connector& connector : world.connectors)
    if (!obstacle.touches(connector.category) && !scenes::is_numbered(connector.name))
      names.push_back(connector.name);
  for (const Body& body : world.bodies)
    if (!obstacle.touches(body.capsule.category)) names.push_back(body.name);
  return names;
}

/// Whether the body is there only to show an obstacle on a path.
bool shows_obstacle(const World& world, const Body& body) {
  return std::ranges::any_of(world.obstacles, [&](const Obstacle& obstacle) {
    return obstacle.path && obstacle.name == body.name && obstacle.path == body.path;
  });
}

/// The models that the stage draws, each with its use.
std::vector<std::pair<std::string, const scenes::Model*>> models(const scenes::Scene& scene) {
  std::vector<std::pair<std::string, const scenes::Model*>> list;
  const scenes::Stage& stage = *scene.stage;
  for (const auto& model : stage.scenery) list.emplace_back("scenery", model.get());
  for (std::size_t i = 0; i < stage.body_models.size(); ++i) {
    if (const scenes::Model* model = stage.body_models[i].get()) {
      list.emplace_back("body " + scene.world.bodies[i].name, model);
    }
  }
  for (const auto& model : stage.characters) list.emplace_back("character", model.get());
  return list;
}

/// Adds a member whose name is new: looking whether it is takes a pass over all others.
void append(program::Json& object, const std::string& name, program::Json member) {
  using Members = program::Json::object_t::Container;
  static_cast<Members&>(object.get_ref<program::Json::object_t&>())
      .emplace_back(name, std::move(member));
}

program::Json needs_json(const options::Needs& needs, const RunTime& run, double more) {
  program::Json json = {{"memory_bytes", std::round(needs.memory)},
                        {"disk_bytes", std::round(needs.disk)}};
  json["time_s"] = run.unknown.empty() ? program::Json(run.seconds + more) : program::Json(nullptr);
  json["measured_until_s"] = run.simulated;
  json["at_least"] = run.at_least;
  json["fails"] = run.diverges;
  const bool ranges = run.unknown.empty() && !run.at_least;
  json["least_s"] = ranges ? program::Json(run.least + more) : program::Json(nullptr);
  json["most_s"] = ranges ? program::Json(run.most + more) : program::Json(nullptr);
  return json;
}

program::Json cheaper_json(const Cheaper& cheaper) {
  return {{"method", cheaper.method.name},
          {"settings", options::settings_json(with_defaults(cheaper.method))},
          {"time_s", cheaper.seconds},
          {"apart_m", cheaper.apart},
          {"apart_until_s", cheaper.until}};
}

/// The time (s) of drawing the clip, without simulating it.
double drawing_time(const scenes::Scene& scene, const options::Needs& clip) {
  return clip.time - options::simulation_needs(scene).time;
}

program::Json as_json(const Known& known, int threads) {
  const scenes::Scene& scene = known.scene;
  program::Json json = {
      {"scene", scene.file.string()},          {"title", scene.title}, {"warnings", known.warnings},
      {"duration_s", scene.duration},          {"fps", scene.fps},     {"frames", scene.frames()},
      {"size_px", {scene.width, scene.height}}};
  json["method"] = scene.method.name;
  json["settings"] = options::settings_json(with_defaults(scene.method));
  if (const double steps = options::steps_per_frame(scene); steps > 0)
    json["steps_per_frame"] = std::uint64_t(steps);
  json["bodies"] = program::Json::object();
  for (const Body& body : scene.world.bodies) {
    if (shows_obstacle(scene.world, body)) continue;
    append(json["bodies"], body.name,
           {{"driven", body.driven()}, {"mass_kg", body.mass_properties.mass}});
  }
  json["connectors"] = program::Json::object();
  for (const Connector& connector : scene.world.connectors) {
    program::Json one = {{"length_m", connector.length},
                         {"mass_kg", connector.mass},
                         {"particles", connector.particles()}};
    if (!connector.sections.empty()) one["material"] = material_json(connector);
    append(json["connectors"], connector.name, std::move(one));
  }
  json["joints"] = scene.world.joints.size();
  json["pulleys"] = program::Json::object();
  for (const Pulley& p : scene.world.pulleys)
    append(json["pulleys"], p.name,
           {{"inertia_kg", p.inertia}, {"friction", p.friction}, {"bearing", p.bearing}});
  json["obstacles"] = program::Json::object();
  for (const Obstacle& obstacle : scene.world.obstacles) {
    append(json["obstacles"], obstacle.name,
           {{"shape", kind_of(obstacle)},
            {"moves", obstacle.path != nullptr},
            {"friction", obstacle.kinetic_friction},
            {"static_friction", obstacle.static_friction},
            {"restitution", obstacle.restitution},
            {"ignores", ignored_by(obstacle, scene.world)}});
  }
  json["touching"] = program::Json::array();
  for (const BodyPair& pair : scene.world.pairs) {
    json["touching"].push_back(
        {{"bodies", {scene.world.bodies[pair.a].name, scene.world.bodies[pair.b].name}},
         {"friction", pair.kinetic_friction},
         {"static_friction", pair.static_friction},
         {"restitution", pair.restitution}});
  }
  for (const BeadPair& pair : scene.world.bead_pairs) {
    json["touching"].push_back({{"connector", scene.world.connectors[pair.connector].name},
                                {"body", scene.world.bodies[pair.body].name},
                                {"friction", pair.kinetic_friction},
                                {"static_friction", pair.static_friction},
                                {"restitution", pair.restitution}});
  }
  for (const ConnectorPair& pair : scene.world.connector_pairs) {
    json["touching"].push_back({{"connector", scene.world.connectors[pair.a].name},
                                {"other_connector", scene.world.connectors[pair.b].name},
                                {"friction", pair.kinetic_friction},
                                {"static_friction", pair.static_friction},
                                {"restitution", pair.restitution}});
  }
  if (scene.stage) json["clip_frames"] = std::uint64_t(options::clip_length(scene));
  json["pins"] = scene.timeline.pins.size();
  json["cuts"] = scene.timeline.cuts.size();
  json["simulate"] = needs_json(options::simulation_needs(scene), known.time, 0);
  if (scene.stage) {
    const options::Needs clip =
        options::clip_needs(scene, options::clip_length(scene), kSamples, threads);
    json["render"] = needs_json(clip, known.time, drawing_time(scene, clip));
  }
  json["cheaper"] = known.cheaper ? cheaper_json(*known.cheaper) : program::Json(nullptr);
  json["stage"] = known.staged;
  json["models"] = program::Json::array();
  if (!scene.stage) return json;
  for (const auto& [use, model] : models(scene)) {
    json["models"].push_back({{"use", use},
                              {"name", model->name},
                              {"triangles", triangles(*model)},
                              {"bones", model->bones.size()}});
  }
  return json;
}

/// Connectors that touch bodies and each other, in lines; copies and the cords of a net in one.
std::vector<std::string> pairs_with_connectors(const World& world) {
  std::vector<std::string> lines;
  for (const BeadPair& pair : world.bead_pairs) {
    const std::string& name = world.connectors[pair.connector].name;
    std::string text = fmt::format("beads of {} and body {} touch: friction {}, restitution {}",
                                   scenes::written_name(name), world.bodies[pair.body].name,
                                   pair.kinetic_friction, pair.restitution);
    if (std::ranges::find(lines, text) == lines.end()) lines.push_back(std::move(text));
  }
  for (const ConnectorPair& pair : world.connector_pairs) {
    const std::string_view a = scenes::written_name(world.connectors[pair.a].name),
                           b = scenes::written_name(world.connectors[pair.b].name);
    std::string text = fmt::format("{}: friction {}, restitution {}",
                                   a == b ? fmt::format("{} touches itself", a)
                                          : fmt::format("connectors {} and {} touch", a, b),
                                   pair.kinetic_friction, pair.restitution);
    if (std::ranges::find(lines, text) == lines.end()) lines.push_back(std::move(text));
  }
  return lines;
}

std::string as_text(const Known& known, int threads) {
  const scenes::Scene& scene = known.scene;
  const std::vector<std::string>& warnings = known.warnings;
  std::string text;
  const auto line = [&text](const std::string& words) { text += printable(words) + '\n'; };
  const World& world = scene.world;
  line(fmt::format("{}: {} s, {} frames at {} per second", scene.title, scene.duration,
                   scene.frames(), scene.fps));
  const double steps = options::steps_per_frame(scene);
  line(fmt::format("method {}{} ({})", scene.method.name,
                   steps > 0 ? fmt::format(", {:.0f} steps a frame", steps) : "",
                   options::settings_text(with_defaults(scene.method))));
  for (const Body& body : world.bodies) {
    if (shows_obstacle(world, body)) continue;
    line(fmt::format("body {}: {:.6g} kg, {}", body.name, body.mass_properties.mass,
                     body.driven() ? "driven" : "free"));
  }
  for (const std::string& connector : connector_lines(world)) line(connector);
  if (!world.joints.empty()) line(fmt::format("joints: {}", world.joints.size()));
  for (const Pulley& pulley : world.pulleys)
    line(fmt::format("pulley {}: inertia {} kg, friction {}, of its bearing {}", pulley.name,
                     pulley.inertia, pulley.friction, pulley.bearing));
  for (const Obstacle& obstacle : world.obstacles) {
    const std::vector<std::string> names = ignored_by(obstacle, world);
    line(fmt::format("obstacle {}: {}{}, friction {}, restitution {}{}{}", obstacle.name,
                     kind_of(obstacle), obstacle.path ? " on a path" : "",
                     obstacle.kinetic_friction, obstacle.restitution,
                     names.empty() ? "" : ", ignores ", fmt::join(names, ", ")));
  }
  for (const BodyPair& pair : world.pairs) {
    line(fmt::format("bodies {} and {} touch: friction {}, restitution {}",
                     world.bodies[pair.a].name, world.bodies[pair.b].name, pair.kinetic_friction,
                     pair.restitution));
  }
  for (const std::string& pair : pairs_with_connectors(world)) line(pair);
  for (const TimedPin& pin : scene.timeline.pins) {
    line(fmt::format("pin: {} at {} m, from {} s {}", world.connectors[pin.connector].name,
                     pin.along, pin.from,
                     std::isfinite(pin.until) ? fmt::format("until {} s", pin.until) : "on"));
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
    const scenes::Plan& plan = *scene.plan;
    line(plan.stamp != scenes::plan_stamp(scene.file)
             ? "plan: of the scene as it was; it changed since"
         : plan.program != scenes::method_stamp(plan.method)
             ? "plan: by another version of its method; plan it again"
             : fmt::format("plan: {} by {} (--planned)", scenes::certificate(plan),
                           plan.method.name));
  }
  line(fmt::format("taut simulate takes {} and {}",
                   options::space_text(options::simulation_needs(scene)), text_of(known.time)));
  if (!scene.stage) {
    line("stage: none is written; taut makes its own");
    for (const std::string& warning : warnings) line("warning: " + warning);
    return text;
  }
  const std::size_t shots = scene.stage->shots.size();
  line(fmt::format("stage{}: {}x{}; the clip has {:.0f} frames in {} shot{}",
                   known.staged ? "" : ", as none is written, taut's own", scene.width,
                   scene.height, options::clip_length(scene), shots, shots == 1 ? "" : "s"));
  const options::Needs clip =
      options::clip_needs(scene, options::clip_length(scene), kSamples, threads);
  line(fmt::format("taut render takes {}; beside simulating, drawing takes {} without a GPU",
                   options::space_text(clip), options::time_text(drawing_time(scene, clip))));
  for (const auto& [use, model] : models(scene)) {
    line(fmt::format("{}: {}, {} triangles{}", use, model->name, triangles(*model),
                     model->bones.empty() ? "" : fmt::format(", {} bones", model->bones.size())));
  }
  for (const std::string& warning : warnings) line("warning: " + warning);
  return text;
}

/// Completes the stage and looks at what its camera shows and at the choreography. Calls `tell`
/// with all that is known before each part, that this is left out among the warnings, and at the
/// end.
void look(Known known, const std::vector<scenes::SceneChange>& changes, const scenes::KnownRun& run,
          double seconds, const std::function<void(const Known&)>& tell) {
  const auto tell_without = [&](const std::string& left_out) {
    Known so_far = known;
    so_far.warnings.push_back(left_out);
    tell(so_far);
  };
  try {
    const WorkLimit limit({.cpu_time = seconds});
    scenes::Scene complete = known.scene;
    const std::string left_out = scenes::complete_stage(complete, changes, check_stop);
    known.scene = std::move(complete);
    if (!left_out.empty()) known.warnings.push_back(left_out);
  } catch (const OverLimit&) {
    return tell_without("the camera is left out: what it has to show is too much to simulate");
  }
  tell_without("what the camera shows is left out: it is too much to look at");
  for (std::string& warning : scenes::warnings_of(known.scene, run)) {
    known.warnings.push_back(std::move(warning));
  }
  tell_without("the choreography is left out: it is too much to simulate");
  if (auto missed = scenes::choreography_warning(known.scene, changes)) {
    known.warnings.push_back(std::move(*missed));
  }
  tell(known);
}

/// What a look found, as the command's output; ended after so many seconds of CPU time.
std::string looked_at(Known known, const std::vector<scenes::SceneChange>& changes,
                      const scenes::KnownRun& run, double seconds,
                      const std::function<std::string(const Known&)>& written) {
  const char* left_out = "the camera and what it shows are left out: too much to simulate";
  constexpr char kEnd = '\0', kError = '\1';  // after a text
  std::string said;
  if (options::simulation_needs(known.scene).memory <= kLookedAt) {
    said = render::run_bounded({seconds, kCopyMemory}, [&](const render::Say& say) {
             try {
               look(known, changes, run, 0.7 * seconds,
                    [&](const Known& found) { say(written(found) + kEnd); });
             } catch (const scenes::BadScene& error) {
               say(std::string(error.what()) + kError);
             }
           }).said;
  }
  // The last text that is whole.
  const std::size_t end = said.find_last_of(std::string{kEnd, kError});
  if (end == std::string::npos) {
    known.warnings.emplace_back(left_out);
    return written(known);
  }
  const std::size_t before = end == 0 ? end : said.rfind(kEnd, end - 1);
  std::string text = said.substr(before == std::string::npos ? 0 : before + 1);
  text.resize(text.find_first_of(std::string{kEnd, kError}));
  if (said[end] == kError) throw scenes::BadScene(text);
  return text;
}

int check(const std::string& file, const std::vector<std::string>& set, double started,
          const program::Common& common) {
  const double before = render::process_seconds() + render::children_seconds();
  const auto used = [&] {
    return started + render::process_seconds() + render::children_seconds() - before;
  };
  const std::vector<scenes::SceneChange> changes = options::scene_changes(set);
  Known known;
  const double read_from = render::process_seconds();
  try {
    known.scene = scenes::load_scene(file, true, changes);
  } catch (const scenes::BadScene&) {  // the first of its faults
    scenes::Faults faults = scenes::faults_of(file, changes);
    if (faults.first.empty()) throw;
    throw program::BadScenes(std::move(faults));
  }
  // Models are read by other processes; a simulation needs none.
  const double reading = started + render::process_seconds() - read_from;
  const double ready = used(), seconds = std::max(kWhole - ready, kLeast);
  known.staged = known.scene.stage.has_value();
  if (known.staged) {
    for (std::string& lacks : film::missing_glyphs(*known.scene.stage)) {
      known.warnings.push_back(std::move(lacks));
    }
  }
  Piece piece;
  known.time.unknown = why_not_tried(known.scene);
  if (known.time.unknown.empty()) {
    piece = run_piece(known.scene, kPiece * seconds);
    known.time = time_of_run(known.scene, reading, piece);
    known.cheaper = cheaper_method(known.scene, known.time, reading, piece, kCheaper * seconds);
    std::string slow = known.cheaper ? text_of(*known.cheaper, known.time, known.scene)
                                     : what_helps(known.scene, known.time);
    if (!slow.empty()) known.warnings.push_back(std::move(slow));
  }
  render::write_output(
      looked_at(known, changes, {piece.states, piece.diverged},
                std::max(ready + seconds - used(), kLook * seconds), [&](const Known& found) {
                  return common.json ? program::json_text(as_json(found, common.threads)) + '\n'
                                     : as_text(found, common.threads);
                }));
  return program::kDone;
}

int run(const Options& options, const program::Common& common) {
  if (options.schema) {
    render::write_output(scenes::scene_schema());
    return program::kDone;
  }
  if (options.features) {
    render::write_output(features_as_markdown());
    return program::kDone;
  }
  if (!options.plans.empty()) {
    render::write_output(common.json
                             ? program::json_text(planning::plans_json(options.plans)) + '\n'
                             : chart::to_markdown(planning::plan_table(options.plans)));
    return program::kDone;
  }
  if (options.inputs.scenes.empty()) {
    throw program::Misuse("check: expected a scene file, --plans, --features or --schema");
  }
  const double started = render::process_seconds();
  return options::for_each_scene(options.inputs, common, [&](const std::string& scene) {
    return check(scene, options.inputs.set, started, common);
  });
}

}  // namespace
}  // namespace check_command

void add_check(CLI::App& app, program::Program& program) {
  using namespace check_command;
  program::Command command =
      program::add_command(app, program, "check", "Validate a scene and estimate its cost",
                           R"(  taut check scenes/nunchaku.toml
  taut check scenes/nunchaku.toml --json
  taut check --plans scenes/*.toml                 their plans, as a table in Markdown
  taut check --features                            the methods and the features that they follow
  taut check --schema > scenes/scene.schema.json   the JSON Schema, for editors)");
  const auto options = std::make_shared<Options>();
  options::add_scene_options(command, options->inputs).required(false);
  command.add_option("--plans", options->plans, "Write a table of these scenes' plans instead");
  command.add_flag("--schema", options->schema, "Write the JSON Schema of scene files instead");
  command.add_flag("--features", options->features,
                   "Write tables of methods by the features that they follow instead");
  command.callback([options, &program] {
    program.run = [options, &program] { return run(*options, program.common); };
  });
}

}  // namespace taut::cli
