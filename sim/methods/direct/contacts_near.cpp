// What may touch something soon.
#include <algorithm>

#include "sim/methods/direct/contacts.h"

namespace taut::direct {
namespace {

constexpr double kSurprise = 2;  // by how much speeds may rise until the next check

}  // namespace

/// Whether a body may touch something within so many seconds of the part's present time.
bool Contacts::is_body_near(const Body& body, const World& part, double within) const {
  if (body.driven() || !body.capsule.touches()) return false;
  const double fall = part.gravity.norm() * within;
  const contact::Capsule own{body.point(body.capsule.from), body.point(body.capsule.to),
                             body.capsule.radius};
  const double radius =
      std::max((own.from - body.position).norm(), (own.to - body.position).norm()) + own.radius;
  for (const Obstacle& obstacle : obstacles_) {
    if (!obstacle.touches(body.capsule.category)) continue;
    const FrameMotion frame = obstacle.frame(part.time);
    const double apart = contact::least_gap(obstacle.shape, frame.pose(), own);
    const double far = (body.position - frame.position).norm() + radius + std::max(apart, 0.0);
    const double speed = (body.velocity - frame.velocity).norm() + body.spin.norm() * radius +
                         frame.spin.norm() * far + fall;
    if (apart <= kSurprise * speed * within) return true;
  }
  return false;
}

/// Whether two bodies may touch within so many seconds of the part's present time.
bool Contacts::is_pair_near(const BodyPair& pair, const World& part, double within) {
  const Body &a = part.bodies[pair.a], &b = part.bodies[pair.b];
  const auto axis = [](const Body& body) {
    return contact::Capsule{body.point(body.capsule.from), body.point(body.capsule.to),
                            body.capsule.radius};
  };
  const contact::Capsule own = axis(a), other = axis(b);
  const auto radius = [](const Body& body, const contact::Capsule& of) {
    return std::max((of.from - body.position).norm(), (of.to - body.position).norm()) + of.radius;
  };
  const double fall = part.gravity.norm() * within;
  const double speed = (a.velocity - b.velocity).norm() + a.spin.norm() * radius(a, own) +
                       b.spin.norm() * radius(b, other) + fall;
  return contact::least_gap(other, own) <= kSurprise * speed * within;
}

/// Whether a bead may touch a body within so many seconds of the part's present time.
bool Contacts::is_pair_near(const BeadPair& pair, const World& part, double within) {
  const Body& body = part.bodies[pair.body];
  const Connector& connector = part.connectors[pair.connector];
  const contact::Capsule solid{body.point(body.capsule.from), body.point(body.capsule.to),
                               body.capsule.radius};
  const double reach =
      std::max((solid.from - body.position).norm(), (solid.to - body.position).norm()) +
      solid.radius;
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    const Vec3& at = connector.position[i];
    const double speed = (connector.velocity[i] - body.velocity).norm() + body.spin.norm() * reach +
                         part.gravity.norm() * within;
    const double near = kSurprise * speed * within;
    if ((at - body.position).norm() > reach + connector.radius + near) continue;
    if (contact::least_gap(solid, {at, at, connector.radius}) > near) continue;
    if (!find_hold(connector, i)) return true;
  }
  return false;
}

/// Whether a link may touch an obstacle within so many seconds of the part's present time.
bool Contacts::is_link_near(const Connector& connector, const Obstacle& obstacle, const World& part,
                            double within) {
  const FrameMotion frame = obstacle.frame(part.time);
  for (std::size_t i = 0; i + 1 < connector.particles(); ++i) {
    const contact::Capsule own{connector.position[i], connector.position[i + 1], connector.radius};
    const double apart = contact::least_gap(obstacle.shape, frame.pose(), own);
    const auto speed = [&](std::size_t bead) {
      const double far = (connector.position[bead] - frame.position).norm() + std::max(apart, 0.0);
      return (connector.velocity[bead] - frame.velocity).norm() + frame.spin.norm() * far;
    };
    const double most = std::max(speed(i), speed(i + 1)) + part.gravity.norm() * within;
    if (apart <= kSurprise * most * within) return true;
  }
  return false;
}

/// Whether something of the group may touch something within so many seconds from there.
bool Contacts::is_near(const Group& group, const World& part, double within) const {
  const double fall = part.gravity.norm() * within;
  for (const Body& body : part.bodies) {
    if (is_body_near(body, part, within)) return true;
  }
  for (const BodyPair& pair : group.pairs) {
    if (is_pair_near(pair, part, within)) return true;
  }
  for (const BeadPair& pair : group.bead_pairs) {
    if (is_pair_near(pair, part, within)) return true;
  }
  for (const Obstacle& obstacle : obstacles_) {
    const FrameMotion frame = obstacle.frame(part.time);
    for (const Connector& connector : part.connectors) {
      if (!obstacle.touches(connector.category)) continue;
      if (connector.links_touch && is_link_near(connector, obstacle, part, within)) return true;
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        if (find_hold(connector, i)) continue;
        const Vec3& at = connector.position[i];
        const SurfaceDistance near = gap(obstacle, frame.pose(), at, connector.radius);
        const Vec3 surface =
            frame.velocity + frame.spin.cross(at - near.distance * near.normal - frame.position);
        const double speed = (connector.velocity[i] - surface).norm() + fall;
        if (near.distance <= kSurprise * speed * within) return true;
      }
    }
  }
  return false;
}

}  // namespace taut::direct
