// Methods on one scene, run and measured for a film that shows them together.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/film/comparison.h"
#include "render/options/study_options.h"

namespace taut::clips {

/// The slow motion of a clip that nothing else is said of, where no truth is predictable.
inline constexpr int kSlower = 6;

/// CPU times (µs per frame) by method.
using CpuTimes = std::map<std::string, double>;
/// Those of a compare.json. Throws Misuse, with the file and the key.
CpuTimes cpu_times(const std::filesystem::path& file);

struct CompareSettings {
  std::optional<int> slower = {};      // none: kSlower where no truth is predictable, else 1
  std::optional<CpuTimes> times = {};  // in place of those measured
  bool quiet = false;
};

/// Solves the truth at the scene's frames, runs every contender at its settings or, where they are
/// of its method, the scene's, and judges each: by its distance from the truth where that is
/// predictable for at least a quarter of the scene, else by energy, length and momentum. Measures
/// the distance from dynamic constraints, too, as the paper's Figure 6 does. Throws Misuse where
/// `times` lacks a contender.
film::Comparison compare_methods(const scenes::Scene& scene,
                                 const std::vector<options::Contender>& contenders,
                                 const CompareSettings& settings);

}  // namespace taut::clips
