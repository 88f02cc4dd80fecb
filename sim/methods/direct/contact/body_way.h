// How a body moves in a step, between where it begins and where it ends.
#pragma once

#include <algorithm>
#include <array>

#include "sim/contact/body_mobility.h"
#include "sim/links/mechanism.h"

namespace taut::direct {

/// A body's way through a step: from its velocity at the start, bent to where it ends.
struct BodyWay {
  BodyWay(const double* at_start, const double* at_end, const contact::Vec6& twist, double step)
      : from(at_start),
        h(step),
        velocity(twist.head<3>()),
        bend(Eigen::Map<const Vec3>(at_end) - Eigen::Map<const Vec3>(at_start) - step * velocity),
        turn(angle(quaternion(at_end + 3) * quaternion(at_start + 3).conjugate())) {}

  /// The same of its turn: a body that has been stopped does not seem to come again.
  void bend_turn(const Vec3& spin) {
    constexpr double kMostTurn = 2;  // rad: turns from which on it seems to turn evenly
    if (!(h * spin.norm() < kMostTurn)) return;
    turn_bend = turn - h * spin;
    turn = h * spin;
  }

  /// The pose at a share of the step.
  std::array<double, 7> at(double share) const {
    std::array<double, 7> pose;
    Eigen::Map<Vec3>{pose.data()} =
        Eigen::Map<const Vec3>(from) + share * h * velocity + share * share * bend;
    std::copy_n(from + 3, 4, pose.begin() + 3);
    rotate(share * turn + share * share * turn_bend, &pose[3]);
    return pose;
  }

  /// m: no point of the body that is within `radius` of its centre of mass turns farther.
  double turned(double radius) const { return radius * (turn.norm() + 2 * turn_bend.norm()); }

  const double* from;
  double h;
  Vec3 velocity, bend, turn, turn_bend = Vec3::Zero();
};

}  // namespace taut::direct
