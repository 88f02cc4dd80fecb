// --method, --step, --tolerance and --set, for every command that simulates.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/program/command.h"
#include "scenes/scene/scene.h"
#include "sim/run/method.h"

namespace taut::options {

// The commands that make what pages show, as a shell takes them.

/// Which scene: its file, and what --set puts in place of its values.
struct ShownScene {
  std::string file;
  std::vector<std::string> set;
};

/// A run's cost and its errors from `share` of the length up.
std::string score_command(const ShownScene& scene, const MethodChoice& candidate, double share);

/// The class of a run of `duration` (s) of the scene with changes, stopped after `cap` (s) of CPU
/// time; with `scored`, told accurate from plausible.
std::string classify_command(const ShownScene& scene,
                             const std::vector<scenes::SceneChange>& changes,
                             const std::string& label, const MethodChoice& candidate,
                             double duration, double cap, bool scored);

/// A word as a shell takes it for one.
std::string quoted(const std::string& word);

struct MethodOptions {
  std::string method;               // empty: the scene's
  std::optional<double> step;       // s
  std::optional<double> tolerance;  // m
  std::vector<std::string> set;     // KEY=VALUE, of the method or of the scene
  bool planned = false;             // the model and the method of the scene's plan
};

void add_method_options(program::Command& command, MethodOptions& options);

/// The scene as it is written or, where the options say so, as its plan has it. Throws BadScene.
scenes::Scene load_chosen(const std::filesystem::path& file, bool with_stage,
                          const MethodOptions& options);

/// The changes of --set to the scene.
std::vector<scenes::SceneChange> chosen_changes(const MethodOptions& options);

/// The KEY=VALUE that are of the scene; and, with their types, those that are settings of the
/// method, others left out. Throws Misuse.
std::vector<std::string> sets_of_scene(const std::vector<std::string>& set);
Settings settings_of(const MethodInfo& method, const std::vector<std::string>& set);

/// The scene's method with the options put over its settings. Another method starts from its own:
/// the step that suits one diverges in the next. Throws Misuse.
MethodChoice chosen_method(const MethodOptions& options, const scenes::Scene& scene);

/// Settings as a JSON object.
nlohmann::ordered_json settings_json(const Settings& settings);

/// Settings as one line: step = 0.001, restitution = 0.2
std::string settings_text(const Settings& settings);

// The settings of the methods, as --help lists them.

/// Every setting of every method: name, default, unit, range, meaning. From the list of methods.
std::string settings_help();

}  // namespace taut::options
