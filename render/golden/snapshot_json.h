// States as JSON, every number exactly.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/run/trajectory.h"

namespace taut {

nlohmann::ordered_json to_json(const Snapshot& state);

/// Throws nlohmann::json::exception where `json` is no state.
Snapshot snapshot_from(const nlohmann::json& json);

}  // namespace taut
