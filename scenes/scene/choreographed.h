// A choreography as a scene asks for it.
#pragma once

#include <filesystem>

#include "sim/choreography/problem.h"

namespace taut::scenes {

struct Choreographed {
  choreography::Choreography problem;
  double within = 0;           // m, of each waypoint
  std::filesystem::path file;  // where the keys found stand
};

}  // namespace taut::scenes
