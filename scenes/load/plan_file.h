// The plan that a scene file carries: writing it, and telling whether it is still true.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// Of everything that a plan depends on: the scene's text without its plan, and the files of its
/// paths. Throws BadScene.
std::uint64_t plan_stamp(const std::filesystem::path& scene);

/// Of a small motion by the method at its settings, rounded to far more than processors differ by:
/// another one where the program's method is another than the plan was made by.
std::uint64_t method_stamp(const MethodChoice& method);

/// A scene's text with the plan at its end, in place of the one that it has. Throws BadScene where
/// the text is not TOML.
std::string with_plan(std::string_view text, const Plan& plan);

}  // namespace taut::scenes
