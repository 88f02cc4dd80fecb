// From a world to a system.
#include <algorithm>
#include <cmath>

#include "sim/links/equimomental_link.h"
#include "sim/methods/direct/system/scales.h"
#include "sim/methods/direct/system/system.h"

namespace taut::direct {
namespace {

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
                     const std::optional<Plane>& plane,
                     std::span<const ConstraintRow* const> rows) {
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
  place_rows(rows);
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
  velocity_time_ = velocity_time_of(length_);
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

}  // namespace taut::direct
