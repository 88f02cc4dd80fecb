#include "sim/methods/direct/system/system.h"

#include <algorithm>
#include <cmath>

#include "sim/links/mechanism.h"
#include "sim/motion/rotation.h"

namespace taut::direct {
namespace {

/// A particle without mass, which the model has no equation for, is taken to weigh this share of
/// everything that moves with it.
constexpr double kLeastMassShare = 1e-9;

/// A link this short, as a share of all, counts as none.
constexpr double kLeastLink = 1e-6;

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
      const Hold* hold = find_hold(connector, particle);
      if (!hold || hold->to.kind != Attachment::Kind::body || hold->to.body != body) continue;
      ++ends;
      found.arm = world.bodies[body].position - world.bodies[body].point(hold->to.point);
    }
  }
  found.alone = ends == 1;
  return found;
}

Quat quat(const double* c) {
  return {c[0], c[1], c[2], c[3]};
}

void put(double* c, const Quat& q) {
  c[0] = q.w(), c[1] = q.x(), c[2] = q.y(), c[3] = q.z();
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
      const Hold* hold = find_hold(connector, particle);
      if (!hold || !is_prescribed(world, hold->to)) continue;
      vectors.push_back(hold_motion(world, hold->to, time).acceleration);
      const Attachment& to = hold->to;
      const Path* path = to.kind == Attachment::Kind::path   ? to.path.get()
                         : to.kind == Attachment::Kind::body ? world.bodies[to.body].path.get()
                                                             : nullptr;
      if (!path) continue;
      for (const PathKey& key : path->keys()) {
        hints.push_back(key.position - path->keys().front().position);
        if (!key.velocity.isZero(0)) hints.push_back(key.velocity);
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

void System::reserve(std::size_t links, std::size_t ends) {
  links_.reserve(links);
  measured_.reserve(links);
  point_mass_.reserve(links + ends);
  points_.reserve(links + ends);
  still_.reserve(3 * (links + kLanes) + 4 * ends + 2 * Links::kPad);
  spans_.reserve(ends);
  gaps_.reserve(ends);
  ends_.reserve(ends);
  body_ends_.reserve(ends);
  members_.reserve(ends);
  placed_.reserve(ends);
  done_.reserve(ends);
  body_links_.reserve(ends);
  body_link_centres_.reserve(ends);
  bodies_.reserve(ends);
  centres_.reserve(ends);
}

void System::rebuild(const World& world, const Component& component,
                     const std::optional<Plane>& plane) {
  world_ = &world;
  plane_ = plane;
  left_plane_.reset();
  members_.assign(component.bodies.begin(), component.bodies.end());
  spans_.clear();
  ends_.clear();
  body_links_.clear();
  bodies_.clear();
  mass_ = 0;
  for (const std::size_t b : component.bodies) {
    const MassProperties& m = world.bodies[b].mass_properties;
    mass_ += m.mass;
    if (plane) {
      BodyLink body_link;
      body_link.body = b;
      body_link.arm = hanging(world, component, b).arm.norm();
      body_links_.push_back(body_link);
    } else {
      Part part;
      part.body = b;
      part.mass = m.mass;
      part.inertia = m.inertia;
      part.inverse_inertia = m.inertia.inverse();
      bodies_.push_back(part);
    }
  }
  order_spans(world, component.spans);
  measure_links(world);
  couple();
  cycles_ = count_cycles();
}

std::size_t System::member(std::size_t body) const {
  return static_cast<std::size_t>(std::ranges::lower_bound(members_, body) - members_.begin());
}

void System::add_span(const World& world, const SpanRange& range, bool reversed) {
  const Connector& connector = world.connectors[range.connector];
  Span span;
  span.range = range;
  span.reversed = reversed;
  span.offset = spans_.empty() ? 0 : spans_.back().offset + spans_.back().links;
  span.links = range.last - range.first;
  const auto body_link_at = [&](std::size_t particle) {
    const Hold* hold = find_hold(connector, particle);
    return hold && !is_prescribed(world, hold->to) ? body_link_of(hold->to.body) : kNone;
  };
  span.first_body_link = body_link_at(span.particle(0));
  span.last_body_link = body_link_at(span.particle(range.last - range.first));
  if (span.first_body_link != kNone) {
    body_links_[span.first_body_link].link = span.offset;
    body_links_[span.first_body_link].outward = -1;
    ++span.links;
  }
  if (span.last_body_link != kNone) {
    body_links_[span.last_body_link].link = span.offset + span.links;
    body_links_[span.last_body_link].outward = 1;
    ++span.links;
  }
  const auto end = [&](std::size_t particle, std::size_t link, double pull) {
    const Hold* hold = find_hold(connector, particle);
    if (!hold || body_link_at(particle) != kNone) return kNone;
    End made;
    made.link = link;
    made.pull = pull;
    made.to = hold->to;
    if (!is_prescribed(world, hold->to)) {
      made.body = part_of(hold->to.body);
      made.local_arm = hold->to.point - world.bodies[hold->to.body].mass_properties.centre;
      ++bodies_[made.body].ends;
    }
    ends_.push_back(made);
    return ends_.size() - 1;
  };
  span.first = end(span.particle(0), span.offset, 1);
  span.last = end(span.particle(range.last - range.first), span.offset + span.links - 1, -1);
  spans_.push_back(span);
}

/// Walks from the prescribed holds (or, where there are none, from a body or a free end) along the
/// spans, so that each span starts where one before it ended.
void System::order_spans(const World& world, std::span<const SpanRange> ranges) {
  std::vector<char>&placed = placed_, &done = done_;
  placed.assign(bodies_.size(), 0);
  done.assign(ranges.size(), 0);
  enum class Place { free, known, unknown };
  const auto place = [&](const SpanRange& range, std::size_t particle) {
    const Hold* hold = find_hold(world.connectors[range.connector], particle);
    if (!hold) return Place::free;
    if (is_prescribed(world, hold->to)) return Place::known;
    const std::size_t body = part_of(hold->to.body);
    if (body == kNone) return Place::free;  // a link
    return placed[body] ? Place::known : Place::unknown;
  };
  const auto take = [&](std::size_t s, bool reversed) {
    const SpanRange& range = ranges[s];
    const std::size_t far = reversed ? range.first : range.last;
    const Place there = place(range, far);
    add_span(world, range, reversed);
    spans_.back().closes = there == Place::known;
    if (there == Place::unknown) placed[ends_[spans_.back().last].body] = 1;
    done[s] = 1;
  };
  const auto grow = [&] {
    for (bool more = true; more;) {
      more = false;
      for (std::size_t s = 0; s < ranges.size(); ++s) {
        if (done[s]) continue;
        const bool first = place(ranges[s], ranges[s].first) == Place::known;
        const bool last = place(ranges[s], ranges[s].last) == Place::known;
        if (!first && !last) continue;
        take(s, !first);
        more = true;
      }
    }
  };
  grow();
  floats_ = spans_.empty();
  if (!floats_) return;
  if (!bodies_.empty()) {
    placed[0] = 1;
    grow();
  } else {
    take(0, false);
  }
}

/// The length (m) of links that are so long together; where they are short beside the bodies that
/// they hold, that of these.
double System::scale_beside_bodies(const World& world, double links) const {
  constexpr double kShort = 1e-3;
  double bodies = 0;
  for (const End& end : ends_) {
    if (end.body == kNone) continue;
    const MassProperties& m = world.bodies[bodies_[end.body].body].mass_properties;
    bodies =
        std::max(bodies, std::sqrt(end.local_arm.squaredNorm() + m.inertia.trace() / (2 * m.mass)));
  }
  return links > kShort * bodies ? links : bodies;
}

void System::measure_links(const World& world) {
  std::vector<Links::Link>& links = measured_;
  links.clear();
  point_mass_.clear();
  if (!spans_.empty()) {
    const std::size_t count = spans_.back().offset + spans_.back().links;
    links.reserve(count);
    point_mass_.reserve(count + spans_.size());
  }
  length_ = 0;
  for (const Span& span : spans_) {
    const Connector& connector = world.connectors[span.range.connector];
    const auto equimomental = [&](std::size_t body_link) {
      const MassProperties& m = world.bodies[body_links_[body_link].body].mass_properties;
      const Vec3 normal =
          world.bodies[body_links_[body_link].body].rotation.conjugate() * plane_->normal;
      return EquimomentalLink(m.mass, normal.dot(m.inertia * normal), body_links_[body_link].arm);
    };
    if (span.first_body_link != kNone) {
      point_mass_.push_back(equimomental(span.first_body_link).far);
      links.push_back({.rest = equimomental(span.first_body_link).length});
    }
    for (std::size_t k = 0; k < span.particles(); ++k) {
      const bool first = k == 0, last = k + 1 == span.particles();
      double mass = connector.particle_mass[span.particle(k)];
      if ((first && span.first != kNone) || (last && span.last != kNone)) mass = 0;  // held
      if (first && span.first_body_link != kNone) mass = equimomental(span.first_body_link).tip;
      if (last && span.last_body_link != kNone) mass = equimomental(span.last_body_link).tip;
      point_mass_.push_back(mass);
      const bool body_link =
          (first && span.first_body_link != kNone) || (last && span.last_body_link != kNone);
      if (!body_link) mass_ += mass;
      if (!last) {
        links.push_back({.rest = connector.rest[std::min(span.particle(k), span.particle(k + 1))]});
      }
    }
    if (span.last_body_link != kNone) {
      point_mass_.push_back(equimomental(span.last_body_link).far);
      links.push_back({.rest = equimomental(span.last_body_link).length});
    }
  }
  std::size_t p = 0;
  for (const Span& span : spans_) {
    const double least = kLeastMassShare * (mass_ > 0 ? mass_ : 1);
    const auto inverse_mass = [&](std::size_t k) {
      const bool held = (k == 0 && span.first != kNone) || (k == span.links && span.last != kNone);
      return held ? 0 : 1 / std::max(point_mass_[p + k], least);
    };
    for (std::size_t k = 0; k < span.links; ++k) {
      Links::Link& link = links[span.offset + k];
      link.inverse_mass_first = inverse_mass(k);
      link.inverse_mass_second = inverse_mass(k + 1);
      link.shares_second = k + 1 < span.links;
      length_ += link.rest;
    }
    p += span.links + 1;
  }
  for (const End& end : ends_) {
    if (end.body != kNone) links[end.link].end += 1 / bodies_[end.body].mass;
  }
  length_ = scale_beside_bodies(world, length_);
  double scale = length_;
  for (const Part& part : bodies_) {  // of a body alone
    if (!(length_ > 0)) scale = std::max(scale, std::sqrt(part.inertia.trace() / (2 * part.mass)));
  }
  velocity_time_ = velocity_time_of(scale);
  // Pins may leave links without length; a body alone has none.
  shortest_ = links.empty() ? 1 : length_;
  for (const Links::Link& link : links) {
    if (link.rest > kLeastLink * length_) shortest_ = std::min(shortest_, link.rest);
  }
  // Cauchy's and Schwarz's inequality for the sums in displacement().
  double squares = 0;
  std::size_t count = bodies_.size();
  for (const Span& span : spans_) {
    count += span.links;
    for (std::size_t k = 0; k < span.links; ++k) {
      const double rest = links[span.offset + k].rest;
      squares += static_cast<double>(span.links - k) * rest * rest;
    }
  }
  for (const Part& part : bodies_) {
    squares = std::max(squares, 2 * part.inertia.trace() / part.mass);
  }
  displacement_factor_ = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(count, 1)));
  links_.rebuild(links, plane_);
  points_.assign(point_mass_.size(), {});
  centres_.assign(bodies_.size(), {});
  body_link_centres_.assign(body_links_.size(), {});
  loops_ = std::ranges::any_of(spans_, &Span::closes);
  gaps_.assign(spans_.size(), {});
  still_.assign(size(), 0.0);
}

void System::couple() {
  body_ends_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].first_end = body_ends_.size();
    for (std::size_t e = 0; e < ends_.size(); ++e) {
      if (ends_[e].body == b) body_ends_.push_back(e);
    }
  }
  coupled_.clear();
  couplings_.clear();
  const auto row = [&](std::size_t link) {
    const auto found = std::ranges::find(coupled_, link);
    if (found == coupled_.end()) {
      coupled_.push_back(link);
      return coupled_.size() - 1;
    }
    return static_cast<std::size_t>(found - coupled_.begin());
  };
  for (const Part& part : bodies_) {
    for (const std::size_t a : ends_of(part)) {
      for (const std::size_t b : ends_of(part)) {
        if (a != b) couplings_.push_back({a, b, row(ends_[a].link), row(ends_[b].link)});
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(coupled_.size());
  response_.resize(links_.count() * coupled_.size());
  dense_.resize(n, n);
  gain_.resize(n, n);
  dense_right_.resize(n);
}

// The state of a system: to and from the world.

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
  return found->offset + (found->first_body_link != kNone ? 1 : 0);
}

/// Where what holds an end has it.
Point System::place_of(const End& end, double time) const {
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
    points_[p] = span.first == kNone ? Point() : place_of(ends_[span.first], time);
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
    body.position = centres_[b].position;
    body.velocity = centres_[b].velocity;
    body.rotation = quat(q + quaternion(b));
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

// The tensions, and the accelerations under them.

/// How the bodies lie and spin.
void System::turn_bodies(const double* q, const double* rate) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Part& part = bodies_[b];
    const Quat rotation = quat(q + quaternion(b));
    // q' = W q / 2, W the spin as a quaternion.
    part.spin =
        2 / rotation.squaredNorm() * (quat(rate + quaternion(b)) * rotation.conjugate()).vec();
    part.rotation = rotation.normalized().toRotationMatrix();
    for (const std::size_t e : ends_of(part)) ends_[e].arm = part.rotation * ends_[e].local_arm;
  }
}

/// The bodies' accelerations without tensions, once the bodies are turned.
void System::lead_bodies() {
  for (Part& part : bodies_) {
    part.world_inverse_inertia = part.rotation * part.inverse_inertia * part.rotation.transpose();
    const Vec3 momentum = part.rotation * (part.inertia * (part.rotation.transpose() * part.spin));
    part.spin_rate = part.world_inverse_inertia * momentum.cross(part.spin);
    for (const std::size_t e : ends_of(part)) {
      End& end = ends_[e];
      end.free_acceleration =
          part.spin.cross(part.spin.cross(end.arm)) + part.spin_rate.cross(end.arm);
    }
  }
}

void System::read_holds(double time) {
  for (End& end : ends_) {
    if (end.body != kNone) continue;
    end.free_acceleration = -world_->gravity;
    if (rests(end.to, time)) continue;
    end.free_acceleration += hold_motion(*world_, end.to, time).acceleration;
    if (plane_ && !plane_->holds(end.free_acceleration)) left_plane_ = end.free_acceleration;
  }
}

/// Adds the ends to the tensions' system, whose row i is -u_i . (a_{i+1} - a_i) as far as tensions
/// cause it = l |u'|^2 + u_i . (the rest of a_{i+1} - a_i).
void System::add_ends(const double* q) {
  for (End& end : ends_) {
    end.along = links_.end_direction(q, end.link);
    links_.add_right(end.link, -end.pull * end.along.dot(end.free_acceleration));
    if (end.body == kNone) continue;
    const Part& part = bodies_[end.body];
    const Vec3 turn = end.arm.cross(end.along);
    links_.set_end(end.link, end.pull > 0,
                   1 / part.mass + turn.dot(part.world_inverse_inertia * turn));
  }
}

/// Bodies that several links hold add E Q E' to the tridiagonal A, E the columns of the unit
/// matrix for those links: T = A^-1 r - A^-1 E (1 + Q G)^-1 Q E' A^-1 r, G = E' A^-1 E (Woodbury).
/// Where links hold a body more often than it can move, the system is singular and its least
/// solution serves: which one does not matter to the motion.
void System::add_couplings() {
  const auto row = [](std::size_t k) { return static_cast<Eigen::Index>(k); };
  dense_.setZero();
  for (const Coupling& c : couplings_) {
    const End &a = ends_[c.a], &b = ends_[c.b];
    const Part& part = bodies_[a.body];
    const Vec3 &u = a.along, &v = b.along;
    dense_(row(c.row), row(c.column)) +=
        a.pull * b.pull *
        (u.dot(v) / part.mass + a.arm.cross(u).dot(part.world_inverse_inertia * b.arm.cross(v)));
  }
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    dense_right_[row(k)] = links_.tension(coupled_[k]);
  }
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    double* response = response_.data() + k * links_.count();
    links_.clear_right();
    links_.add_right(coupled_[k], 1);
    links_.respond(response);
    for (std::size_t j = 0; j < coupled_.size(); ++j) {
      gain_(row(j), row(k)) = links_.scale(coupled_[j]) * response[coupled_[j]];
    }
  }
  system_.noalias() = dense_ * gain_;
  system_.diagonal().array() += 1;
  share_.noalias() = dense_ * dense_right_;
  decomposed_.compute(system_);
  decomposed_.solve(share_, dense_right_);
  for (std::size_t k = 0; k < coupled_.size(); ++k) {
    links_.add_response(response_.data() + k * links_.count(), -dense_right_[row(k)]);
  }
}

/// The bodies' own accelerations, and what tensions add to those of their ends.
void System::move_bodies(const double* q, double* out) {
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (const std::size_t e : ends_of(part)) {
      const Vec3 pull = ends_[e].pull * links_.tension(ends_[e].link) * ends_[e].along;
      force += pull;
      torque += ends_[e].arm.cross(pull);
    }
    const Vec3 turn = part.world_inverse_inertia * torque;
    for (const std::size_t e : ends_of(part)) {
      ends_[e].free_acceleration += force / part.mass + turn.cross(ends_[e].arm);
    }
    const Vec3 rise = (part.spin_rate + turn) / 2;
    const double* p = q + quaternion(b);
    const Quat across = Quat(0, rise.x(), rise.y(), rise.z()) * quat(p);
    const double inward = part.spin.squaredNorm() / 4;
    double* a = out + quaternion(b);
    a[0] = across.w() - inward * p[0];
    a[1] = across.x() - inward * p[1];
    a[2] = across.y() - inward * p[2];
    a[3] = across.z() - inward * p[3];
  }
}

/// Solves the system and writes the accelerations that the tensions and the ends' leads cause.
void System::respond(const double* q, double* out) {
  links_.solve();
  if (!coupled_.empty()) add_couplings();
  links_.pull(q, out);
  if (!bodies_.empty()) move_bodies(q, out);
  for (const End& end : ends_) {
    links_.add(end.link, end.along,
               -end.pull * links_.inverse_rest(end.link) * end.free_acceleration, out);
  }
}

void System::clear_ends(double* array) const {
  std::fill_n(array, Links::kPad, 0.0);
  std::fill_n(array + size() - Links::kPad, Links::kPad, 0.0);
}

/// As of a chain in a plane, with a third component where it needs one; a body's matrices, and the
/// systems that several links at one body solve.
double System::count_cycles() const {
  const auto count = [](std::size_t number) { return static_cast<double>(number); };
  const double links = count(links_.count()), coupled = count(coupled_.size());
  return 450 + (plane_ ? 20 : 24) * links + 100 * count(ends_.size()) +
         200 * count(bodies_.size()) + coupled * (15 * links + 50) + coupled * coupled * coupled;
}

void System::acceleration(double time, const double* q, const double* rate, double* out) {
  if (!bodies_.empty()) {
    turn_bodies(q, rate);
    lead_bodies();
  }
  read_holds(time);
  links_.assemble(q, rate);
  add_ends(q);
  respond(q, out);
  clear_ends(out);
}

bool System::retract(const double* base, double* x, double* rate) const {
  bool inside = links_.retract(base, x, rate);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const std::size_t k = quaternion(b);
    const Eigen::Map<const Eigen::Vector4d> o(base + k);
    Eigen::Map<Eigen::Vector4d> p(x + k), r(rate + k);
    p -= o.dot(p) * o;
    r -= o.dot(r) * o;
    const double room = 1 - p.squaredNorm();
    inside &= room > 0;
    const double w = std::sqrt(std::max(room, 1e-4));
    r -= p.dot(r) / w * o;
    p += w * o;
  }
  return inside;
}

void System::to_tangent(const double* base, double* x) const {
  links_.to_tangent(base, x);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Eigen::Map<const Eigen::Vector4d> o(base + quaternion(b));
    Eigen::Map<Eigen::Vector4d> p(x + quaternion(b));
    p -= o.dot(p) * o;
  }
}

void System::factor(double sigma_squared) {
  links_.factor(sigma_squared);
  factored_sigma_ = sigma_squared;
}

void System::solve_factored(double* x) const {
  links_.solve_factored(x);
  for (std::size_t k = quaternion(0); k < quaternion(bodies_.size()); ++k) x[k] /= factored_sigma_;
}

// The state of a system back to where its constraints and its momentum have it, and how far a
// change of state moves what it is the state of.

namespace {

/// The rotation rate that gives `momentum`, least where the inertia leaves a choice (a straight
/// chain about its own line).
Vec3 spin_for(const Mat3& inertia, const Vec3& momentum) {
  const auto [moments, axes] = principal_axes(inertia);
  Vec3 spin = Vec3::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = axes.col(k);
    if (moments[k] > 1e-9 * moments[2]) spin += axis.dot(momentum) / moments[k] * axis;
  }
  return spin;
}

Mat3 point_inertia(double mass, const Vec3& r) {
  return mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
}

}  // namespace

bool System::project(double time, double* q, double* rate) {
  unit(q, rate);
  if (loops_ && !close(time, q, rate)) return false;
  if (floats_) restore_momentum(time, q, rate);
  return true;
}

void System::unit(double* q, double* rate) const {
  links_.normalise(q, rate);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    Eigen::Map<Eigen::Vector4d> p(q + quaternion(b)), r(rate + quaternion(b));
    p.normalize();
    r -= p.dot(r) * p;
  }
}

/// How far the last points of the spans that close loops are from their places, in gaps_; returns
/// the largest gap of place (m).
double System::measure_gaps(double time, const double* q, const double* rate) {
  place(time, q, rate);
  double largest = 0;
  std::size_t p = 0;
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    const Span& span = spans_[s];
    p += span.links + 1;
    if (!span.closes) continue;
    const Point goal = place_of(ends_[span.last], time);
    gaps_[s] = {goal.position - points_[p - 1].position, goal.velocity - points_[p - 1].velocity};
    largest = std::max(largest, gaps_[s].position.norm());
  }
  return largest;
}

/// Shares a gap among the links of its span, and finds what the masses do to restore the lengths:
/// impulses along the links, by the system of the tensions. Adds both to `array` (q or its rate).
void System::spread(const double* q, Vec3 Point::*gap, double* array) {
  std::fill(still_.begin(), still_.end(), 0.0);
  turn_bodies(q, still_.data());
  lead_bodies();
  for (End& end : ends_) end.free_acceleration = Vec3::Zero();
  links_.assemble(q, still_.data());
  add_ends(q);
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (!spans_[s].closes) continue;
    const Vec3 share = gaps_[s].*gap / static_cast<double>(spans_[s].links);
    for (std::size_t i = spans_[s].offset; i < spans_[s].offset + spans_[s].links; ++i) {
      links_.add_right(i, links_.direction(q, i).dot(share));
    }
  }
  respond(q, still_.data());
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (!spans_[s].closes) continue;
    const Vec3 share = gaps_[s].*gap / static_cast<double>(spans_[s].links);
    for (std::size_t i = spans_[s].offset; i < spans_[s].offset + spans_[s].links; ++i) {
      links_.add(i, links_.direction(q, i), links_.inverse_rest(i) * share, still_.data());
    }
  }
  for (std::size_t k = 0; k < size(); ++k) array[k] += still_[k];
}

/// Closes the loops that an integrator's error has opened. Each round leaves
/// the square of the gap, or a quarter of it where links are straight. False where the places are
/// out of reach, or the state too far from one whose loops are closed.
bool System::close(double time, double* q, double* rate) {
  constexpr int kRounds = 24;        // quarters of the length that leave kOpen
  constexpr double kClosed = 1e-14;  // of the system's length, roundings
  constexpr double kOpen = 1e-11;    // of it, more than roundings of any closed loop
  double gap = measure_gaps(time, q, rate);
  for (int round = 0; round < kRounds && gap > kClosed * length_; ++round) {
    spread(q, &Point::position, q);
    unit(q, rate);
    gap = measure_gaps(time, q, rate);
  }
  if (!(gap <= kOpen * length_)) return false;
  spread(q, &Point::velocity, rate);
  unit(q, rate);
  return true;
}

/// Angular momentum and inertia about the centre of mass; points_ and centres_ are up to date.
System::Rotary System::rotary(double time) const {
  const Point mean = centre(time);
  Rotary sum;
  const auto count = [&](double mass, const Point& point) {
    const Vec3 r = point.position - mean.position;
    sum.momentum += mass * r.cross(point.velocity - mean.velocity);
    sum.inertia += point_inertia(mass, r);
  };
  for (std::size_t k = 0; k < points_.size(); ++k) count(point_mass_[k], points_[k]);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    count(part.mass, centres_[b]);
    const Mat3 own = part.rotation * part.inertia * part.rotation.transpose();
    sum.momentum += own * part.spin;
    sum.inertia += own;
  }
  return sum;
}

/// Gives a floating system its angular momentum back by one rigid rotation.
void System::restore_momentum(double time, double* q, double* rate) {
  place(time, q, rate);
  const Rotary now = rotary(time);
  const Vec3 spin = spin_for(now.inertia, spin_momentum_ - now.momentum);
  for (std::size_t i = 0; i < links_.count(); ++i) {
    const Vec3 u = links_.direction(q, i);
    links_.add(i, u, spin.cross(u), rate);
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Quat turn = quaternion_rate(spin, quat(q + quaternion(b)));
    double* r = rate + quaternion(b);
    r[0] += turn.w(), r[1] += turn.x(), r[2] += turn.y(), r[3] += turn.z();
  }
}

double System::projection_cost() const {
  return loops_ ? 6 : floats_ ? 1.5 : plane_ ? 0 : 0.2;  // measured
}

double System::displacement(const double* change) const {
  double sum = 0;
  std::size_t count = 0;
  for (const Span& span : spans_) {
    sum += links_.displacement(change, span.offset, span.links);
    count += span.links;
  }
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Part& part = bodies_[b];
    double turn = 0;
    for (std::size_t c = quaternion(b); c < quaternion(b) + 4; ++c) turn += change[c] * change[c];
    sum += 4 * turn * part.inertia.trace() / (2 * part.mass);
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

}  // namespace taut::direct
