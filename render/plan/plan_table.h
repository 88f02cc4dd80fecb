// The plans that scenes carry, side by side.
#pragma once

#include <string>
#include <vector>

#include "render/chart/table.h"
#include "render/program/json.h"

namespace taut::planning {

/// A row for each scene file: the tolerance asked for, the plan, and the accuracy that it keeps.
/// Throws BadScene.
chart::Table plan_table(const std::vector<std::string>& scenes);
/// The same as JSON, with all that plans hold.
program::Json plans_json(const std::vector<std::string>& scenes);

}  // namespace taut::planning
