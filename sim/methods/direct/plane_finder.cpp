#include "sim/methods/direct/plane_finder.h"

#include <cmath>

namespace taut::direct {
namespace {

/// A centre of mass this near (in radii of gyration) to the point that a body hangs by is at it.
constexpr double kLeastArm = 1e-6;

struct Hanging {  // a body that only one span holds, by one point
  Vec3 arm;       // m, from that point to the centre of mass, in the world's axes
  bool alone = false;
};

Hanging hanging(const World& world, const Component& component, std::size_t body) {
  Hanging found{Vec3::Zero()};
  int ends = 0;
  for (const SpanRange& span : component.spans) {
    const Connector& connector = world.connectors[span.connector];
    for (const std::size_t particle : {span.first, span.last}) {
      const Hold* hold = hold_at(connector, particle);
      if (!hold || hold->to.kind != Attachment::Kind::body || hold->to.body != body) continue;
      ++ends;
      found.arm = world.bodies[body].position - world.bodies[body].point(hold->to.point);
    }
  }
  found.alone = ends == 1;
  return found;
}

}  // namespace

std::optional<Plane> PlaneFinder::find(const World& world, const Component& component, double time,
                                       const Vec3& also) {
  std::vector<Vec3>&vectors = vectors_, &hints = hints_;
  std::size_t links = 0;
  for (const SpanRange& span : component.spans) links += span.last - span.first;
  reserve(links);
  vectors.assign({world.gravity, also});
  hints.clear();
  for (const SpanRange& span : component.spans) {
    const Connector& connector = world.connectors[span.connector];
    for (std::size_t k = span.first; k < span.last; ++k) {
      vectors.push_back(connector.position[k + 1] - connector.position[k]);
      const Vec3 velocity = connector.velocity[k + 1] - connector.velocity[k];
      if (!velocity.isZero(0)) vectors.push_back(velocity);
    }
    for (const std::size_t particle : {span.first, span.last}) {
      const Hold* hold = hold_at(connector, particle);
      if (!hold || !is_prescribed(world, hold->to)) continue;
      vectors.push_back(hold_motion(world, hold->to, time).acceleration);
      const Attachment& to = hold->to;
      const Path* path = to.kind == Attachment::Kind::path   ? to.path.get()
                         : to.kind == Attachment::Kind::body ? world.bodies[to.body].path.get()
                                                             : nullptr;
      if (!path) continue;
      for (const PathKey& key : path->keys()) {
        hints.push_back(key.position - path->keys().front().position);
      }
    }
  }
  for (const std::size_t b : component.bodies) {
    const Hanging body = hanging(world, component, b);
    const MassProperties& m = world.bodies[b].mass_properties;
    const double radius = std::sqrt(m.inertia.trace() / (2 * m.mass));
    if (!body.alone || !(body.arm.norm() > kLeastArm * radius)) return std::nullopt;
    vectors.push_back(body.arm);
  }
  const std::optional<Plane> plane = common_plane(vectors, hints);
  if (!plane) return std::nullopt;
  for (const std::size_t b : component.bodies) {  // they must turn about the normal, and only so
    const Body& body = world.bodies[b];
    const Mat3 inertia = body.world_inertia();
    const Vec3 twist = inertia * plane->normal;
    const bool principal =
        (twist - twist.dot(plane->normal) * plane->normal).norm() <= 1e-11 * inertia.norm();
    const bool spins = body.spin.cross(plane->normal).norm() > 1e-11 * body.spin.norm();
    if (!principal || spins) return std::nullopt;
  }
  return plane;
}

}  // namespace taut::direct
