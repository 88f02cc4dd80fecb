#include "sim/contact/penetration.h"

#include "sim/contact/capsule.h"
#include "sim/motion/larger.h"
#include "sim/world/places.h"

namespace taut::contact {

double penetration_max(const World& world) {
  double most = 0;
  for (const Obstacle& obstacle : world.obstacles) {
    const Pose frame = obstacle.frame(world.time).pose();
    for (const Connector& connector : world.connectors) {
      if (!obstacle.touches(connector.category)) continue;
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        if (holds(connector, i)) continue;
        const Vec3& at = connector.position[i];
        most = larger(most, -gap(obstacle, frame, at, connector.radius).distance);
      }
    }
    for (const Body& body : world.bodies) {
      const BodyCapsule& own = body.capsule;
      if (body.driven() || !own.touches() || !obstacle.touches(own.category)) continue;
      const Capsule capsule{body.point(own.from), body.point(own.to), own.radius};
      most = larger(most, -least_gap(obstacle.shape, frame, capsule));
    }
  }
  return most;
}

}  // namespace taut::contact
