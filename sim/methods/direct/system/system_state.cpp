// The state of a system: to and from the world.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/system/system.h"
#include "sim/motion/rotation.h"

namespace taut::direct {
namespace {

void put(double* c, const Quat& q) {
  c[0] = q.w(), c[1] = q.x(), c[2] = q.y(), c[3] = q.z();
}

}  // namespace

void System::load(const World& world, double time, double* q, double* rate) {
  attach(world);
  left_plane_.reset();
  loaded_at_ = time;
  std::fill_n(q, size(), 0.0);
  std::fill_n(rate, size(), 0.0);
  const auto set = [&](std::size_t link, const Vec3& u, const Vec3& turn) {
    links_.point(link, u, turn - u.dot(turn) * u, q, rate);
  };
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    Vec3 u = world.gravity.norm() > 0 ? world.gravity.normalized()
             : plane_                 ? plane_->x
                                      : Vec3::UnitX();
    const std::size_t offset = span.offset + (span.first_body_link != kNone ? 1 : 0);
    for (std::size_t k = 0; k + 1 < span.particles(); ++k) {
      const std::size_t i = offset + k, a = span.particle(k), b = span.particle(k + 1);
      const Vec3 gap = connector.position[b] - connector.position[a];
      // Particles that coincide say nothing of the link between them: it goes on like the last.
      if (gap.norm() > 1e-9 * links_.rest(i)) u = gap.normalized();
      set(i, u, links_.inverse_rest(i) * (connector.velocity[b] - connector.velocity[a]));
    }
    for (const std::size_t b : {span.first_body_link, span.last_body_link}) {
      if (b == kNone) continue;
      BodyLink& body_link = body_links_[b];
      const Body& body = world.bodies[body_link.body];
      const std::size_t tip = span.particle(body_link.outward < 0 ? 0 : span.particles() - 1);
      body_link.direction = (body.position - connector.position[tip]).normalized();
      body_link.rotation = body.rotation;
      set(body_link.link, body_link.outward * body_link.direction,
          body_link.outward * body.spin.cross(body_link.direction));
    }
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Body& body = world.bodies[bodies_[b].body];
    put(q + quaternion(b), body.rotation);
    put(rate + quaternion(b), quaternion_rate(body.spin, body.rotation));
  }
  if (!floats_) return;

  centre_ = {};
  for (const std::size_t b : members_) {
    const Body& body = world.bodies[b];
    centre_.position += body.mass_properties.mass / mass_ * body.position;
    centre_.velocity += body.mass_properties.mass / mass_ * body.velocity;
  }
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    for (std::size_t k = 0; k < span.particles(); ++k) {
      const std::size_t particle = span.particle(k);
      if (find_hold(connector, particle)) continue;
      centre_.position += connector.particle_mass[particle] / mass_ * connector.position[particle];
      centre_.velocity += connector.particle_mass[particle] / mass_ * connector.velocity[particle];
    }
  }
  place(time, q, rate);
  spin_momentum_ = rotary(time).momentum;
}

std::size_t System::first_link(std::size_t connector) const {
  const auto found = std::ranges::find_if(
      spans_, [&](const Span& span) { return span.range.connector == connector; });
  return found->offset;
}

Point System::start_of(const Span& span, double time) const {
  if (span.first == kNone) return {};
  const End& end = ends_[span.first];
  if (end.body == kNone) {
    const PointMotion motion = hold_motion(*world_, end.to, time);
    return {motion.position, motion.velocity};
  }
  return {centres_[end.body].position + end.arm,
          centres_[end.body].velocity + bodies_[end.body].spin.cross(end.arm)};
}

/// Fills points_, centres_ and body_link_centres_: everything's place and velocity at `time`.
void System::place(double time, const double* q, const double* rate) {
  turn_bodies(q, rate);
  if (floats_ && !bodies_.empty()) centres_[0] = {};
  std::size_t p = 0;
  for (const Span& span : spans_) {
    points_[p] = start_of(span, time);
    links_.lay(q, rate, span.offset, span.links, points_[p], &points_[p + 1]);
    p += span.links + 1;
    const Point& point = points_[p - 1];
    if (!span.closes && span.last != kNone) {  // the body hangs from here
      const End& end = ends_[span.last];
      centres_[end.body] = {point.position - end.arm,
                            point.velocity - bodies_[end.body].spin.cross(end.arm)};
    }
  }
  if (floats_) float_to(time);
  place_bars(q, rate);
}

void System::place_bars(const double* q, const double* rate) {
  std::size_t p = 0;
  for (const Span& span : spans_) {
    for (const std::size_t b : {span.first_body_link, span.last_body_link}) {
      if (b == kNone) continue;
      const BodyLink& body_link = body_links_[b];
      const Point& tip = points_[p + (body_link.outward < 0 ? 1 : span.links - 1)];
      const double offset = body_link.outward * body_link.arm;
      body_link_centres_[b] = {tip.position + offset * links_.direction(q, body_link.link),
                               tip.velocity + offset * links_.turn(q, rate, body_link.link)};
    }
    p += span.links + 1;
  }
}

Point System::centre(double time) const {
  const double t = time - loaded_at_;
  return {centre_.position + t * centre_.velocity + t * t / 2 * world_->gravity,
          centre_.velocity + t * world_->gravity};
}

/// Shifts everything so that the centre of mass is on its parabola.
void System::float_to(double time) {
  Point sum;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    sum.position += bodies_[b].mass * centres_[b].position;
    sum.velocity += bodies_[b].mass * centres_[b].velocity;
  }
  for (std::size_t k = 0; k < points_.size(); ++k) {
    sum.position += point_mass_[k] * points_[k].position;
    sum.velocity += point_mass_[k] * points_[k].velocity;
  }
  const Point goal = centre(time);
  const Vec3 shift = goal.position - sum.position / mass_;
  const Vec3 push = goal.velocity - sum.velocity / mass_;
  for (Point& point : points_) point = {point.position + shift, point.velocity + push};
  for (Point& point : centres_) point = {point.position + shift, point.velocity + push};
}

void System::store(World& world, const double* q, const double* rate) {
  attach(world);
  place(world.time, q, rate);
  std::size_t p = 0;
  for (const Span& span : spans_) {
    Connector& connector = world.connectors[span.range.connector];
    const std::size_t first = p + (span.first_body_link != kNone ? 1 : 0);
    // Prescribed particles have been placed; links lead there but for rounding.
    const auto is_placed = [&](std::size_t end) {
      return end != kNone && ends_[end].body == kNone;
    };
    const std::size_t begin = is_placed(span.first) ? 1 : 0;
    const std::size_t end = span.particles() - (is_placed(span.last) ? 1 : 0);
    for (std::size_t k = begin; k < end; ++k) {
      connector.position[span.particle(k)] = points_[first + k].position;
      connector.velocity[span.particle(k)] = points_[first + k].velocity;
    }
    p += span.links + 1;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Body& body = world.bodies[bodies_[b].body];
    const double* r = q + quaternion(b);
    body.position = centres_[b].position;
    body.velocity = centres_[b].velocity;
    body.rotation = Quat(r[0], r[1], r[2], r[3]);
    body.spin = bodies_[b].spin;
  }
  for (std::size_t b = 0; b < body_links_.size(); ++b) {
    const BodyLink& body_link = body_links_[b];
    Body& body = world.bodies[body_link.body];
    const Vec3 now = body_link.outward * links_.direction(q, body_link.link);
    const double angle = std::atan2(body_link.direction.cross(now).dot(plane_->normal),
                                    body_link.direction.dot(now));
    body.position = body_link_centres_[b].position;
    body.velocity = body_link_centres_[b].velocity;
    body.rotation = Quat(Eigen::AngleAxisd(angle, plane_->normal)) * body_link.rotation;
    body.spin = now.cross(body_link.outward * links_.turn(q, rate, body_link.link));
  }
}

}  // namespace taut::direct
