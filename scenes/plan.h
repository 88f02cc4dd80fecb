// A plan: the cheapest model of a scene that nobody can tell from the exact one, as `taut plan`
// found it, kept in the scene file's table [plan].
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "scenes/method_choice.h"

namespace taut {

struct Plan {
  std::string tolerance;         // "1px", "0.5mm"
  double error = 0;              // the largest until `until`, in the tolerance's unit
  double until = 0;              // s: as long as the motion is predictable
  std::optional<double> energy;  // afterwards: the largest change, of what it can turn into motion
  std::uint64_t stamp = 0;       // of what it was made from
  MethodChoice method;
  std::map<std::string, std::size_t> particles;  // of each; 0: a massless span
};

/// Of everything that a plan depends on: the scene's text without its plan, and the files of its
/// paths. Throws BadScene.
std::uint64_t plan_stamp(const std::filesystem::path& scene);

/// A scene's text with the plan in place of the one that it has, or at its end.
std::string with_plan(std::string_view text, const Plan& plan);

/// "within 0.4 px of the exact motion until 4.1 s; afterwards energy within 0.1%".
std::string certificate(const Plan& plan);

}  // namespace taut
