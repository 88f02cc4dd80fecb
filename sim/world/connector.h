// A connector: particles joined by links, held at its ends and at pins; the winches at its ends,
// and the pulleys that its rope passes.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "sim/motion/path.h"
#include "sim/motion/types.h"

namespace taut {

// Winches pay rope out or take it in at an end; at a pulley rope passes from one connector into
// another (sim/winch/README.md).

/// An eye or a sheave without size: the rope of the connector `from` leaves it at its last end and
/// enters `to` at its first. Both ends are held at one place.
struct Pulley {
  std::string name;
  std::size_t from = 0, to = 0;  // connectors
  double inertia = 0;            // kg: of a sheave about its axle, over the square of its radius
  double friction = 0;           // Coulomb's, of the rope on an eye
  double bearing = 0;  // Coulomb's, of a sheave's axle, times its radius over the sheave's
  bool has_friction() const { return friction > 0 || bearing > 0; }
  // The state.
  double passed = 0;  // m, since the start
  double speed = 0;   // m/s
};

/// The length paid out by a winch since the start, and its derivatives: m, m/s, m/s^2.
struct PaidOut {
  double length = 0, rate = 0, acceleration = 0;

  PaidOut operator+(const PaidOut& other) const {
    return {length + other.length, rate + other.rate, acceleration + other.acceleration};
  }
};

/// The action of winches on a connector: links share the length paid out, and material flows past
/// particles. Never changes; everything that depends on time is a function of it.
struct Winch {
  /// The paths whose x, in m, is the length paid out at the first and last particle. Null: none.
  std::array<std::shared_ptr<const Path>, 2> paths;
  /// Of each particle: the share of the length paid out in the links before it, from 0 to 1.
  std::vector<double> before;
  double density = 0;  // kg/m, of what is paid out
  // Where nothing is paid out.
  double length = 0;                  // m
  double mass = 0;                    // kg
  std::vector<double> rest;           // m, of each link
  std::vector<double> particle_mass;  // kg

  PaidOut paid_out(std::size_t end, double time) const;
  /// Of both ends together: by how much the connector is longer than at the start.
  PaidOut longer(double time) const { return paid_out(0, time) + paid_out(1, time); }
  /// Of a link: the share of what is paid out that it has.
  double share(std::size_t link) const { return before[link + 1] - before[link]; }
  /// How much longer the links beside a particle are, half of each: its part of what is paid out.
  double share_at(std::size_t particle) const;

  /// How fast the material flows past a particle towards the last one, m/s, and its rate, m/s^2,
  /// where the ends have paid out so much.
  struct Flow {
    double speed = 0, rate = 0;
  };
  Flow flow(std::size_t particle, const PaidOut& first, const PaidOut& last) const;

  /// The least that longer() ever is from the first key until the last, m.
  double least() const;
  /// Whether the winches stand still throughout.
  bool rests() const;
};

/// The target of a hold on a particle: a fixed point, a path, or a point of a rigid body.
struct Attachment {
  enum class Kind { fixed, path, body };
  Kind kind = Kind::fixed;
  Vec3 point = Vec3::Zero();         // m: in space, in the path's frame or in the body's frame
  std::shared_ptr<const Path> path;  // Kind::path
  std::size_t body = 0;              // Kind::body: index into World::bodies

  /// While a particle is being drawn there: it is `lag` away at `since` and there, at rest beside
  /// it, at `arrival`. Not on free bodies.
  struct Approach {
    Vec3 lag = Vec3::Zero();        // m, world axes
    double since = 0, arrival = 0;  // s
  };
  Approach approach = {};
};

/// The memory of a hold that is a pin, so that its release leaves no trace.
struct PinRecord {
  std::uint64_t number = 0;    // from 1; 0: no pin but an end of the connector
  double fraction = 0;         // where on its link a particle was added for it; 0: none was
  double link_rest = 0;        // m, of that link
  double since = 0;            // s
  std::uint64_t topology = 0;  // of the world, once pinned
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();            // of the particle, before
  Vec3 body_position = Vec3::Zero(), body_velocity = Vec3::Zero();  // of a free body, before
  Vec3 body_spin = Vec3::Zero();
};

/// The section of a link that stretches or bends; sim/material has the equations.
struct Section {
  double axial_stiffness = std::numeric_limits<double>::infinity();  // EA, N; infinite: rigid
  double axial_damping = 0;      // N s: tension per rate of strain
  double bending_stiffness = 0;  // EI, N m^2
  double bending_damping = 0;    // N m^2 s: moment per rate of curvature
  /// 1/m: how it is curved at rest, about which axis. Of motions in the plane across that axis.
  Vec3 rest_curvature = Vec3::Zero();
  double twisting_stiffness = 0;  // GJ, N m^2
  double twisting_damping = 0;    // N m^2 s: moment per rate of twist
  double rest_twist = 0;          // rad/m
  double diameter = 0;            // m, that the air meets
};

/// Coefficients of the air's drag, for flow across and along a link.
struct Drag {
  double across = 0, along = 0;
};

/// A particle that is held. A connector's ends are holds on its first and last particle; a pin is a
/// hold on any particle. A free end or a point-mass end is no hold at all: its particle just moves
/// (with the point mass added to its own).
struct Hold {
  std::size_t particle = 0;
  Attachment to;
  PinRecord pin = {};
  /// Where a connector that resists bending is clamped: its direction there, from its first
  /// particle to its last, in the frame of `to` (the world's for a fixed point). Zero: hinged.
  Vec3 clamp = Vec3::Zero();
  /// The turn of a clamp about that direction, beside its frame: the x of the path, in rad, and not
  /// m. Null: none.
  std::shared_ptr<const Path> turn = nullptr;
};

/// How far the last clamp of a connector is turned against the first, as carried along its links
/// without turning about them, Hold::turn aside (sim/world/twist.h).
struct EndTurn {
  double start = 0;  // rad, from -pi to pi: where the connector is not twisted; set by finish()
  double since = 0;  // rad: what has come to it, over any number of turns; a part of the state
};

/// The user's own force on a connector: adds to `force` (N, per particle) what acts at `time` (s)
/// on particles at `position` (m) that move at `velocity` (m/s). Pins add particles and cuts divide
/// them. It depends on these arguments alone: methods call it as often as they need, in any order,
/// and for states that they drop.
using AppliedForce =
    std::function<void(double time, const std::vector<Vec3>& position,
                       const std::vector<Vec3>& velocity, std::vector<Vec3>& force)>;

enum class ConnectorModel {
  links,  // rigid two-sided links, particles with mass
  span,   // massless: nothing acts until the span is taut, then an impulse
};

/// A rope, chain or cord of n particles and n-1 links. All arrays are contiguous and indexed by
/// particle (n) or link (n-1).
struct Connector {
  std::string name;
  double length = 0;       // m, the sum of `rest`
  double mass = 0;         // kg, of all particles, ends included; without point masses at the ends
  double restitution = 0;  // coefficient of restitution when the span goes taut, 0 to 1
  double radius = 0;       // m, of the beads that touch obstacles: each particle is one
  std::uint64_t category = 0;  // bits, of which an obstacle may ignore some
  bool links_touch = false;    // the links touch obstacles, too, as capsules of that radius
  ConnectorModel model = ConnectorModel::links;
  /// The links are strings, which may be shorter than `rest` and never push (sim/contact). Such a
  /// connector is a model of links, has no sections and no joint.
  bool pulls = false;
  /// Ends with the same number were at one place at the start, or were cut from each other; 0: not
  /// known. Set by finish() and cuts.
  std::array<std::uint32_t, 2> end_place = {0, 0};
  std::vector<Hold> holds;  // sorted by particle; at most one per particle

  std::vector<double> rest;           // m, rest length of each link
  std::vector<double> particle_mass;  // kg, point masses of ends included; also for held particles
  std::vector<Vec3> position;         // m
  std::vector<Vec3> velocity;         // m/s

  std::vector<Section> sections;  // of each link; none: rigid links that bend freely, without air
  Drag drag;                      // with `sections` alone
  EndTurn end_turn;               // of one that is clamped at both ends and resists twist

  std::shared_ptr<const AppliedForce> applied_force;  // null: none
  /// N. A Simulation cuts the connector in the middle of the first link whose tension is above it.
  double breaks_at = std::numeric_limits<double>::infinity();

  /// At its ends, as are pulleys (World::pulleys); null: neither. Lengths, rests and masses are
  /// then those of World::time.
  std::shared_ptr<const Winch> winch;

  std::size_t particles() const { return position.size(); }
  std::size_t links() const { return rest.size(); }
  /// Links stretch: all of a connector's do, or none.
  bool stretches() const {
    return !sections.empty() && std::isfinite(sections.front().axial_stiffness);
  }
};

/// Two connectors whose links touch each other as capsules (Connector::radius), or, with `a` and
/// `b` the same, a connector that touches itself; others pass through. Links that are nearer along
/// rope than half a circle of the radius do not touch (sim/contact/near_links.h).
struct ConnectorPair {
  std::size_t a = 0, b = 0;                          // of World::connectors
  double static_friction = 0, kinetic_friction = 0;  // Coulomb's coefficients
  double restitution = 0;                            // Newton's coefficient, 0 to 1
};

/// A connector of `particles` equal particles in a straight line from `start` along `direction`,
/// at rest. Throws std::invalid_argument for particles < 2, negative mass or length.
Connector straight_connector(std::string name, double length, double mass, std::size_t particles,
                             const Vec3& start, const Vec3& direction);

/// Takes the mass of equal particles to the links, half of each at either end; point masses stay.
void weigh_by_links(Connector& connector);

/// The particles that hang as a catenary of equal links between `from` and `to` (both ends held, at
/// most the connector's length apart); the equilibrium of the discrete chain. Throws
/// std::invalid_argument where there is none.
std::vector<Vec3> hanging_points(const Connector& connector, const Vec3& from, const Vec3& to,
                                 const Vec3& gravity);

}  // namespace taut
