// The terms of twist in the matrices of ElasticSystem.
#include "sim/methods/direct/system/elastic_system.h"

namespace taut::direct {

/// Where the connector's frame is carried from one edge to the next: at each particle.
void ElasticSystem::rebuild_twist() {
  twist_slope_.clear();
  carries_.clear();
  if (material_.twists().empty()) return;
  const material::TwistElement& rod = material_.twists().front();
  twist_slope_.assign(size(), 0.0);
  carries_.push_back({.a = 0, .b = 0, .c = 1, .clamp = rod.from});
  for (std::uint32_t i = 1; i < rod.links; ++i)
    carries_.push_back({.a = i - 1, .b = i, .c = i + 1});
  carries_.push_back({.a = rod.links - 1, .b = rod.links, .c = rod.links, .clamp = rod.to});
}

/// The moment times the second derivatives of the twist, and its first derivatives.
void ElasticSystem::differentiate_twist(const double* x, const double* v) {
  if (carries_.empty()) return;
  const material::TwistElement& rod = material_.twists().front();
  double moment = rod.stiffness * material_.twist(rod, x);
  if (rod.damping > 0) moment += rod.damping * material_.twist_rate(rod, x, v);
  Vec3 e0, e1;
  for (const material::BendElement& at : carries_) {
    material_.edges(at, x, e0, e1);
    const material::Bend::Stiffness second = material::Carry(e0, e1).second();
    add_bend(at, moment * second.e0_e0, moment * second.e0_e1, moment * second.e1_e1, stiffness_);
  }
  material_.twist_slope(rod, x, force_);
  for (std::size_t i = 0; i < particles(); ++i) {
    if (held_[i]) continue;
    for (std::size_t c = 0; c < 3; ++c) twist_slope_[4 * i + c] = force_[i][static_cast<int>(c)];
  }
}

void ElasticSystem::add_twist_damping(const double* by, double* to) const {
  if (carries_.empty() || material_.twists().front().damping == 0) return;
  double rate = 0;
  for (std::size_t u = 0; u < size(); ++u) rate += twist_slope_[u] * by[u];
  const double moment = material_.twists().front().damping * rate;
  for (std::size_t u = 0; u < size(); ++u) to[u] += moment * twist_slope_[u];
}

double ElasticSystem::end_turn(const double* x) const {
  return carries_.empty() ? 0 : material_.turned(material_.twists().front(), x);
}

double ElasticSystem::followed_turn() const {
  return carries_.empty() ? 0 : material_.twists().front().since;
}

}  // namespace taut::direct
