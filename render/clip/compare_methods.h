// Methods on one scene, run, measured and judged for a film that shows them together.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/film/comparison.h"
#include "render/options/study_options.h"
#include "sim/evaluation/run.h"

namespace taut::clips {

// Verdicts on methods: by what must hold in every motion of a world, or by a truth.

/// What must hold in a world.
struct Laws {
  double energy = 0;    // J, the scale of changes; 0: energy need not be kept
  bool loses = false;   // energy may be lost, to contact or as strings and spans go taut
  double momentum = 0;  // kg m/s, the scale of changes; 0: something holds the world
  bool length = false;  // links do not stretch
};
Laws laws_of(const World& world, const Timeline& timeline);
/// What a method does that obeys them: "keeps energy and length"; empty: there is no law.
std::string words_of(const Laws& laws);

/// "keeps energy and length", "gains 180% energy and stretches by 11%". An error of film::kKept of
/// its scale is none.
film::Verdict by_laws(const study::Run& run, const Laws& laws);
/// By the mean distances (m) from the truth of each frame up to its horizon: "within 0.1 mm of the
/// truth". `length` (m) is that of which film::kKept is right.
film::Verdict by_truth(const study::Run& run, const std::vector<double>& distances, double length);

/// The clauses of the sentence that sums a comparison up: those that are right first.
std::vector<std::string> result_of(const film::Comparison& comparison);

/// "11 ms", "1.2 s": with two digits.
std::string duration_text(double seconds);

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
