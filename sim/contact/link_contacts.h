// Contact of links as games do it: capsules between beads are moved out of obstacles, and rubbed.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/world/world.h"

namespace taut::contact {

/// As BeadContacts, of the links between beads where Connector::links_touch says so. What a link
/// gets at a point goes to its ends by the lever rule.
class LinkContacts {
 public:
  /// Call when the topology is new.
  void rebuild(const Mechanism& mechanism, const World& world);

  bool any() const { return !links_.empty(); }

  /// Moves links out to the surfaces, and against their sliding since the positions of `before`, as
  /// far as Coulomb's law lets the depth.
  void move_out(const Mechanism& mechanism, double time, double dt,
                const std::vector<double>& before, std::vector<double>& state);
  /// After move_out(), with the velocities that positions made: throws links back with the
  /// obstacle's restitution of the speed that they came with, in `before`.
  void rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
               std::vector<double>& state);

  /// Moves links out, stops their velocities into the surfaces or throws them back, and slows their
  /// sliding by at most the coefficient of friction times that change.
  void stop(const Mechanism& mechanism, double time, double dt, std::vector<double>& state);

 private:
  struct Link {
    std::size_t first = 0;  // point; the other is the next
    double radius = 0;      // m
    std::uint64_t category = 0;
  };
  struct Met {
    std::size_t first = 0, obstacle = 0;
    double share = 0;  // of the way from the first end to the other
    Vec3 normal = Vec3::UnitY(), surface = Vec3::Zero();  // m/s, of the obstacle there
    double depth = 0;                                     // m
  };
  void find(const Mechanism& mechanism, double time, const std::vector<double>& state);

  std::vector<Obstacle> obstacles_;
  std::vector<Link> links_;
  std::vector<Met> met_;
};

}  // namespace taut::contact
