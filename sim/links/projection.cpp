#include "sim/links/projection.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/motion/stop.h"

namespace taut {
namespace {

constexpr int kIterations = 20;
constexpr double kRounding = 1e-14;  // m: rounding of positions of about a metre

}  // namespace

void Projection::rebuild(const Mechanism& mechanism) {
  system_.rebuild(mechanism);
  multiplier_.reserve(mechanism.row_room());
  multiplier_.resize(mechanism.unknowns());
  right_.resize(mechanism.pulleys() > 0 ? mechanism.unknowns() : 0);
}

/// `rows`, and zero for each pulley.
const std::vector<double>& Projection::right_side(const std::vector<double>& rows) {
  if (right_.empty()) return rows;
  std::ranges::copy(rows, right_.begin());
  return right_;
}

Projection::Left Projection::lengths(Mechanism& mechanism, double time,
                                     std::vector<double>& state) {
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    Eigen::Map<Eigen::Vector4d>(&state[mechanism.pose(b) + 3]).normalize();
  }
  mechanism.update(time, state.data());
  if (multiplier_.empty()) return {};
  Left left;
  for (int i = 0;; ++i) {
    const double before = left.violation;
    const auto& violation = mechanism.violation();
    const auto worst =
        std::ranges::max_element(violation, {}, [](double x) { return std::abs(x); });
    left = {std::abs(*worst), static_cast<std::size_t>(worst - violation.begin())};
    const bool settled = i > 0 && left.violation < kKept && left.violation > before / 2;
    if (!(left.violation >= kRounding) || settled || i == kIterations) return left;
    check_stop();
    system_.assemble(mechanism);
    system_.solve(right_side(violation), multiplier_);
    mechanism.move(multiplier_.data(), state.data());
    mechanism.update(time, state.data());
  }
}

void Projection::rates(Mechanism& mechanism, double time, std::vector<double>& state) {
  mechanism.update(time, state.data());
  if (multiplier_.empty()) return;
  system_.assemble(mechanism);
  system_.solve(right_side(mechanism.rate()), multiplier_);
  mechanism.push(multiplier_.data(), state.data());
  mechanism.place(time, state.data());
}

bool restore_lengths(World& world) {
  Mechanism mechanism(world);
  Projection projection(mechanism);
  std::vector<double> state;
  mechanism.load(world, state);
  if (!(projection.lengths(mechanism, world.time, state).violation <= Projection::kKept))
    return false;
  mechanism.store(state, world.time, world);
  return true;
}

bool stretches(const World& world) {
  constexpr double kRelative = 1e-13;
  for (const Connector& connector : world.connectors) {
    const std::vector<Vec3>&position = connector.position, &velocity = connector.velocity;
    double speed = 0;  // squared, of the particle before
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      const double last = std::exchange(speed, velocity[i].squaredNorm());
      if (i == 0) continue;
      const Vec3 apart = position[i] - position[i - 1];
      const double stretch = apart.dot(velocity[i] - velocity[i - 1]);
      const double most = kRelative * kRelative * std::max(last, speed) * apart.squaredNorm();
      if (stretch * stretch > most) return true;
    }
  }
  return false;
}

void VelocityProjection::stop(World& world) {
  mechanism_.rebuild(world);
  projection_.rebuild(mechanism_);
  state_.reserve(mechanism_.state_room());
  mechanism_.load(world, state_);
  projection_.rates(mechanism_, world.time, state_);
  mechanism_.store(state_, world.time, world);
}

}  // namespace taut
