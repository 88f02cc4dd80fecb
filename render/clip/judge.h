// Verdicts on methods: by what must hold in every motion of a world, or by a truth.
#pragma once

#include <string>
#include <vector>

#include "render/film/comparison.h"
#include "sim/evaluation/run.h"

namespace taut::clips {

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

}  // namespace taut::clips
