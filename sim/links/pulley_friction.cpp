#include "sim/links/pulley_friction.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace taut {
namespace {

using Slip = Mechanism::Slip;

/// How far (share of both tensions) the larger one is from sliding: below zero it slides.
double from_sliding(const Mechanism::Pull& pull) {
  const double sum = std::abs(pull.before) + std::abs(pull.behind);
  const double forwards = pull.ratio * pull.before - pull.behind;
  const double backwards = pull.ratio * pull.behind - pull.before;
  return sum > 0 ? std::min(forwards, backwards) / sum : 0;
}

/// How far both are from pushing.
double from_pushing(const Mechanism::Pull& pull) {
  const double sum = std::abs(pull.before) + std::abs(pull.behind);
  return sum > 0 ? std::max(pull.before, pull.behind) / sum : 0;
}

}  // namespace

void PulleyFriction::rebuild(const Mechanism& mechanism) {
  any_ = false;
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) any_ = any_ || mechanism.has_friction(p);
  right_.reserve(mechanism.row_room());
  tension_.reserve(mechanism.row_room());
  right_.resize(mechanism.unknowns());
  tension_.resize(mechanism.unknowns());
}

void PulleyFriction::solve(Mechanism& mechanism, TensionSystem& system, double time,
                           std::vector<double>& state) {
  mechanism.update(time, state.data());
  mechanism.right_side(right_);
  system.assemble(mechanism);
  system.solve(right_, tension_);
}

void PulleyFriction::decide(Mechanism& mechanism, TensionSystem& system, double time,
                            std::vector<double>& state) {
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
    if (!mechanism.has_friction(p)) continue;
    double& speed = state[mechanism.speed(p)];
    if (std::abs(speed) <= kNear) speed = 0;
    mechanism.set_slip(p, speed > 0 ? Slip::forwards : speed < 0 ? Slip::backwards : Slip::stick);
  }
  // Pulleys change one after another: each changes the tensions at others. Between two that stay,
  // the tension of rope without mass is undetermined: one of the two is left at its limit.
  constexpr double kMost = 2;  // beyond all shares
  for (std::size_t change = 0; change < 4 * mechanism.pulleys(); ++change) {
    solve(mechanism, system, time, state);
    double worst = -kNear;
    std::size_t which = mechanism.pulleys();
    Slip now = Slip::stick;
    const auto consider = [&](double distance, std::size_t pulley, Slip slip) {
      if (!(distance < worst)) return;
      worst = distance;
      which = pulley;
      now = slip;
    };
    for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
      const Slip slip = mechanism.slip(p);
      if (!mechanism.has_friction(p)) continue;
      const Mechanism::Pull pull = mechanism.pull_at(p, tension_.data());
      const double speed = state[mechanism.speed(p)];
      const double goes = speed != 0 ? speed : tension_[mechanism.rows().size() + p];
      const double ahead = slip == Slip::forwards ? goes : -goes;
      if (slip == Slip::free) {
        consider(-from_pushing(pull), p, goes > 0 ? Slip::forwards : Slip::backwards);
      } else if (from_pushing(pull) < 0) {
        consider(from_pushing(pull), p, Slip::free);
      } else if (slip != Slip::stick && ahead < -kNear) {
        consider(-kMost, p, Slip::stick);  // it began to slide before others did
      } else if (slip == Slip::stick) {
        consider(from_sliding(pull), p,
                 pull.behind > pull.before ? Slip::forwards : Slip::backwards);
      }
    }
    if (which == mechanism.pulleys()) return;
    mechanism.set_slip(which, now);
  }
}

double PulleyFriction::distance(Mechanism& mechanism, TensionSystem& system, double time,
                                std::vector<double>& state) {
  solve(mechanism, system, time, state);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
    if (!mechanism.has_friction(p)) continue;
    const Mechanism::Pull pull = mechanism.pull_at(p, tension_.data());
    const double speed = state[mechanism.speed(p)];
    switch (mechanism.slip(p)) {
      case Slip::free:
        least = std::min(least, -from_pushing(pull));
        break;
      case Slip::stick:
        least = std::min({least, from_sliding(pull), from_pushing(pull)});
        break;
      case Slip::forwards:
        least = std::min({least, speed, from_pushing(pull)});
        break;
      case Slip::backwards:
        least = std::min({least, -speed, from_pushing(pull)});
        break;
    }
  }
  return least;
}

double PulleyFriction::share(double before, double behind) {
  constexpr double kLeast = 0.01;
  if (!(before > 0)) return 0.5;
  return std::clamp(before / (before - behind), kLeast, 1 - kLeast);
}

double winch_tension(const World& world, std::size_t index, std::size_t end) {
  const Connector& connector = world.connectors[index];
  if (!connector.winch || !connector.winch->paths[end]) {
    throw std::invalid_argument("the connector " + connector.name + " has no winch there");
  }
  Mechanism mechanism(world);
  TensionSystem system(mechanism);
  std::vector<double> state, right, tension;
  mechanism.load(world, state);
  PulleyFriction friction;
  friction.rebuild(mechanism);
  if (friction.any()) friction.decide(mechanism, system, world.time, state);
  mechanism.update(world.time, state.data());
  mechanism.right_side(right);
  system.assemble(mechanism);
  system.solve(right, tension);
  std::vector<double> slope(state.size());
  mechanism.differentiate(state.data(), tension.data(), slope.data());
  std::vector<Vec3> acceleration;
  for (std::size_t i = 0; i < mechanism.points(); ++i) {
    acceleration.emplace_back(Eigen::Map<const Vec3>(&slope[mechanism.velocity(i)]));
  }
  std::size_t first = 0;
  for (const Connector& other : world.connectors) {
    for (const Hold& hold : other.holds) {  // whose slopes are zero
      acceleration[first + hold.particle] = hold_motion(world, hold.to, world.time).acceleration;
    }
    first += other.particles();
  }
  return mechanism.drum_force(index, end, state.data(), tension.data(), acceleration);
}

}  // namespace taut
