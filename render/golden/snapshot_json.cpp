#include "render/golden/snapshot_json.h"

#include <nlohmann/json.hpp>

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

}  // namespace taut::golden
