// Golden trajectories: the record of a motion, and the comparison of today's with it.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scenes/load/golden_suite.h"
#include "sim/run/trajectory.h"

namespace taut::golden {

// States and poses as JSON, every number exactly.

/// No record of a golden picture or trajectory is larger.
inline constexpr std::size_t kMaxRecordBytes = 64u << 20;

nlohmann::ordered_json to_json(const Pose& pose);
nlohmann::ordered_json to_json(const Snapshot& state);

/// Throws nlohmann::json::exception if `json` is no pose or state.
Pose pose_from(const nlohmann::json& json);
Snapshot snapshot_from(const nlohmann::json& json);

struct TrajectoryRecord {
  std::map<std::string, std::string> made_from;  // of the scene and the method, by their keys
  std::vector<Snapshot> states;                  // some of the frames, the last included
};

/// Simulates the trajectory. Throws Diverged, Interrupted.
TrajectoryRecord record_of(const scenes::GoldenTrajectory& trajectory);

/// Reads a kept record. Throws BadAsset that names the file and what is wrong with it.
TrajectoryRecord read_trajectory(const std::filesystem::path& file);
TrajectoryRecord trajectory_from(const std::string& text, const std::filesystem::path& file);
std::string trajectory_text(const TrajectoryRecord& record);

struct TrajectoryComparison {
  double distance = 0;  // m, the largest of a point in any kept state
  std::string failure;  // empty: as it was kept
};

/// Compares today's record with the kept one: every kept state is at most `within` (m) away.
TrajectoryComparison compare(const TrajectoryRecord& today, const TrajectoryRecord& kept,
                             double within);

/// The largest distance (m) between like points of two poses: the origins, and the points 0.1 m
/// from them along each axis.
double distance(const Pose& a, const Pose& b);
/// The largest distance (m) between like particles and poses of two states; infinite if they are
/// not of one world.
double distance(const Snapshot& a, const Snapshot& b);

}  // namespace taut::golden
