#include "render/golden/golden_trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "render/base/interrupt.h"
#include "scenes/files/files.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::golden {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Vec3& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Vec3 vec3(const nlohmann::json& list) {
  return {list.at(0).get<double>(), list.at(1).get<double>(), list.at(2).get<double>()};
}

}  // namespace

nlohmann::ordered_json to_json(const Pose& pose) {
  const Quat& q = pose.rotation;
  return {{"position", to_json(pose.position)}, {"rotation", {q.w(), q.x(), q.y(), q.z()}}};
}

Pose pose_from(const nlohmann::json& json) {
  const auto& q = json.at("rotation");
  const auto part = [&](std::size_t i) { return q.at(i).get<double>(); };
  return {vec3(json.at("position")), Quat(part(0), part(1), part(2), part(3)).normalized()};
}

nlohmann::ordered_json to_json(const Snapshot& state) {
  Json connectors = Json::array(), bodies = Json::array();
  for (const auto& particles : state.connectors) {
    Json list = Json::array();
    for (const Vec3& particle : particles) list.push_back(to_json(particle));
    connectors.push_back(std::move(list));
  }
  for (const Pose& body : state.bodies) bodies.push_back(to_json(body));
  nlohmann::ordered_json json{{"time", state.time}, {"connectors", connectors}, {"bodies", bodies}};
  if (!state.passed.empty()) json["passed"] = state.passed;
  return json;
}

Snapshot snapshot_from(const nlohmann::json& json) {
  Snapshot state;
  state.time = json.at("time").get<double>();
  for (const auto& list : json.at("connectors")) {
    auto& particles = state.connectors.emplace_back();
    for (const auto& particle : list) particles.push_back(vec3(particle));
  }
  for (const auto& body : json.at("bodies")) state.bodies.push_back(pose_from(body));
  state.passed = json.value("passed", std::vector<double>());
  return state;
}

namespace {

using Json = nlohmann::ordered_json;

constexpr int kStates = 8;  // kept of each trajectory, at most

/// The inputs of the motion, for people: the rest of the file would fill pages.
std::map<std::string, std::string> sources(const scenes::Scene& scene, const MethodChoice& method) {
  std::map<std::string, std::string> list = {{"fps", fmt::to_string(scene.fps)},
                                             {"method.name", method.name}};
  const Vec3& g = scene.world.gravity;
  list["gravity"] = fmt::format("[{}, {}, {}]", g.x(), g.y(), g.z());
  for (const auto& [name, value] : method.settings) list["method." + name] = setting_text(value);
  for (const Connector& connector : scene.world.connectors) {
    const std::string key = "connectors." + connector.name;
    list[key + ".length"] = fmt::format("{}", connector.length);
    list[key + ".mass"] = fmt::format("{}", connector.mass);
    list[key + ".particles"] = fmt::to_string(connector.particles());
  }
  for (const Body& body : scene.world.bodies)
    list["bodies." + body.name + ".mass"] = fmt::format("{}", body.mass_properties.mass);
  return list;
}

/// The changes of the motion's sources since; empty where nothing is known of them.
std::string changes_since(const TrajectoryRecord& today, const TrajectoryRecord& kept) {
  std::string changes;
  const auto add = [&](const std::string& change) {
    changes += (changes.empty() ? "" : ", ") + change;
  };
  if (kept.made_from.empty()) return {};
  for (const auto& [key, value] : today.made_from) {
    const auto was = kept.made_from.find(key);
    if (was == kept.made_from.end()) {
      add(key + " is new");
    } else if (was->second != value) {
      add(fmt::format("{} was {} and is {}", key, was->second, value));
    }
  }
  for (const auto& [key, value] : kept.made_from)
    if (!today.made_from.contains(key)) add(key + " is gone");
  return changes;
}

}  // namespace

TrajectoryRecord record_of(const scenes::GoldenTrajectory& trajectory) {
  scenes::Scene scene = scenes::load_scene(trajectory.scene, false);
  scenes::settle_breaks(scene, trajectory.method);
  Simulation simulation = scenes::start(scene, trajectory.method);
  TrajectoryRecord record;
  record.made_from = sources(scene, trajectory.method);
  const int states = std::min(kStates, trajectory.last);
  for (int k = 1; k <= trajectory.last; ++k) {
    render::stop_if_interrupted();
    simulation.advance_to(double(k) / scene.fps);
    // Of last frames, the states-th parts, each rounded down.
    if (k * states / trajectory.last != (k - 1) * states / trajectory.last)
      record.states.push_back(simulation.state());
  }
  return record;
}

TrajectoryRecord read_trajectory(const std::filesystem::path& file) {
  return trajectory_from(
      scenes::read_regular_file(file, kMaxRecordBytes, "a record of a golden trajectory"), file);
}

TrajectoryRecord trajectory_from(const std::string& text, const std::filesystem::path& file) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    TrajectoryRecord record;
    if (json.contains("made_from")) json.at("made_from").get_to(record.made_from);
    for (const auto& state : json.at("states")) record.states.push_back(snapshot_from(state));
    return record;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw scenes::BadAsset(
        fmt::format("{}: no record of a golden trajectory: {}", file.string(), error.what()));
  }
}

std::string trajectory_text(const TrajectoryRecord& record) {
  Json states = Json::array();
  for (const Snapshot& state : record.states) states.push_back(to_json(state));
  return Json({{"made_from", record.made_from}, {"states", std::move(states)}}).dump() + "\n";
}

TrajectoryComparison compare(const TrajectoryRecord& today, const TrajectoryRecord& kept,
                             double within) {
  TrajectoryComparison result;
  if (today.states.size() != kept.states.size())
    result.distance = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min(today.states.size(), kept.states.size()); ++i)
    result.distance = std::max(result.distance, distance(today.states[i], kept.states[i]));
  if (!(result.distance <= within))
    result.failure = fmt::format("the simulation is {:.3g} m from a kept state, {:.3g} m allowed",
                                 result.distance, within);
  if (const std::string since = changes_since(today, kept);
      !since.empty() && !result.failure.empty())
    result.failure += "; since it was accepted " + since;
  return result;
}

double distance(const Pose& a, const Pose& b) {
  constexpr double kArm = 0.1;  // m
  double largest = (a.position - b.position).norm();
  for (int axis = 0; axis < 3; ++axis) {
    const Vec3 arm = kArm * Vec3::Unit(axis);
    largest = std::max(largest, (a.to_world(arm) - b.to_world(arm)).norm());
  }
  return largest;
}

double distance(const Snapshot& a, const Snapshot& b) {
  constexpr double kOther = std::numeric_limits<double>::infinity();
  if (a.connectors.size() != b.connectors.size() || a.bodies.size() != b.bodies.size())
    return kOther;
  double largest = 0;
  for (std::size_t c = 0; c < a.connectors.size(); ++c) {
    if (a.connectors[c].size() != b.connectors[c].size()) return kOther;
    for (std::size_t i = 0; i < a.connectors[c].size(); ++i)
      largest = std::max(largest, (a.connectors[c][i] - b.connectors[c][i]).norm());
  }
  for (std::size_t i = 0; i < a.bodies.size(); ++i)
    largest = std::max(largest, distance(a.bodies[i], b.bodies[i]));
  return largest;
}

}  // namespace taut::golden
