// Which method a scene asks for.
#pragma once

#include <string>

#include "sim/run/method.h"

namespace taut {

struct MethodChoice {
  std::string name;
  Settings settings;  // those that the scene names, validated against the method's list
};

}  // namespace taut
