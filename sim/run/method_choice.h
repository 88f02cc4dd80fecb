// A method with its settings: what a scene asks for, what studies compare, a row of every table.
#pragma once

#include <string>

#include "sim/run/method.h"

namespace taut {

struct MethodChoice {
  std::string name;
  Settings settings;  // those that differ from the method's own choice
};

/// Every setting of the method, which must exist: with its own choice for those left out.
Settings with_defaults(const MethodChoice& choice);

/// The value as text; numbers with so many significant digits, zero: as many as tell it exactly.
std::string setting_text(const Setting& value, int digits = 0);

/// "springs (integrator rk4, step 0.001)".
std::string describe(const MethodChoice& choice);
/// The settings alone: "integrator rk4, step 0.001"; "defaults" where none is named.
std::string describe(const Settings& settings);

}  // namespace taut
