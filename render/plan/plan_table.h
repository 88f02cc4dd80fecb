// The plans that scenes carry, side by side.
#pragma once

#include <string>
#include <vector>

#include "render/chart/table.h"

namespace taut::planning {

/// One row for each scene file: what was asked, what the plan takes, and what it keeps to. Throws
/// BadScene.
chart::Table plan_table(const std::vector<std::string>& scenes);

}  // namespace taut::planning
