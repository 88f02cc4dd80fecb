// The energy of a motion that nothing accounts for.
#pragma once

#include <vector>

#include "sim/interventions/timeline.h"
#include "sim/topology/components.h"
#include "sim/world/world.h"

namespace taut::study {

/// Follows a motion from frame to frame: by how much its energy differs from what it was after the
/// last intervention and what driven ends have added since.
///
/// The work of an end comes from momenta alone, whatever method moves the links: a part of mass M
/// and momentum P on one prescribed point h feels the force P' - M g there, so that its work is the
/// integral of h' . (P' - M g) = [h' . P] - M g . [h] - integral of h'' . P. Between frames the
/// centre of mass is taken for the cubic that has its places and velocities.
class EnergyBalance {
 public:
  explicit EnergyBalance(const Timeline& timeline);

  /// Goes on to the next frame, in which the world is so; the energy that is left over, J.
  double next(const World& world);

  /// False where something moved two points of one part, whose work momenta do not tell apart: then
  /// the work is in what is left over.
  bool complete() const { return complete_; }

  /// Whether a pin came, drew or went, or something was cut, between two times (s): each may change
  /// the energy, as mass moves to where a connector is cut.
  bool intervened(double from, double until) const;

 private:
  struct Interval {
    double from = 0, until = 0;  // s
  };
  struct Part {
    double mass = 0;                // kg
    Vec3 centre = Vec3::Zero();     // m
    Vec3 momentum = Vec3::Zero();   // kg m/s
    std::vector<Attachment> holds;  // whose motion is known beforehand
  };
  std::vector<Part> parts(const World& world);
  double work(const World& world, const Part& before, const Part& after, double from);

  Division division_;
  std::vector<Interval> interventions_;
  std::vector<Part> before_;
  bool begun_ = false, complete_ = true;
  double time_ = 0;   // s, of the last frame
  double level_ = 0;  // J: what the energy should be
};

}  // namespace taut::study
