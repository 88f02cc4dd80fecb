// States and poses as JSON, every number exactly.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "sim/run/trajectory.h"

namespace taut::golden {

/// No record of a golden picture or trajectory is larger.
inline constexpr std::size_t kMaxRecordBytes = 64u << 20;

nlohmann::ordered_json to_json(const Pose& pose);
nlohmann::ordered_json to_json(const Snapshot& state);

/// Throws nlohmann::json::exception if `json` is no pose or state.
Pose pose_from(const nlohmann::json& json);
Snapshot snapshot_from(const nlohmann::json& json);

}  // namespace taut::golden
