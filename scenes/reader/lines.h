// Connectors joined end to end, which hang as one between the two places at its ends.
#pragma once

#include <cstddef>
#include <vector>

#include "scenes/reader/joints.h"

namespace taut::scenes {

/// A connector of a line; against it where it runs from its last particle to its first.
struct InLine {
  std::size_t connector = 0;
  bool against = false;
};
using Line = std::vector<InLine>;

/// All lines of two connectors and more that say nothing of their start: ends of neighbours are
/// joined to each other, and to nothing else.
std::vector<Line> lines_of(const Value& connectors, const World& world, const JoinedEnds& joined);

/// Of all its connectors together, m.
double length_of(const Line& line, const World& world);

/// Lays all connectors of a line at rest between two places. Throws std::invalid_argument where
/// there is no equilibrium.
void hang_line(World& world, const Line& line, const Vec3& from, const Vec3& to);

}  // namespace taut::scenes
