// Bodies that hang by one point, simulated as links.
#pragma once

#include <string>
#include <vector>

#include "sim/interventions/timeline.h"
#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut {

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
