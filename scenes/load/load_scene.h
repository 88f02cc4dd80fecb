// Reading scenes from TOML files, and the list of the files that a scene consists of.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// Reads and checks a scene. Throws BadScene. Without `with_stage` it loads no assets but
/// characters.
Scene load_scene(const std::filesystem::path& file, bool with_stage,
                 const std::vector<SceneChange>& changes = {});

/// A sentence for each key of the file that has another name now, with its place. Throws BadScene.
std::vector<std::string> old_keys(const std::filesystem::path& file);

/// The ropes that pass pulleys, driven ones included, and have mass.
std::set<std::string> heavy_ropes(const World& world);

/// What makes such a rope massless: its spans are straight, and only their length counts.
std::vector<SceneChange> without_mass(const std::string& rope);

/// Reads a scene as its plan models and solves it. Throws BadScene, also where it has no plan or
/// changed since the plan was made.
Scene load_planned(const std::filesystem::path& file, bool with_stage);

/// What a scene's choreography asks for, of the scene's world before the keys found; the file with
/// them need not be there. Nothing where the scene has no choreography. Throws BadScene.
std::optional<Choreographed> load_choreography(const std::filesystem::path& file,
                                               const std::vector<SceneChange>& changes = {});

/// The files of a scene: its own, the one that it extends, and the models, paths and winds that it
/// names and that exist. Only its own if that cannot be read.
std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene);

}  // namespace taut::scenes
