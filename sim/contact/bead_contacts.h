// Contact as games do it: beads inside of obstacles are moved out, and rubbed.
#pragma once

#include <vector>

#include "sim/links/mechanism.h"
#include "sim/world/world.h"

namespace taut::contact {

/// For methods of fixed steps on a Mechanism, after the step. Contact is found where the step ends:
/// a bead that passes through an obstacle within a step is not stopped.
class BeadContacts {
 public:
  /// Call when the topology is new.
  void rebuild(const Mechanism& mechanism, const World& world);

  bool any() const { return !obstacles_.empty(); }

  /// Moves beads out to the surfaces, and against their sliding since the positions of `before`, as
  /// far as Coulomb's law lets the depth (Mueller et al. 2020, section 3.5).
  void move_out(const Mechanism& mechanism, double time, double dt,
                const std::vector<double>& before, std::vector<double>& state);
  /// After move_out(), with the velocities that positions made: throws beads back with the
  /// obstacle's restitution of the speed that they came with, in `before`.
  void rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
               std::vector<double>& state);

  /// Moves beads out, stops their velocities into the surfaces or throws them back, and slows their
  /// sliding by at most the coefficient of friction times that change.
  void stop(const Mechanism& mechanism, double time, double dt, std::vector<double>& state);

 private:
  struct Met {
    std::size_t point = 0, obstacle = 0;
    Vec3 normal = Vec3::UnitY(), surface = Vec3::Zero();  // m/s, of the obstacle there
    double depth = 0;                                     // m
  };
  void find(const Mechanism& mechanism, double time, const std::vector<double>& state);

  std::vector<Obstacle> obstacles_;
  std::vector<double> radius_;           // m, per point; negative: it touches nothing
  std::vector<std::uint64_t> category_;  // per point
  std::vector<Met> met_;
};

}  // namespace taut::contact
