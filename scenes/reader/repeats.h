// Connectors that a scene describes once and has many times.
#pragma once

#include <cstddef>
#include <vector>

#include "scenes/format/document.h"
#include "sim/world/connector.h"

namespace taut::scenes {

/// A copy's place and time against those of the first.
struct Repeat {
  Vec3 by = Vec3::Zero();  // m
  double delay = 0;        // s
};

/// A connector's copies, the first included.
std::vector<Repeat> repeats(const Value& connector);
/// How many that are.
std::size_t repeat_count(const Value& connector);

/// Copy number `index` of `first`, its fixed points and paths with it; called NAME#2 and so on.
Connector repeated(const Connector& first, std::size_t index, const Repeat& repeat);

}  // namespace taut::scenes
