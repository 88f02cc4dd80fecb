// The forces in a state of a world: of links, of holds and of contacts.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "sim/world/world.h"

namespace taut {

/// The forces in one state of a world, in newtons and the world's axes.
struct Forces {
  double time = 0;  // s

  struct Link {
    std::size_t connector = 0, link = 0;
    double tension = 0;              // N; negative where the link pushes
    Vec3 place = Vec3::Zero();       // m, its middle
    Vec3 direction = Vec3::UnitY();  // from its first particle to its second
  };
  std::vector<Link> links = {};  // connector by connector

  struct Hold {
    std::size_t connector = 0, particle = 0;
    Vec3 place = Vec3::Zero();   // m
    Vec3 force = Vec3::Zero();   // on the particle, of whatever holds it
    Vec3 moment = Vec3::Zero();  // N m, on the connector, where it is clamped
  };
  std::vector<Hold> holds = {};  // connector by connector

  /// A side of a contact.
  struct Side {
    enum class Kind { particle, link, body, obstacle };
    Kind kind = Kind::particle;
    std::size_t index = 0;  // of the connector, the body or the obstacle
    std::size_t at = 0;     // of the particle or the link on the connector
  };
  struct Contact {
    Side one = {}, other = {};
    Vec3 place = Vec3::Zero();    // m, on the surface of `other`
    Vec3 normal = Vec3::UnitY();  // out of `other`
    Vec3 force = Vec3::Zero();    // on `one`: pressure along the normal, friction across it
  };
  std::vector<Contact> contacts = {};
};

/// The forces that the laws of the scene give in the world's state, whichever method led there, to
/// about a millionth where nothing slides. Rigid links count as long as they are, and velocities
/// that would change their lengths as the nearest that do not. Surfaces nearer than 1e-5 of the
/// longest connector touch. Rigid links and surfaces that share a load in more than one way, as a
/// table on four legs, share it evenly. Forces of impacts are left out.
/// Massless spans are links that only pull. Throws Diverged where none are found that are in
/// balance with weight and inertia to a ten-thousandth, as where a method has left things deep in
/// each other, or masses are 1e12 times as large as others. Cost: a few steps of the method
/// `direct` with contact.
Forces forces_of(const World& world);

/// The name of a connector, body or obstacle, and its part: a particle (3), a link (3-4), or none.
struct Named {
  std::string name, part;
};
Named named(const World& world, const Forces::Link& of);
Named named(const World& world, const Forces::Hold& of);
Named named(const World& world, const Forces::Side& of);

}  // namespace taut
