// Connectors whose length changes: a winch at an end pays rope out or takes it in; pulleys that
// rope passes.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "sim/motion/path.h"

namespace taut {

// Where rope passes from one connector into another.

/// An eye or a sheave without size: the rope of the connector `from` leaves it at its last end and
/// enters `to` at its first. Both ends are held at one place (README.md).
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
/// particles (README.md). Never changes; everything that depends on time is a function of it.
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

}  // namespace taut
