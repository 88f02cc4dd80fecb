// Smaller worlds that stand for another: fewer particles, less physics, bodies as links.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut {

/// Gives the particles of `world`'s connectors the masses of `exact`'s, which must have the same
/// connectors: each particle's mass goes to the two particles on either side of its place along the
/// coarser chain, in the proportion that keeps the centre of mass. So a chain of h-long links
/// differs from the exact one by O(h^2), where equal masses differ by O(h). What has no mass there
/// gets none.
void take_masses(World& world, const World& exact);

// Worlds with less physics that stand for another.

/// Physics beyond rigid links that bend freely in a vacuum.
enum class Physics { air, twist, bending, stretch };

/// "air", "twist", "bending", "stretch".
std::string_view name_of(Physics physics);
std::vector<std::string_view> names_of(std::span<const Physics> physics);
std::optional<Physics> physics_named(std::string_view name);

/// The physics that some connector of the world has, what is least likely to matter first.
std::vector<Physics> physics_of(const World& world);

/// Takes some physics from all connectors; without bending clamps are hinges, and nothing twists.
/// The world is consistent afterwards. Throws like finish().
void neglect(World& world, std::span<const Physics> physics);

// Bodies that hang by one point, simulated as links.

/// Why the body cannot be a link, or empty: it has to be free, and to hang by one of its points,
/// which is not its centre of mass, at an end of a connector of links that nothing pins or cuts,
/// and to touch no other body.
std::string why_no_link(const World& world, const Timeline& timeline, std::size_t body);

/// Puts a link (see Stick) in the place of every body of a world whose model says so, and says
/// where the bodies are while the links move. A link knows no turn about itself: the body turns as
/// its line does, without twist.
class BodiesAsLinks {
 public:
  /// Changes `world`, for none of whose bodies with such a model why_no_link() has a reason. They
  /// stay in the list, so that indices do, and are at rest.
  explicit BodiesAsLinks(World& world);

  /// Follows the links to where they are now.
  void follow(const World& world);
  /// How the bodies are turned, and the same from a state that was saved: as many.
  std::vector<Quat> rotations() const;
  void turn(const std::vector<Quat>& rotations);
  /// Takes the links out of a state of the changed world, and moves the bodies there.
  void show(Snapshot& state) const;

 private:
  struct Link {
    std::size_t body = 0, connector = 0;
    bool first = false;                // the connector's first link, else its last
    Vec3 point = Vec3::Zero();         // m, where it hangs, body frame
    Vec3 along = Vec3::UnitY();        // of the line, from there through the centre of mass
    Quat rotation = Quat::Identity();  // as it was last followed to
  };
  std::vector<Link> links_;
};

}  // namespace taut
