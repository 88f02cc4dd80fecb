// Tables of scores.
#pragma once

#include <string>
#include <vector>

#include "tests/bench/promise/score.h"

namespace taut::promise {

/// Per tolerance, of every kind and of all: how many are within the tolerance and thrice that, the
/// errors' median, 95th percentile and worst in tolerances, and what a simulated second costs.
std::string table(const std::vector<Score>& scores);

/// Per tolerance and of all: how many runs' own estimates are within a factor of three of the
/// error, the estimates' 5th percentile, median and 95th in errors, and what they cost in runs.
std::string estimates(const std::vector<Score>& scores);

/// The `count` largest errors, in tolerances.
std::string worst(std::vector<Score> scores, std::size_t count);

std::string csv(const std::vector<Score>& scores);

}  // namespace taut::promise
