#include "sim/methods/direct/spans.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sim/topology/components.h"
#include "sim/world/held.h"

namespace taut::direct {
namespace {

constexpr double kSampling = 1.0 / 512;  // s, between two checks of what changes
constexpr double kLocated = 1e-10;       // s, within which the moment of a change is known
constexpr double kLeastSlack = 1e-9;     // of its length: a span with less is laid straight
constexpr double kTooLong = 1e-12;       // of its length: a slack span so much longer goes taut
/// A span that goes taut or slack more often than that in so short a time does so without end.
constexpr double kBrief = 1e-6;  // s
constexpr int kMostChanges = 50;
/// Ends that meet their span's length again within this time (s) are not thrown back again.
constexpr double kShortestFlight = 1e-4;

struct Ends {
  PointMotion a, b;
  Vec3 line;  // unit vector from a to b
  double distance = 0, separation_speed = 0;
};

Ends ends_of(const World& world, const Attachment& a, const Attachment& b) {
  Ends ends;
  ends.a = hold_motion(world, a, world.time);
  ends.b = hold_motion(world, b, world.time);
  const Vec3 gap = ends.b.position - ends.a.position;
  ends.distance = gap.norm();
  ends.line = ends.distance > 0 ? Vec3(gap / ends.distance) : Vec3::UnitY();
  ends.separation_speed = ends.line.dot(ends.b.velocity - ends.a.velocity);
  return ends;
}

/// How fast the attached point moves along `line` after a unit impulse along it; 1/kg.
double mobility_along(const World& world, const Attachment& to, const Vec3& line) {
  if (is_prescribed(world, to)) return 0;
  const Body& body = world.bodies[to.body];
  const Vec3 turn = (body.point(to.point) - body.position).cross(line);
  return 1 / body.mass_properties.mass + turn.dot(body.world_inertia().ldlt().solve(turn));
}

void kick(World& world, const Attachment& to, const Vec3& impulse) {
  if (is_prescribed(world, to)) return;
  Body& body = world.bodies[to.body];
  const Vec3 arm = body.point(to.point) - body.position;
  body.velocity += impulse / body.mass_properties.mass;
  body.spin += body.world_inertia().ldlt().solve(arm.cross(impulse));
}

}  // namespace

Attachment Spans::attachment(const World& world, const Span& span, const SpanEnd& end) {
  if (const Hold* hold = find_hold(world.connectors[span.connector], end.particle)) return hold->to;
  Attachment to;
  to.kind = Attachment::Kind::body;
  const auto same = [&](const PointMass& p) {
    return p.connector == span.connector && p.particle == end.particle;
  };
  const auto known = std::ranges::find_if(point_masses_, same);
  to.body = world.bodies.size() + static_cast<std::size_t>(known - point_masses_.begin());
  if (known == point_masses_.end()) point_masses_.push_back({span.connector, end.particle});
  return to;
}

void Spans::prepare(const World& world) {
  const std::vector<Span> before = std::exchange(spans_, {});
  divide(world, before, spans_);
  ties_.clear();
  point_masses_.clear();
  copied_.clear();
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (connector.model == ConnectorModel::links && connector.sections.empty())
      copied_.push_back(c);
  }
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    const Span& span = spans_[s];
    const Connector& connector = world.connectors[span.connector];
    if (connector.model == ConnectorModel::links) continue;
    const auto takes_part = [](const SpanEnd& end) { return end.kind != SpanEnd::Kind::follower; };
    if (!takes_part(span.a) || !takes_part(span.b)) continue;
    ties_.push_back({s, attachment(world, span, span.a), attachment(world, span, span.b),
                     connector.restitution});
  }
  inner_ = world;
  for (const PointMass& p : point_masses_) {
    Body body;
    body.name = world.connectors[p.connector].name;
    const double mass = world.connectors[p.connector].particle_mass[p.particle];
    body.mass_properties = {mass, Vec3::Zero(), mass * Mat3::Identity()};  // turned by nothing
    inner_.bodies.push_back(body);
  }
  connect();
}

/// Puts the taut spans into the inner world as links, beside the links of the outer.
void Spans::connect() {
  inner_.connectors.resize(copied_.size());
  for (Tie& tie : ties_) {
    if (!spans_[tie.span].taut) continue;
    Connector link =
        straight_connector("span", spans_[tie.span].length, 0, 2, Vec3::Zero(), Vec3::UnitY());
    link.holds = {{0, tie.a, {}}, {1, tie.b, {}}};
    tie.link = inner_.connectors.size();
    inner_.connectors.push_back(std::move(link));
  }
  place_held(inner_, inner_.time);
  ++inner_.topology;
}

/// The tensions of the inner world's present state.
void Spans::update() {
  links_->find_tensions(inner_, copied_.size(), tension_);
}

void Spans::read(const World& world) {
  inner_.time = world.time;
  inner_.gravity = world.gravity;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) inner_.bodies[b] = world.bodies[b];
  for (std::size_t k = 0; k < point_masses_.size(); ++k) {
    const Connector& connector = world.connectors[point_masses_[k].connector];
    Body& body = inner_.bodies[world.bodies.size() + k];
    body.position = connector.position[point_masses_[k].particle];
    body.velocity = connector.velocity[point_masses_[k].particle];
  }
  for (std::size_t k = 0; k < copied_.size(); ++k) {
    inner_.connectors[k] = world.connectors[copied_[k]];
  }
}

void Spans::write(World& world) {
  world.time = inner_.time;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) world.bodies[b] = inner_.bodies[b];
  for (std::size_t k = 0; k < copied_.size(); ++k) {
    world.connectors[copied_[k]] = inner_.connectors[k];
  }
  for (std::size_t k = 0; k < point_masses_.size(); ++k) {
    const Body& body = inner_.bodies[world.bodies.size() + k];
    Connector& connector = world.connectors[point_masses_[k].connector];
    connector.position[point_masses_[k].particle] = body.position;
    connector.velocity[point_masses_[k].particle] = body.velocity;
  }
  place_held(world, world.time);
  for (const Tie& tie : ties_) {
    const Span& span = spans_[tie.span];
    lay_span(hanging_, world.connectors[span.connector], span, world.gravity);
  }
}

void lay_span(HangingChain& hanging, Connector& connector, const Span& span, const Vec3& gravity) {
  const std::size_t first = span.a.particle, last = span.b.particle;
  const Vec3 from = connector.position[first], to = connector.position[last];
  const Vec3 start = connector.velocity[first], change = connector.velocity[last] - start;
  const double slack = span.length - (to - from).norm();
  const bool hangs = slack > kLeastSlack * span.length && span.links() > 1;
  if (hangs) {
    hanging.place({.rest = std::span(connector.rest).subspan(first, span.links()),
                   .particle_mass = {},
                   .length = span.length},
                  from, to, gravity,
                  std::span(connector.position).subspan(first, span.links() + 1));
  }
  double along = 0;
  for (std::size_t k = first + 1; k < last; ++k) {
    along += connector.rest[k - 1];
    const double share = span.length > 0 ? along / span.length : 0;
    if (!hangs) connector.position[k] = from + share * (to - from);
    connector.velocity[k] = start + share * change;
  }
}

/// True where the state that was checked last is not one that the tie can be in: ends that were
/// too far apart before may come nearer.
bool Spans::breaks(const Tie& tie) const {
  const double length = spans_[tie.span].length;
  if (spans_[tie.span].taut) return tension_[tie.link] < 0;
  if (is_prescribed(inner_, tie.a) && is_prescribed(inner_, tie.b)) return false;
  const Ends ends = ends_of(inner_, tie.a, tie.b);
  return ends.distance > length * (1 + kTooLong) &&
         (ends.separation_speed > 0 || ends.distance > tie.longest);
}

bool Spans::breaks() {
  update();
  return std::ranges::any_of(ties_, [&](const Tie& tie) { return breaks(tie); });
}

/// Goes on to `until`, or to where the first tie has just broken.
void Spans::advance_to_break(double until) {
  before_ = inner_;
  for (Tie& tie : ties_) tie.longest = ends_of(inner_, tie.a, tie.b).distance;
  links_->advance(inner_, until);
  if (!breaks()) return;
  double whole = before_.time, broken = until;
  while (broken - whole > kLocated) {
    const double middle = (whole + broken) / 2;
    if (!(middle > whole && middle < broken)) break;
    inner_ = before_;
    links_->advance(inner_, middle);
    (breaks() ? broken : whole) = middle;
  }
  inner_ = before_;
  links_->advance(inner_, broken);
}

/// The ends of a slack span part at its full length: true where they are thrown back.
bool Spans::rebounds(Tie& tie, std::vector<Event>& events) {
  const Ends ends = ends_of(inner_, tie.a, tie.b);
  const double mobility =
      mobility_along(inner_, tie.a, ends.line) + mobility_along(inner_, tie.b, ends.line);
  const double back = tie.restitution * ends.separation_speed;
  const bool flies = back > 0 && inner_.time - tie.thrown_back > kShortestFlight;
  const double impulse = (ends.separation_speed + (flies ? back : 0)) / mobility;
  const Span& span = spans_[tie.span];
  events.push_back({Event::Kind::taut, inner_.time, span.connector, span.index, 0});
  events.push_back({Event::Kind::impulse, inner_.time, span.connector, span.index, impulse});
  if (!flies) return false;
  tie.thrown_back = inner_.time;
  kick(inner_, tie.a, impulse * ends.line);
  kick(inner_, tie.b, -impulse * ends.line);
  place_held(inner_, inner_.time);
  update();
  return true;
}

void Spans::watch_changes(const World& world, Tie& tie) const {
  if (inner_.time - tie.watched > kBrief) {
    tie.watched = inner_.time;
    tie.changes = 0;
  }
  if (++tie.changes <= kMostChanges) return;
  const Span& span = spans_[tie.span];
  throw Diverged("direct", inner_.time, counters().steps, world.connectors[span.connector].name,
                 span.a.particle, "a span goes taut and slack in turn without end");
}

void Spans::advance(World& world, double until, std::vector<Event>& events) {
  read(world);
  while (inner_.time < until) {
    advance_to_break(std::min(until, inner_.time + kSampling));
    bool changed = false;
    update();
    for (Tie& tie : ties_) {
      if (!breaks(tie)) continue;
      Span& span = spans_[tie.span];
      if (span.taut) {
        events.push_back({Event::Kind::slack, inner_.time, span.connector, span.index, 0});
      } else if (rebounds(tie, events)) {
        continue;
      }
      span.taut = !span.taut;
      changed = true;
      watch_changes(world, tie);
    }
    if (changed) connect();
  }
  write(world);
}

namespace {

constexpr double kNoMass = 1e-6;  // of the lightest thing

double lightest(const World& world) {
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](double mass) {
    if (mass > 0) least = std::min(least, mass);
  };
  for (const Body& body : world.bodies) take(body.mass_properties.mass);
  for (const Connector& connector : world.connectors) {
    for (const double mass : connector.particle_mass) take(mass);
  }
  return std::isfinite(least) ? least : 1;
}

}  // namespace

void SpansAsStrings::rebuild(const World& world) {
  strings_ = world;
  places_.clear();
  const double no_mass = kNoMass * lightest(world);
  std::vector<Span> spans;
  divide(world, {}, spans);
  for (const Span& span : spans) {
    const Connector& connector = world.connectors[span.connector];
    if (connector.model == ConnectorModel::links) continue;
    Connector string =
        straight_connector(connector.name.c_str(), span.length, 0, 2, Vec3::Zero(), Vec3::UnitX());
    string.pulls = true;
    string.restitution = connector.restitution;
    string.radius = connector.radius;
    string.category = connector.category;
    const std::size_t ends[] = {span.a.particle, span.b.particle};
    for (std::size_t end = 0; end < 2; ++end) {
      string.particle_mass[end] = connector.particle_mass[ends[end]];
      if (const Hold* hold = find_hold(connector, ends[end])) {
        string.holds.push_back(*hold);
        string.holds.back().particle = end;
      } else if (string.particle_mass[end] == 0) {
        string.particle_mass[end] = no_mass;
      }
    }
    std::size_t index = span.connector;
    if (span.index == 0) {
      strings_.connectors[index] = string;
    } else {
      index = strings_.connectors.size();
      strings_.connectors.push_back(string);
    }
    places_.push_back({span, index});
  }
  for (Joint& joint : strings_.joints) {
    for (Joint::Particle& at : joint.particles) {
      const Connector& connector = world.connectors[at.connector];
      if (connector.model == ConnectorModel::links || at.particle == 0) continue;
      at.particle = 1;
    }
  }
  strings_.topology = structure(strings_);
}

void SpansAsStrings::read(const World& world) {
  strings_.time = world.time;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) strings_.bodies[b] = world.bodies[b];
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    if (world.connectors[c].model != ConnectorModel::links) continue;
    strings_.connectors[c] = world.connectors[c];
  }
  for (const Place& place : places_) {
    const Connector& from = world.connectors[place.span.connector];
    Connector& to = strings_.connectors[place.string];
    to.position = {from.position[place.span.a.particle], from.position[place.span.b.particle]};
    to.velocity = {from.velocity[place.span.a.particle], from.velocity[place.span.b.particle]};
  }
}

void SpansAsStrings::write(World& world) {
  world.time = strings_.time;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) world.bodies[b] = strings_.bodies[b];
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    if (world.connectors[c].model != ConnectorModel::links) continue;
    world.connectors[c] = strings_.connectors[c];
  }
  for (const Place& place : places_) {
    const Connector& from = strings_.connectors[place.string];
    Connector& to = world.connectors[place.span.connector];
    to.position[place.span.a.particle] = from.position[0];
    to.position[place.span.b.particle] = from.position[1];
    to.velocity[place.span.a.particle] = from.velocity[0];
    to.velocity[place.span.b.particle] = from.velocity[1];
  }
  place_held(world, world.time);
  for (const Place& place : places_) {
    lay_span(hanging_, world.connectors[place.span.connector], place.span, world.gravity);
  }
}

}  // namespace taut::direct
