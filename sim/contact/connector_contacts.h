// Contact of connectors as games do it: beads, and links where they touch, inside of obstacles are
// moved out, and rubbed; links inside of each other are moved apart.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/links/mechanism.h"
#include "sim/world/world.h"

namespace taut::contact {

/// For methods of fixed steps on a Mechanism, after the step. Contact is found where the step ends:
/// what passes through an obstacle within a step is not stopped. What a link gets between its beads
/// goes to both by the lever rule.
class ConnectorContacts {
 public:
  /// Call when the topology is new.
  void rebuild(const Mechanism& mechanism, const World& world);

  bool any() const { return !obstacles_.empty() || near_.any(); }

  /// Moves beads and links out to the surfaces, and against their sliding since the positions of
  /// `before`, as far as Coulomb's law lets the depth (Mueller et al. 2020, section 3.5).
  void move_out(const Mechanism& mechanism, double time, double dt,
                const std::vector<double>& before, std::vector<double>& state);
  /// After move_out(), with the velocities that positions made: throws them back with the
  /// obstacle's restitution of the speed that they came with, in `before`.
  void rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
               std::vector<double>& state);

  /// Moves them out, stops their velocities into the surfaces or throws them back, and slows their
  /// sliding by at most the coefficient of friction times that change.
  void stop(const Mechanism& mechanism, double time, double dt, std::vector<double>& state);

 private:
  struct Link {
    std::size_t first = 0, last = 0;  // points
    double radius = 0;                // m
    std::uint64_t category = 0;
  };
  struct Met {
    std::size_t point = 0, next = 0, obstacle = 0;
    double share = 0;  // of the way to the next point; zero: the bead itself
    Vec3 normal = Vec3::UnitY();
    Vec3 surface = Vec3::Zero();  // m/s, of the obstacle there, past what flows along the rope
    double depth = 0;             // m
  };
  /// Two links that are inside of each other, at the points where they are nearest.
  struct Crossed {
    LinkPair links;  // first points
    NearestShares shares;
    Vec3 normal = Vec3::UnitY();  // out of the second
    Vec3 flow = Vec3::Zero();     // m/s, of what winches move past the first, past the other
    double thick = 0;             // m, both radii
  };
  void find(const Mechanism& mechanism, double time, const std::vector<double>& state);
  void find_crossed(const Mechanism& mechanism, double dt, const std::vector<double>& before,
                    const std::vector<double>& state);
  void find_links(const Mechanism& mechanism, std::size_t obstacle, const FrameMotion& frame,
                  const std::vector<double>& state);

  std::vector<Obstacle> obstacles_;
  std::vector<double> radius_;           // m, per point; negative: it touches nothing
  std::vector<std::uint64_t> category_;  // per point
  std::vector<Link> links_;              // that touch
  std::vector<Met> met_;                 // beads and links by obstacle
  NearLinks near_;
  std::vector<ConnectorPair> rules_;
  std::vector<double> thickness_;       // m, per point: of its connector
  std::vector<std::uint32_t> leaders_;  // per point
  std::vector<LinkPair> pairs_;
  std::vector<Crossed> crossed_;
};

}  // namespace taut::contact
