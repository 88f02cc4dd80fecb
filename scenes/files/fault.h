// A fault of a scene file that knows where it stands.
#pragma once

#include <string>
#include <utility>

#include "scenes/files/error.h"

namespace taut::scenes {

/// Where a scene file is wrong. Lines and columns count from 1; 0: no place in a file.
struct FaultPlace {
  std::string file = {};
  int line = 0, column = 0;
  std::string key = {};    // dotted, from the root
  std::string fault = {};  // the message without its place
};

class SceneFault : public BadScene {
 public:
  SceneFault(const std::string& message, FaultPlace where)
      : BadScene(message), place(std::move(where)) {}
  FaultPlace place;
};

}  // namespace taut::scenes
