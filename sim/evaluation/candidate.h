// A method with its settings: what studies compare, a row of every table.
#pragma once

#include <string>
#include <vector>

#include "sim/run/method.h"

namespace taut::study {

struct Candidate {
  std::string method;
  Settings settings;  // those that differ from the method's own choice
};

/// "springs (integrator rk4, step 0.001)".
std::string describe(const Candidate& candidate);
/// The settings alone: "integrator rk4, step 0.001"; "defaults" where none is named.
std::string describe(const Settings& settings);

/// Every combination of the values that the method offers to sweeps, the last setting fastest.
/// `thin`: of each number only the ends and the middle.
std::vector<Candidate> sweep(const MethodInfo& method, bool thin);

}  // namespace taut::study
