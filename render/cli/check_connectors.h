// What taut check says of a world's connectors.
#pragma once

#include <string>
#include <vector>

#include "render/program/json.h"
#include "scenes/scene/scene.h"

namespace taut::cli::check_command {

/// A line for each connector; one for all of a net, and for copies that stand side by side.
std::vector<std::string> connector_lines(const World& world);

/// Stiffnesses and drag of a connector that has some: at its first link, if it tapers.
program::Json material_json(const Connector& connector);

}  // namespace taut::cli::check_command
