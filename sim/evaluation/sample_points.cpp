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
  for (const Body& body : world.bodies) {
    const std::array<Vec3, 6> ends = box_ends(body.bare);
    ends_.emplace_back(ends.begin(), ends.end());
  }
}

std::vector<Vec3> SamplePoints::places(const SamplePoints& of, const Snapshot& state) const {
  if (along_.size() != of.along_.size() || ends_.size() != of.ends_.size()) {
    throw std::invalid_argument("motions of different worlds cannot be compared");
  }
  std::vector<Vec3> places;
  for (std::size_t c = 0; c < along_.size(); ++c) {
    const std::vector<double>& along = along_[c];
    const std::vector<Vec3>& particles = state.connectors[c];
    std::size_t link = 0;
    for (const double share : of.along_[c]) {
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
