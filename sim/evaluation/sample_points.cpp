#include "sim/evaluation/sample_points.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace taut::study {
namespace {

/// Of every particle, how far along the connector it is, as a share of the length.
std::vector<double> shares(const std::vector<Vec3>& particles) {
  std::vector<double> along{0};
  for (std::size_t i = 1; i < particles.size(); ++i) {
    along.push_back(along.back() + (particles[i] - particles[i - 1]).norm());
  }
  if (const double length = along.back(); length > 0) {
    for (double& share : along) share /= length;
  }
  return along;
}

}  // namespace

SamplePoints::SamplePoints(const World& world, const Snapshot& start) {
  for (const auto& particles : start.connectors) along_.push_back(shares(particles));
  for (const Connector& connector : world.connectors) running_.push_back({connector.winch, {}, {}});
  running_.resize(along_.size());
  for (std::size_t p = 0; p < world.pulleys.size(); ++p) {
    running_[world.pulleys[p].from].leaves.push_back(p);
    running_[world.pulleys[p].to].enters.push_back(p);
  }
  for (const Body& body : world.bodies) {
    const std::array<Vec3, 6> ends = box_ends(body.bare);
    ends_.emplace_back(ends.begin(), ends.end());
  }
}

std::vector<double> SamplePoints::along(std::size_t connector, const Snapshot& state) const {
  const Running& running = running_[connector];
  if (!running.winch) return along_[connector];
  const Winch& winch = *running.winch;
  double longer = winch.longer(state.time).length;
  for (const std::size_t p : running.enters) longer += state.passed.at(p);
  for (const std::size_t p : running.leaves) longer -= state.passed.at(p);
  std::vector<double> along{0};
  for (std::size_t k = 0; k < winch.rest.size(); ++k) {
    along.push_back(along.back() + winch.rest[k] + winch.share(k) * longer);
  }
  const double length = along.back();
  for (double& share : along) share /= length;
  return along;
}

std::vector<Vec3> SamplePoints::places(const SamplePoints& of, const Snapshot& state) const {
  if (along_.size() != of.along_.size() || ends_.size() != of.ends_.size()) {
    throw std::invalid_argument("motions of different worlds cannot be compared");
  }
  std::vector<Vec3> places;
  for (std::size_t c = 0; c < along_.size(); ++c) {
    const std::vector<double> along = this->along(c, state), others = of.along(c, state);
    const std::vector<Vec3>& particles = state.connectors[c];
    std::size_t link = 0;
    for (const double share : others) {
      while (link + 2 < along.size() && along[link + 1] < share) ++link;
      const double length = along[link + 1] - along[link];
      const double part = length > 0 ? std::clamp((share - along[link]) / length, 0.0, 1.0) : 0;
      places.push_back(particles[link] + part * (particles[link + 1] - particles[link]));
    }
  }
  for (std::size_t b = 0; b < ends_.size(); ++b) {
    for (const Vec3& end : of.ends_[b]) places.push_back(state.bodies[b].to_world(end));
  }
  return places;
}

}  // namespace taut::study
