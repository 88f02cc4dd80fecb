// Scenes as commands take them: several at once, from standard input, with values of their own.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "render/program/command.h"
#include "scenes/scene/scene.h"

namespace taut::options {

struct SceneOptions {
  std::vector<std::string> scenes;  // files; - is standard input
  std::vector<std::string> set;     // KEY=VALUE

  bool several() const { return scenes.size() > 1; }
};

/// SCENE..., which is returned, and, where the command has none of its own, --set.
program::Option add_scene_options(program::Command& command, SceneOptions& options,
                                  bool with_set = true);

/// A pair of --set.
struct SetPair {
  std::string key, value;
};
/// Throws Misuse where `text` is no KEY=VALUE.
SetPair set_pair(const std::string& text);

/// The changes of a command that has no settings of a method to set. Throws Misuse.
std::vector<scenes::SceneChange> scene_changes(const std::vector<std::string>& set);

/// Tells of keys in the scenes that have another name now, unless the run is quiet.
void tell_old_keys(const SceneOptions& options, const program::Common& common);

/// Tells what the files of a scene's models hold that is not drawn, unless the run is quiet; once.
void tell_left_out(const scenes::Scene& scene, const program::Common& common);

/// scenes::complete_stage(), which can be interrupted; says what is left out unless the run is
/// quiet.
void complete_stage(scenes::Scene& scene, const std::vector<scenes::SceneChange>& changes,
                    const program::Common& common);

/// Runs `work` for each scene, one after another; with --json and several scenes their results are
/// the elements of one list. A scene that fails does not keep the others from their turn. Returns
/// the first exit code that is not 0.
int for_each_scene(const SceneOptions& options, const program::Common& common,
                   const std::function<int(const std::string& scene)>& work);

/// The values of --sweep KEY=FROM:UNTIL:COUNT as pairs of --set, evenly from FROM to UNTIL; of an
/// empty text one empty pair. Throws Misuse.
std::vector<std::string> sweep_values(const std::string& sweep);

/// The same for each scene with each of the pairs.
int for_each_run(const SceneOptions& options, const std::vector<std::string>& pairs,
                 const program::Common& common,
                 const std::function<int(const std::string& scene, const std::string& pair)>& work);

/// Where the results of a scene go: `out` or, where that is empty, a folder below `base` by the
/// scene's path, so that no two scenes share one. scenes/ in front of a path is left out, as is the
/// ending. With several scenes each has its own folder in `out`.
std::filesystem::path results_folder(const std::string& scene, const std::string& out, bool several,
                                     const std::filesystem::path& base = "out");

/// The name of files of a scene's results: the scene file's name without its ending.
std::string scene_name(const std::string& scene);

}  // namespace taut::options
