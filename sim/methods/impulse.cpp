// Impulse and reposition: the flexible connectors of "An Efficient Method for Simulating Flexible
// Connectors", sections IV.A to IV.C.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <ranges>
#include <vector>

#include "sim/contact/touch.h"
#include "sim/methods/methods.h"
#include "sim/motion/rotation.h"
#include "sim/motion/stop.h"
#include "sim/run/error_estimate.h"
#include "sim/run/method.h"
#include "sim/topology/components.h"
#include "sim/world/world.h"

namespace taut::methods {
namespace {

// What beads touch in a step of `impulse`, and what the surfaces let them do.

/// A bead that may touch something in a step: after its flight it is inside of an obstacle, or no
/// farther outside than it goes in a step.
struct TouchingBead {
  /// To what its connector does there (SpanPath).
  enum class Role {
    free,  // nothing: the surface's friction is the bead's own matter
    held,  // it is stuck to the surface, and divides the connector as a pin does
    led,   // it goes where its connector slides, which has had its friction
  };
  static constexpr std::size_t kMost = 3;  // surfaces at a bead

  std::size_t connector = 0, particle = 0;
  Role role = Role::free;
  std::size_t inside = 0, count = 0;  // touches: those first that the flight ended inside of
  std::array<contact::Touch, kMost> touch;
  std::array<std::size_t, kMost> obstacle{};
  /// m, from the surfaces, zero inside: after the flight, and before it had they moved by then.
  std::array<double, kMost> apart{}, apart_before{};
  Vec3 started = Vec3::Zero();  // m, before the flight
  /// Where repositioning finds it, m and m/s.
  Vec3 place = Vec3::Zero(), velocity = Vec3::Zero();
};

/// Contact at the end of a step: what is inside of an obstacle is placed on its surface. Of first
/// order in the step; what passes an obstacle within a step is not stopped.
class BeadTouches {
 public:
  /// Call when the topology is new.
  void prepare(const World& world);

  bool any() const { return !obstacles_.empty(); }
  std::vector<TouchingBead>& beads() { return beads_; }
  const TouchingBead* find(std::size_t connector, std::size_t particle) const {
    if (!any()) return nullptr;
    const std::uint32_t index = index_[first_[connector] + particle];
    return index == kNone ? nullptr : &beads_[index];
  }

  /// After a flight of `dt` (s) that ended at `time` (s): finds the beads, and gives those inside
  /// what the surfaces do to a ball by itself.
  void land(World& world, double time, double dt);
  /// The same for what has pulled the bead since, in the same step. True where that changes it.
  bool press(World& world, TouchingBead& bead, double dt) const;
  /// Sticks the bead to its first surface, which carries it from where it was before the flight.
  void hold(World& world, TouchingBead& bead, double dt) const;
  /// Notes where repositioning begins.
  void begin_repositioning(const World& world, double dt);
  /// Where the surfaces let links take a bead that these would place at `wanted` (m).
  static Vec3 allowed(const TouchingBead& bead, const Vec3& wanted, double dt);
  /// After repositioning from where the connectors' particles had `flown`, with the velocities from
  /// positions: no bead stays inside, and no depth makes a speed.
  void finish(World& world, const std::vector<std::vector<Vec3>>& flown, double dt) const;

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  contact::Touch meet(std::size_t obstacle, const Vec3& at, const Vec3& normal) const;
  void keep_out(Connector& connector, std::size_t index, std::size_t particle, const Vec3& flown,
                double dt) const;
  void place_out(const TouchingBead& bead, double radius, Vec3& at) const;

  std::vector<Obstacle> obstacles_;
  std::vector<FrameMotion> frames_;  // of these, at the step's end
  std::vector<TouchingBead> beads_;
  std::vector<std::size_t> first_;    // per connector, its first particle in index_
  std::vector<std::uint32_t> index_;  // per particle: in beads_
  std::vector<char> touches_;         // per particle: nothing holds it
};

// An end of a span as a thing that impulses move.

/// A span so near its limit, as a part of its length, is at it.
constexpr double kAtLimit = 1e-12;

/// A point at `arm` from the centre of mass of a body, or a particle (arm zero). World axes.
struct Side {
  double inverse_mass = 0;              // 1/kg; zero: does not respond to impulses
  Mat3 inverse_inertia = Mat3::Zero();  // 1/(kg m^2)
  Vec3 arm = Vec3::Zero();              // m
  Vec3 spin = Vec3::Zero();             // rad/s
  Vec3* centre = nullptr;               // m, where the state keeps it
  Vec3* velocity = nullptr;             // m/s, of the centre
  Body* body = nullptr;

  Side(World& world, const Span& span, const SpanEnd& end,
       const std::vector<FreeRotation>& rotations) {
    Connector& connector = world.connectors[span.connector];
    centre = &connector.position[end.particle];
    velocity = &connector.velocity[end.particle];
    if (end.kind == SpanEnd::Kind::particle) {
      inverse_mass = 1 / connector.particle_mass[end.particle];
    } else if (end.kind == SpanEnd::Kind::body) {
      body = &world.bodies[end.body];
      centre = &body->position;
      velocity = &body->velocity;
      inverse_mass = 1 / body->mass_properties.mass;
      inverse_inertia = rotations[end.body].inverse_inertia(body->rotation);
      arm = body->point(end.point) - body->position;
      spin = body->spin;
    }
  }

  /// The arm `ago` seconds before, to second order in the turn since.
  Vec3 arm_before(double ago) const {
    const Vec3 turn = ago * spin;
    return arm - turn.cross(arm) + turn.cross(turn.cross(arm)) / 2;
  }
  Vec3 point() const { return *centre + arm; }
  Vec3 point_before(double ago) const { return *centre - ago * *velocity + arm_before(ago); }
  Vec3 fall(const Vec3& gravity) const { return inverse_mass > 0 ? gravity : Vec3(0, 0, 0); }
  Vec3 velocity_of(const Vec3& at) const { return *velocity + spin.cross(at); }

  /// The velocity that the point at `seen` gets from a unit impulse along `n` at `acting`.
  Vec3 inverse_mass_along(const Vec3& n, const Vec3& acting, const Vec3& seen) const {
    return inverse_mass * n + (inverse_inertia * acting.cross(n)).cross(seen);
  }
  /// The same as a matrix on the impulse.
  Mat3 inverse_mass_matrix(const Vec3& acting, const Vec3& seen) const {
    Mat3 matrix;
    for (int i = 0; i < 3; ++i) matrix.col(i) = inverse_mass_along(Vec3::Unit(i), acting, seen);
    return matrix;
  }

  void kick(const Vec3& impulse, const Vec3& acting) const {
    if (inverse_mass == 0) return;
    *velocity += inverse_mass * impulse;
    if (body) body->spin += inverse_inertia * acting.cross(impulse);
  }
  /// Moves it as far as an impulse has since it acted; `impulse_time` is the product, N s^2. The
  /// angular momentum stays, so that the spin changes as the inertia turns.
  void shift(const Vec3& impulse_time, const Vec3& acting) const {
    if (inverse_mass == 0) return;
    *centre += inverse_mass * impulse_time;
    if (!body) return;
    const Vec3 momentum = body->world_inertia() * body->spin;
    const Vec3 half = inverse_inertia * acting.cross(impulse_time) / 2;
    const Quat turn = Quat(1, half.x(), half.y(), half.z()).normalized();
    body->rotation = (turn * body->rotation).normalized();
    body->spin +=
        turn * (inverse_inertia * (turn.conjugate() * momentum)) - inverse_inertia * momentum;
  }
};

/// The share of a rebound left by the connector, m_a / (m_c + m_a), m_a the ends' reduced mass.
inline double mass_ratio(const Span& span, double inverse_mass) {
  return 1 / (1 + span.mass * inverse_mass);
}

// The way along which a span pulls, around what its connector presses on.

/// A span between two ends that its beads' touches bend: straight from the one end to the first
/// corner, from corner to corner, and from the last to the other end. As nothing between the ends
/// of the paper has mass, the pull is the same along all of it but for friction, by which it grows
/// at each corner in the direction of sliding, to (1 + mu tan a)/(1 - mu tan a) of what it was, a
/// half the angle of the bend: Coulomb's law where the pulls press on the surface.
struct SpanPath {
  struct Corner {
    std::size_t particle = 0;
    Vec3 at = Vec3::Zero();  // m
    /// m/s, of the surface there, and of it what moves the corner while the connector slides.
    Vec3 carried = Vec3::Zero(), led = Vec3::Zero();
  };
  enum class State {
    slack,  // nothing pulls
    held,   // friction holds it: both parts are spans by themselves, as at a pin
    slides_to_a,
    slides_to_b,
  };

  bool bends = false;
  Corner first, last;
  double inner = 0, inner_rate = 0;          // m and m/s, of the way from the first to the last
  double most_stuck = 1, most_slid = 1;      // of the pull at one end over that at the other
  double first_length = 0, last_length = 0;  // m, of the connector beyond these corners
  State state = State::slack;
};

/// Finds paths, in a workspace of its own.
class PathFinder {
 public:
  void reserve(std::size_t particles) { corners_.reserve(particles); }
  /// The path of a span, with the particles at their places.
  SpanPath find(const World& world, const Span& span, const std::vector<double>& along,
                BeadTouches& touches);
  /// The beads at its corners.
  const std::vector<TouchingBead*>& corners() const { return corners_; }

 private:
  std::vector<TouchingBead*> corners_;
};

// The impulses between the ends of a span: section IV.A of the paper.

/// The limits between which the ends of a link may be, as parts of its rest length. A span of more
/// than one link folds, so that only the longest applies to it.
struct LinkLimits {
  double shortest = 1;
  double longest = 1;
};

class SpanImpulses {
 public:
  SpanImpulses(LinkLimits limits, bool as_printed) : limits_(limits), as_printed_(as_printed) {}

  /// Reads the bodies' mass properties; call whenever they or the world's topology change.
  void prepare(const World& world);

  /// Notes where the span has gone slack in a free flight that ended at `time` (s).
  void watch(const World& world, Span& span, double time, std::vector<Event>& events) const;

  /// Lets the span's ends interact after a free flight of `dt` (s) that ended at `time` (s). True
  /// where that moved anything. Appends what an observer would see to `events`.
  bool act(World& world, Span& span, double time, double dt, std::vector<Event>& events) const;

  /// The same for a span whose pull goes around corners.
  void watch_around(const World& world, Span& span, const SpanPath& path, double time,
                    std::vector<Event>& events) const;
  bool act_around(World& world, Span& span, const SpanPath& path, double time, double dt,
                  std::vector<Event>& events) const;
  /// What the corners do to the span.
  SpanPath::State grip(World& world, const Span& span, const SpanPath& path) const;

  const FreeRotation& rotation(std::size_t body) const { return rotations_[body]; }

 private:
  LinkLimits limits_;
  bool as_printed_;
  std::vector<FreeRotation> rotations_;  // one per body
};

// The repositioning of particles between the ends of spans: section IV.B of the paper.

class Repositioning {
 public:
  Repositioning(LinkLimits limits, double threshold, bool as_printed)
      : limits_(limits), threshold_(threshold), as_printed_(as_printed) {}

  /// Reads lengths and masses; call whenever the topology changes.
  void prepare(const World& world, const std::vector<Span>& spans);
  /// m, rest length from the first particle of a connector.
  const std::vector<double>& along(std::size_t connector) const { return along_[connector]; }

  /// Notes where the particles are after free flight and impulses.
  void begin(const World& world);
  /// Neighbours nearer than l_c or farther than l_t, by more than h, are moved to that distance,
  /// each by the other's part of their mass; what touches something, as far as that lets it.
  void pass(World& world, const Span& span, const BeadTouches& touches, double dt) const;
  /// A particle farther from an end than the rest length between them is moved to that distance;
  /// from both ends, and the ends themselves last. Corners divide the span into parts.
  void stay_in_reach(World& world, const Span& span, BeadTouches& touches, double dt);
  /// Velocities from positions: flight gave dx/dt + g dt/2, repositioning adds what it moved.
  void set_velocities(World& world, double dt) const;
  const std::vector<std::vector<Vec3>>& flown() const { return flown_; }

 private:
  /// A connector in a step.
  struct Strand {
    std::vector<Vec3>& position;
    const std::vector<double>&along, &weight;
    std::size_t connector;
    const BeadTouches* touches;  // null: nothing touches
    double dt;                   // s
  };
  Strand strand(World& world, const Span& span, const BeadTouches& touches, double dt) const;
  void make_room(const World& world);
  void weigh(const Connector& connector, std::size_t index);
  void reach(const Strand& strand, std::size_t first, std::size_t last, std::size_t end) const;
  void meet(const Strand& strand, std::size_t i, std::size_t end) const;
  static void draw(const Strand& strand, std::size_t i, std::size_t j, double squared,
                   double wanted);
  static void draw_at_surfaces(const Strand& strand, std::size_t i, std::size_t j, const Vec3& move,
                               double wanted);

  LinkLimits limits_;
  double threshold_;  // m: h
  bool as_printed_;
  // Per connector and particle:
  std::vector<std::vector<double>> along_;   // m, rest length from the first particle
  std::vector<std::vector<double>> weight_;  // how easily it is moved; zero: held
  std::vector<std::vector<Vec3>> flown_;     // m, after free flight and impulses
  std::vector<std::size_t> dividers_;        // particles: a span's ends, and its corners
};

/// Of a change of a bead's speed: smaller ones are rounding.
constexpr double kNothing = 1e-9;

Vec3 across(const Vec3& velocity, const Vec3& normal) {
  return velocity - normal.dot(velocity) * normal;
}

/// The velocity of a bead on which `touches` act; they remember what they have given.
Vec3 respond_and_note(const Vec3& free, std::span<contact::Touch> touches) {
  const Vec3 velocity = contact::respond(free, touches).velocity;
  for (contact::Touch& touch : touches) {
    touch.pushed = touch.push * touch.normal;
    touch.friction_before = touch.friction;
  }
  return velocity;
}

Vec3 friction(std::span<const contact::Touch> touches) {
  Vec3 sum = Vec3::Zero();
  for (const contact::Touch& touch : touches) sum += touch.friction_before;
  return sum;
}

void BeadTouches::prepare(const World& world) {
  obstacles_ = world.obstacles;
  beads_.clear();
  first_.clear();
  index_.clear();
  touches_.clear();
  if (obstacles_.empty()) return;
  frames_.resize(obstacles_.size());
  const std::size_t particles = room(world).particles;
  if (index_.capacity() == 0) {  // what is cut off later has its particles from here
    beads_.reserve(particles);
    index_.reserve(particles);
    touches_.reserve(particles);
    first_.reserve(world.connectors.capacity());
  }
  for (const Connector& connector : world.connectors) {
    first_.push_back(touches_.size());
    touches_.insert(touches_.end(), connector.particles(), 1);
    for (const Hold& hold : connector.holds) touches_[first_.back() + hold.particle] = 0;
  }
  index_.assign(touches_.size(), kNone);
}

contact::Touch BeadTouches::meet(std::size_t obstacle, const Vec3& at, const Vec3& normal) const {
  const FrameMotion& frame = frames_[obstacle];
  contact::Touch touch;
  touch.normal = normal;
  touch.surface = frame.velocity + frame.spin.cross(at - frame.position);
  touch.least = normal.dot(touch.surface);
  touch.stick = obstacles_[obstacle].static_friction;
  touch.slide = obstacles_[obstacle].kinetic_friction;
  return touch;
}

/// Moves a place out of what the bead touches.
void BeadTouches::place_out(const TouchingBead& bead, double radius, Vec3& at) const {
  for (std::size_t k = 0; k < bead.count; ++k) {
    const std::size_t o = bead.obstacle[k];
    const SurfaceDistance near = gap(obstacles_[o], frames_[o].pose(), at, radius);
    if (near.distance < 0) at -= near.distance * near.normal;
  }
}

void BeadTouches::land(World& world, double time, double dt) {
  for (const TouchingBead& bead : beads_) index_[first_[bead.connector] + bead.particle] = kNone;
  beads_.clear();
  for (std::size_t o = 0; o < obstacles_.size(); ++o) frames_[o] = obstacles_[o].frame(time);
  const Vec3 gain = dt * world.gravity;
  const double resting = 2 * gain.norm();  // m/s, what gravity alone may make
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Connector& connector = world.connectors[c];
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (!touches_[first_[c] + i]) continue;
      Vec3 &at = connector.position[i], &velocity = connector.velocity[i];
      const Vec3 started = at - dt * velocity + dt / 2 * gain;
      TouchingBead bead;
      for (std::size_t o = 0; o < obstacles_.size() && bead.count < bead.kMost; ++o) {
        if (!obstacles_[o].touches(connector.category)) continue;
        const SurfaceDistance near = gap(obstacles_[o], frames_[o].pose(), at, connector.radius);
        contact::Touch touch = meet(o, at, near.normal);
        if (near.distance > dt * (velocity - touch.surface).norm()) continue;
        touch.sliding = across(velocity - gain - touch.surface, near.normal);
        std::size_t slot = bead.count++;
        if (near.distance <= 0) {
          const double into = near.normal.dot(touch.surface - velocity);
          if (into > resting) touch.least += obstacles_[o].restitution * into;
          if (slot != bead.inside) {
            bead.touch[slot] = bead.touch[bead.inside];
            bead.obstacle[slot] = bead.obstacle[bead.inside];
            bead.apart[slot] = bead.apart[bead.inside];
            bead.apart_before[slot] = bead.apart_before[bead.inside];
          }
          slot = bead.inside++;
        }
        bead.touch[slot] = touch;
        bead.obstacle[slot] = o;
        bead.apart[slot] = std::max(0.0, near.distance);
        bead.apart_before[slot] = 0;
        if (near.distance <= 0) continue;
        const Vec3 before = started + dt * touch.surface;
        bead.apart_before[slot] =
            std::max(0.0, gap(obstacles_[o], frames_[o].pose(), before, connector.radius).distance);
      }
      if (bead.count == 0) continue;
      bead.connector = c;
      bead.particle = i;
      bead.started = started;
      if (bead.inside > 0) {
        const std::span inside(bead.touch.data(), bead.inside);
        velocity = respond_and_note(velocity, inside);
        at += dt / 2 * friction(inside);
        place_out(bead, connector.radius, at);
      }
      index_[first_[c] + i] = static_cast<std::uint32_t>(beads_.size());
      beads_.push_back(bead);
    }
  }
}

bool BeadTouches::press(World& world, TouchingBead& bead, double dt) const {
  if (bead.inside == 0) return false;
  Connector& connector = world.connectors[bead.connector];
  Vec3 &at = connector.position[bead.particle], &velocity = connector.velocity[bead.particle];
  const Vec3 pulled = velocity;
  velocity = respond_and_note(velocity, std::span(bead.touch.data(), bead.inside));
  at += dt / 2 * (velocity - pulled);
  place_out(bead, connector.radius, at);
  return (velocity - pulled).norm() > kNothing * (1 + pulled.norm());
}

void BeadTouches::hold(World& world, TouchingBead& bead, double dt) const {
  Connector& connector = world.connectors[bead.connector];
  Vec3 &at = connector.position[bead.particle], &velocity = connector.velocity[bead.particle];
  bead.role = TouchingBead::Role::held;
  velocity = bead.touch[0].surface;
  at = bead.started + dt * velocity;
  place_out(bead, connector.radius, at);
}

void BeadTouches::begin_repositioning(const World& world, double dt) {
  for (TouchingBead& bead : beads_) {
    const Connector& connector = world.connectors[bead.connector];
    bead.place = connector.position[bead.particle];
    bead.velocity = connector.velocity[bead.particle];
    for (std::size_t k = bead.inside; k < bead.count; ++k) {
      const std::size_t o = bead.obstacle[k];
      const double apart =
          gap(obstacles_[o], frames_[o].pose(), bead.place, connector.radius).distance;
      bead.touch[k].least = bead.touch[k].normal.dot(bead.touch[k].surface) - apart / dt;
    }
    if (bead.role != TouchingBead::Role::led) continue;
    for (std::size_t k = 0; k < bead.count; ++k) bead.touch[k].stick = bead.touch[k].slide = 0;
  }
}

Vec3 BeadTouches::allowed(const TouchingBead& bead, const Vec3& wanted, double dt) {
  if (bead.role == TouchingBead::Role::held) return bead.place;
  std::array<contact::Touch, TouchingBead::kMost> touch = bead.touch;
  const Vec3 free = bead.velocity + (wanted - bead.place) / dt;
  const Vec3 velocity = contact::respond(free, std::span(touch.data(), bead.count)).velocity;
  return bead.place + dt * (velocity - bead.velocity);
}

void BeadTouches::finish(World& world, const std::vector<std::vector<Vec3>>& flown,
                         double dt) const {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (std::size_t i = 0; i < world.connectors[c].particles(); ++i) {
      if (touches_[first_[c] + i]) keep_out(world.connectors[c], c, i, flown[c][i], dt);
    }
  }
}

void BeadTouches::keep_out(Connector& connector, std::size_t c, std::size_t i, const Vec3& flown,
                           double dt) const {
  Vec3 &at = connector.position[i], &velocity = connector.velocity[i];
  const TouchingBead* bead = find(c, i);
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    if (!obstacles_[o].touches(connector.category)) continue;
    const Pose frame = frames_[o].pose();
    if (gap(obstacles_[o], frame, at, connector.radius).distance >= 0) continue;
    const bool known = bead && std::ranges::count(bead->obstacle.begin(),
                                                  bead->obstacle.begin() + bead->count, o) > 0;
    if (!known) {  // links have drawn it in: it stays on the side from which it came
      const SurfaceDistance from = gap(obstacles_[o], frame, flown, connector.radius);
      contact::Touch touch = meet(o, at, from.normal);
      touch.least -= std::max(0.0, from.distance) / dt;
      const Vec3 drawn = velocity;
      velocity = contact::respond(velocity, std::span(&touch, 1)).velocity;
      at += dt * (velocity - drawn);
    }
    const SurfaceDistance near = gap(obstacles_[o], frame, at, connector.radius);
    at -= std::min(0.0, near.distance) * near.normal;
    contact::Touch touch = meet(o, at, near.normal);
    touch.stick = touch.slide = 0;  // it has had its friction
    velocity = contact::respond(velocity, std::span(&touch, 1)).velocity;
  }
}

constexpr double kPresses = 1e-6;  // of a pull: so much presses on a surface
constexpr double kNear = 0.02;     // of a link: a bead so near a surface was on it
constexpr double kLocked = 1e9;    // no pull is so many times another

Vec3 unit(const Vec3& way) {
  const double length = way.norm();
  return length > 0 ? Vec3(way / length) : Vec3(0, 0, 0);
}

/// The touch of the bead on which pulls to both neighbours press most; null: on none.
const contact::Touch* pressed(const TouchingBead& bead, const Vec3& pull, double nearest) {
  const contact::Touch* most = nullptr;
  double push = kPresses;
  for (std::size_t k = 0; k < bead.count; ++k) {
    if (bead.apart_before[k] > nearest) continue;
    const double presses = -bead.touch[k].normal.dot(pull);
    if (presses <= push) continue;
    push = presses;
    most = &bead.touch[k];
  }
  return most;
}

double growth(double friction, double half_bend_tangent) {
  const double rubs = friction * half_bend_tangent;
  return rubs < 1 ? std::min(kLocked, (1 + rubs) / (1 - rubs)) : kLocked;
}

SpanPath PathFinder::find(const World& world, const Span& span, const std::vector<double>& along,
                          BeadTouches& touches) {
  const Connector& connector = world.connectors[span.connector];
  const std::vector<Vec3>& position = connector.position;
  const std::size_t a = span.a.particle, b = span.b.particle;
  const auto foot = [&](const TouchingBead& bead) {  // on the surface that it touches
    return Vec3(position[bead.particle] - bead.apart[0] * bead.touch[0].normal);
  };
  const auto place = [&](std::size_t k) {  // of the corners so far, counted from 1; 0: the end a
    return k == 0 ? position[a] : foot(*corners_[k - 1]);
  };
  const auto touch_at = [&](const TouchingBead& bead, const Vec3& before, const Vec3& after) {
    const Vec3 at = foot(bead);
    const double link = std::min(connector.rest[bead.particle - 1], connector.rest[bead.particle]);
    return pressed(bead, unit(before - at) + unit(after - at), kNear * link);
  };
  const auto straighten = [&](const Vec3& next) {
    while (!corners_.empty()) {
      if (touch_at(*corners_.back(), place(corners_.size() - 1), next)) return;
      corners_.pop_back();
    }
  };
  corners_.clear();
  auto bead = std::ranges::lower_bound(
      touches.beads(), std::pair(span.connector, a + 1), {},
      [](const TouchingBead& one) { return std::pair(one.connector, one.particle); });
  for (; bead != touches.beads().end() && bead->connector == span.connector && bead->particle < b;
       ++bead) {
    straighten(foot(*bead));
    corners_.push_back(&*bead);
  }
  straighten(position[b]);

  SpanPath path;
  path.bends = !corners_.empty();
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    const Vec3 at = place(k + 1), before = place(k);
    const Vec3 after = k + 1 < corners_.size() ? place(k + 2) : position[b];
    const contact::Touch* touch = touch_at(*corners_[k], before, after);
    if (!touch) touch = corners_[k]->touch.data();
    const Vec3 back = unit(before - at), on = unit(after - at);
    const double half_bend = (back + on).norm() / (on - back).norm();
    path.most_stuck *= growth(touch->stick, half_bend);
    path.most_slid *= growth(touch->slide, half_bend);
    const SpanPath::Corner corner{corners_[k]->particle, at, touch->surface,
                                  touch->normal.dot(touch->surface) * touch->normal};
    if (k == 0) {
      path.first = corner;
    } else {
      const Vec3 way = at - path.last.at;
      path.inner += way.norm();
      path.inner_rate += unit(way).dot(corner.led - path.last.led);
    }
    path.last = corner;
  }
  if (!path.bends) return path;
  path.most_stuck = std::min(path.most_stuck, kLocked);
  path.most_slid = std::min(path.most_slid, kLocked);
  path.first_length = along[path.first.particle] - along[a];
  path.last_length = along[b] - along[path.last.particle];
  return path;
}

constexpr double kSameLine = 0.5;  // cosine of the most that a span turns between limit and now

/// The impulse (N s) on b, its reaction on a, and the ways they have gone since (N s^2).
void exchange(const Side& a, const Vec3& arm_a, const Side& b, const Vec3& arm_b,
              const Vec3& impulse, const Vec3& impulse_time) {
  a.kick(-impulse, arm_a);
  b.kick(impulse, arm_b);
  a.shift(-impulse_time, arm_a);
  b.shift(impulse_time, arm_b);
}

/// The distances between which a span's ends are left alone, m.
struct DistanceLimits {
  double shortest, longest;
  double exact;  // so near a limit is at it

  DistanceLimits(const Span& span, const LinkLimits& limits)
      : shortest(span.folds ? 0 : limits.shortest * span.length),
        longest(limits.longest * span.length),
        exact(kAtLimit * span.length) {}
};

/// A span without length is a joint: it holds in every direction. Half a step ago is when the
/// forces of a step act that keep it closed.
bool close_joint(const Side& a, const Side& b, double dt) {
  const Vec3 arm_a = a.arm_before(dt / 2), arm_b = b.arm_before(dt / 2);
  const Mat3 inverse =
      Mat3(a.inverse_mass_matrix(arm_a, a.arm) + b.inverse_mass_matrix(arm_b, b.arm)).inverse();
  const Vec3 shift = inverse * (a.point() - b.point());
  const Vec3 impulse = inverse * (a.velocity_of(a.arm) - b.velocity_of(b.arm));
  exchange(a, arm_a, b, arm_b, impulse, shift);
  return true;
}

/// Equation (5) as it stands in the paper: each end responds as if the other were fixed, its moment
/// of inertia is a number (about the axis that resists most), and nothing clamps it. It has moved
/// with the mean of its velocities before and after. Returns the larger of the two impulses, N s.
double printed_impulse(const Side& a, const Side& b, const Span& span, const Vec3& along,
                       double separation_speed, double restitution, double dt) {
  double largest = 0;
  const auto apply = [&](const Side& side, const Vec3& toward_other) {
    if (side.inverse_mass == 0) return;
    double inverse = side.inverse_mass;
    if (side.body) {
      const Mat3 inertia = side.body->mass_properties.inertia;
      const double moment = inertia.diagonal().maxCoeff();
      if (moment > 0) inverse += side.arm.squaredNorm() / moment;
    }
    const double size =
        separation_speed * (1 + restitution) / inverse * mass_ratio(span, side.inverse_mass);
    side.kick(size * toward_other, side.arm);
    side.shift(dt / 2 * size * toward_other, side.arm);
    largest = std::max(largest, size);
  };
  apply(a, along);
  apply(b, -along);
  return largest;
}

void SpanImpulses::prepare(const World& world) {
  rotations_.clear();
  for (const Body& body : world.bodies) rotations_.emplace_back(body.mass_properties.inertia);
}

void SpanImpulses::watch(const World& world, Span& span, double time,
                         std::vector<Event>& events) const {
  if (!span.taut || span.length == 0) return;
  const std::vector<Vec3>& position = world.connectors[span.connector].position;
  const double distance = (position[span.b.particle] - position[span.a.particle]).norm();
  const DistanceLimits range(span, limits_);
  if (distance >= range.longest - range.exact || distance <= range.shortest + range.exact) return;
  span.taut = false;
  events.push_back({Event::Kind::slack, time, span.connector, span.index, 0});
}

bool SpanImpulses::act(World& world, Span& span, double time, double dt,
                       std::vector<Event>& events) const {
  if (span.a.kind == SpanEnd::Kind::follower || span.b.kind == SpanEnd::Kind::follower) {
    return false;
  }
  const Side a(world, span, span.a, rotations_), b(world, span, span.b, rotations_);
  const double inverse_mass = a.inverse_mass + b.inverse_mass;
  if (inverse_mass == 0 || (a.body && a.body == b.body)) return false;
  const auto log = [&](Event::Kind kind, double when, double size) {
    events.push_back({kind, when, span.connector, span.index, size});
  };
  const Vec3 gap = b.point() - a.point();
  const double distance = gap.norm();
  const DistanceLimits range(span, limits_);
  const bool is_long = distance > range.longest + range.exact;
  if (!is_long && distance >= range.shortest - range.exact) return false;
  if (span.length == 0 && !as_printed_) return close_joint(a, b, dt);

  // From here on, `sign` makes whatever leads farther beyond the limit positive.
  const double sign = is_long ? 1 : -1;
  const double limit = is_long ? range.longest : range.shortest;
  const Vec3 along = gap / distance;
  const double separation_speed = sign * along.dot(b.velocity_of(b.arm) - a.velocity_of(a.arm));
  const double restitution = world.connectors[span.connector].restitution;
  if (as_printed_) {
    if (separation_speed <= 0) return false;
    const double size =
        printed_impulse(a, b, span, sign * along, separation_speed, restitution, dt);
    if (!span.taut) {
      log(Event::Kind::taut, time, 0);
      log(Event::Kind::impulse, time, size);
    }
    span.taut = true;
    return false;  // both ends have responded; nothing more to settle in this step
  }

  // The span passed its limit `ago`; in steady tension that is half a step. `pull` is what gravity
  // adds to the separation speed in a second.
  const bool impact = separation_speed > 0 && !span.taut;
  const double pull = sign * along.dot(b.fall(world.gravity) - a.fall(world.gravity));
  const double excess = sign * (distance - limit);
  double ago = separation_speed > 0 ? std::min(excess / separation_speed, dt) : 0;
  if (impact)
    ago = std::min(excess / std::max(separation_speed - pull * ago / 2, separation_speed / 2), dt);
  Vec3 line = (b.point_before(ago) - a.point_before(ago)).normalized();
  Vec3 arm_a = a.arm_before(ago), arm_b = b.arm_before(ago);
  Vec3 response =
      a.inverse_mass_along(line, arm_a, a.arm) + b.inverse_mass_along(line, arm_b, b.arm);
  // The shift along `line` that brings the ends back to their limit: |gap + shift response| =
  // limit.
  const double p = gap.dot(response), q = response.squaredNorm();
  const double c = distance * distance - limit * limit;
  const bool turns = line.dot(along) < kSameLine || p * p < q * c;
  double shift = turns ? 0 : -c / (p + std::sqrt(p * p - q * c));
  if (turns) {  // too fast to be followed back: as the ends are now, to first order
    ago = 0;
    line = along;
    arm_a = a.arm, arm_b = b.arm;
    response = a.inverse_mass_along(line, arm_a, a.arm) + b.inverse_mass_along(line, arm_b, b.arm);
    shift = (limit - distance) / line.dot(response);
  }
  double size = 0;
  if (impact) {
    const Vec3 then =
        a.inverse_mass_along(line, arm_a, arm_a) + b.inverse_mass_along(line, arm_b, arm_b);
    const double speed = sign * line.dot(b.velocity_of(arm_b) - a.velocity_of(arm_a));
    // Thrown back at the moment of the impact, and pulled since; else the span stays taut.
    const double back = restitution * mass_ratio(span, inverse_mass) * (speed - pull * ago);
    const bool rebounds = back > pull * ago;
    const double wanted = rebounds ? pull * ago - back : 0;
    size = sign * (wanted - speed) / line.dot(then);
    if (rebounds) shift -= sign * ago * (back - pull * ago / 2) / line.dot(then);
    log(Event::Kind::taut, time - ago, 0);
    log(Event::Kind::impulse, time - ago, std::abs(size));
  } else if (separation_speed >
             0) {  // steady: the distance of the ends does not change when the step ends
    const Vec3 now = turns ? along : Vec3((gap + shift * response).normalized());
    size = -now.dot(b.velocity_of(b.arm) - a.velocity_of(a.arm)) / now.dot(response);
  }
  span.taut = true;
  exchange(a, arm_a, b, arm_b, size * line, shift * line);
  return true;
}

// The impulses between the ends of a span whose pull goes around corners.

constexpr double kSlack = 1e-6;  // of its length: a part that is so much shorter does not pull
constexpr double kMostGone = 2;  // of what a way may have got longer in a step by its rate
constexpr int kNewton = 4;       // steps, each of which doubles the digits

/// An end of such a span, and the corner before it.
struct Leg {
  Side side;
  const SpanPath::Corner& corner;
  Vec3 way, toward;  // m, to the corner; the unit vector

  Leg(World& world, const Span& span, const SpanEnd& end, const SpanPath::Corner& at,
      const std::vector<FreeRotation>& rotations)
      : side(world, span, end, rotations), corner(at), way(at.at - side.point()) {
    toward = direction(way);
  }
  static Vec3 direction(const Vec3& way) {
    const double length = way.norm();
    return length > 0 ? Vec3(way / length) : Vec3(0, 0, 0);
  }
  /// m/s, at which it gets longer where the corner moves with `velocity`.
  double rate(const Vec3& velocity) const {
    return toward.dot(velocity - side.velocity_of(side.arm));
  }
  double mobility() const {
    return toward.dot(side.inverse_mass_along(toward, side.arm, side.arm));
  }
  /// N s: the pull that keeps it from getting longer, by itself.
  double pull() const {
    const double speed = rate(corner.carried), mobile = mobility();
    if (speed <= 0) return 0;
    return mobile > 0 ? speed / mobile : HUGE_VAL;
  }
};

SpanPath::State SpanImpulses::grip(World& world, const Span& span, const SpanPath& path) const {
  using enum SpanPath::State;
  if (as_printed_) return held;
  const Leg a(world, span, span.a, path.first, rotations_),
      b(world, span, span.b, path.last, rotations_);
  // A taut way pulls at both ends, wherever its beads are on it; of a slack one only what friction
  // at the corners keeps taut by itself.
  const double taut = limits_.longest - kSlack;
  const bool is_taut = a.way.norm() + path.inner + b.way.norm() >= taut * span.length;
  const double at_a = is_taut || a.way.norm() >= taut * path.first_length ? a.pull() : 0;
  const double at_b = is_taut || b.way.norm() >= taut * path.last_length ? b.pull() : 0;
  if (at_a == 0 && at_b == 0) return slack;
  if (at_b > path.most_stuck * at_a) return slides_to_b;
  if (at_a > path.most_stuck * at_b) return slides_to_a;
  return held;
}

void SpanImpulses::watch_around(const World& world, Span& span, const SpanPath& path, double time,
                                std::vector<Event>& events) const {
  if (!span.taut) return;
  const std::vector<Vec3>& position = world.connectors[span.connector].position;
  const double length = (path.first.at - position[span.a.particle]).norm() + path.inner +
                        (position[span.b.particle] - path.last.at).norm();
  if (length >= (limits_.longest - kSlack) * span.length) return;
  span.taut = false;
  events.push_back({Event::Kind::slack, time, span.connector, span.index, 0});
}

bool SpanImpulses::act_around(World& world, Span& span, const SpanPath& path, double time,
                              double dt, std::vector<Event>& events) const {
  if (span.a.kind == SpanEnd::Kind::follower || span.b.kind == SpanEnd::Kind::follower) {
    return false;
  }
  const Leg a(world, span, span.a, path.first, rotations_),
      b(world, span, span.b, path.last, rotations_);
  if (a.side.inverse_mass + b.side.inverse_mass == 0) return false;
  const double reach = a.way.norm() + path.inner + b.way.norm();
  double excess = reach - limits_.longest * span.length;
  if (excess <= kAtLimit * span.length) return false;
  const double pull_a = path.state == SpanPath::State::slides_to_a ? path.most_slid : 1;
  const double pull_b = path.state == SpanPath::State::slides_to_b ? path.most_slid : 1;

  const double separation_speed = a.rate(path.first.led) + path.inner_rate + b.rate(path.last.led);
  if (separation_speed <= 0) return false;
  // What beads in a heap make the way longer by is not what the ends have gone.
  excess = std::min(excess, kMostGone * dt * separation_speed);
  const bool impact = !span.taut;
  const double fall =
      -a.toward.dot(a.side.fall(world.gravity)) - b.toward.dot(b.side.fall(world.gravity));
  double ago = std::min(excess / separation_speed, dt);
  if (impact) {
    const double speed = std::max(separation_speed - fall * ago / 2, separation_speed / 2);
    ago = std::min(excess / speed, dt);
  }
  // At the moment at which the path had its length, as for a span without corners.
  const Vec3 line_a =
      Leg::direction(path.first.at - ago * path.first.led - a.side.point_before(ago));
  const Vec3 line_b = Leg::direction(path.last.at - ago * path.last.led - b.side.point_before(ago));
  const Vec3 arm_a = a.side.arm_before(ago), arm_b = b.side.arm_before(ago);
  const Vec3 response_a = pull_a * a.side.inverse_mass_along(line_a, arm_a, a.side.arm);
  const Vec3 response_b = pull_b * b.side.inverse_mass_along(line_b, arm_b, b.side.arm);
  double shift = 0;  // N s^2
  Vec3 now_a = a.toward, now_b = b.toward;
  for (int i = 0; i < kNewton; ++i) {
    const Vec3 way_a = a.way - shift * response_a, way_b = b.way - shift * response_b;
    now_a = Leg::direction(way_a);
    now_b = Leg::direction(way_b);
    const double shortens = now_a.dot(response_a) + now_b.dot(response_b);
    if (!(shortens > 0)) return false;
    shift += (way_a.norm() + path.inner + way_b.norm() - (reach - excess)) / shortens;
  }
  double size = 0;  // N s
  if (impact) {
    const double then = pull_a * line_a.dot(a.side.inverse_mass_along(line_a, arm_a, arm_a)) +
                        pull_b * line_b.dot(b.side.inverse_mass_along(line_b, arm_b, arm_b));
    const double speed = line_a.dot(path.first.led - a.side.velocity_of(arm_a)) + path.inner_rate +
                         line_b.dot(path.last.led - b.side.velocity_of(arm_b));
    const double ratio = mass_ratio(span, a.side.inverse_mass + b.side.inverse_mass);
    const double back = world.connectors[span.connector].restitution * ratio * (speed - fall * ago);
    const bool rebounds = back > fall * ago;
    size = (speed - (rebounds ? fall * ago - back : 0)) / then;
    if (rebounds) shift += ago * (back - fall * ago / 2) / then;
    events.push_back({Event::Kind::taut, time - ago, span.connector, span.index, 0});
    events.push_back(
        {Event::Kind::impulse, time - ago, span.connector, span.index, std::abs(size)});
  } else {
    const double rate = now_a.dot(path.first.led - a.side.velocity_of(a.side.arm)) +
                        path.inner_rate + now_b.dot(path.last.led - b.side.velocity_of(b.side.arm));
    size = rate / (now_a.dot(response_a) + now_b.dot(response_b));
  }
  span.taut = true;
  a.side.kick(pull_a * size * line_a, arm_a);
  b.side.kick(pull_b * size * line_b, arm_b);
  a.side.shift(pull_a * shift * line_a, arm_a);
  b.side.shift(pull_b * shift * line_b, arm_b);
  return true;
}

constexpr double kMore = 1e-6;  // rounding of a particle's mass
constexpr int kDraws = 3;       // times that two particles are drawn together, where one touches
constexpr double kMostDrawn = 100;  // by how much more than if neither did

void Repositioning::prepare(const World& world, const std::vector<Span>& spans) {
  make_room(world);
  if (dividers_.empty()) dividers_.reserve(room(world).particles + 2);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) weigh(world.connectors[c], c);
  if (!as_printed_) return;
  for (const Span& span : spans) {  // "the end points are set to have infinite mass"
    for (const SpanEnd* end : {&span.a, &span.b}) {
      if (end->kind != SpanEnd::Kind::follower) weight_[span.connector][end->particle] = 0;
    }
  }
}

/// For all connectors that the world has room for, with as much room as any of them.
void Repositioning::make_room(const World& world) {
  if (along_.size() >= world.connectors.size()) return;
  const std::size_t connectors = world.connectors.capacity();
  along_.resize(connectors);
  weight_.resize(connectors);
  flown_.resize(connectors);
  const auto capacity = [](const Connector& c) { return c.position.capacity(); };
  std::size_t most = 0;
  for (const Connector& connector : world.connectors) most = std::max(most, capacity(connector));
  if (double(connectors) * double(most) > kMostRoom) most = 0;
  for (std::size_t c = 0; c < connectors; ++c) {
    const bool cut_off = c >= world.connectors.size();  // later, from any of them
    const std::size_t particles = cut_off ? most : capacity(world.connectors[c]);
    along_[c].reserve(particles);
    weight_[c].reserve(particles);
    flown_[c].reserve(particles);
  }
}

/// Reads the lengths and masses of a connector.
void Repositioning::weigh(const Connector& connector, std::size_t index) {
  const std::size_t n = connector.particles();
  std::vector<double>&along = along_[index], &weight = weight_[index];
  along.assign(n, 0.0);
  weight.assign(n, 1.0);
  for (std::size_t i = 0; i + 1 < n; ++i) along[i + 1] = along[i] + connector.rest[i];
  const bool massless = connector.model == ConnectorModel::span || !(connector.mass > 0);
  double share = 0;  // kg, of the heaviest particle between the ends
  for (std::size_t i = 1; i + 1 < n && !massless; ++i) {
    share = std::max(share, connector.particle_mass[i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double mass = connector.particle_mass[i];
    // An end that carries more than its share of the connector has infinite mass here, as every
    // end in the paper; so a rope's bare end stays one of its particles.
    const bool carries = (i == 0 || i + 1 == n) && mass > share * (1 + kMore);
    weight[i] = carries ? 0 : mass > 0 && share > 0 ? share / mass : 1;
  }
  for (const Hold& hold : connector.holds) weight[hold.particle] = 0;
}

void Repositioning::begin(const World& world) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    flown_[c] = world.connectors[c].position;
  }
}

Repositioning::Strand Repositioning::strand(World& world, const Span& span,
                                            const BeadTouches& touches, double dt) const {
  const std::size_t c = span.connector;
  return {world.connectors[c].position,       along_[c], weight_[c], c,
          touches.any() ? &touches : nullptr, dt};
}

void Repositioning::pass(World& world, const Span& span, const BeadTouches& touches,
                         double dt) const {
  const Strand at = strand(world, span, touches, dt);
  const std::vector<double>& rest = world.connectors[span.connector].rest;
  for (std::size_t k = span.a.particle; k < span.b.particle; ++k) {
    const double squared = (at.position[k + 1] - at.position[k]).squaredNorm();
    const double shortest = limits_.shortest * rest[k];
    const double longest = limits_.longest * rest[k];
    const double least = std::max(0.0, shortest - threshold_), most = longest + threshold_;
    if (squared >= least * least && squared <= most * most) continue;
    if (squared == 0) continue;
    draw(at, k, k + 1, squared, squared > longest * longest ? longest : shortest);
  }
}

/// Moves two particles, whose distance has this square, to the `wanted` distance (m), each by the
/// other's part of their mass.
void Repositioning::draw(const Strand& strand, std::size_t i, std::size_t j, double squared,
                         double wanted) {
  const double both = strand.weight[i] + strand.weight[j];
  if (both == 0) return;
  Vec3 &p = strand.position[i], &q = strand.position[j];
  const double distance = std::sqrt(squared);
  const Vec3 move = (q - p) * ((distance - wanted) / (distance * both));
  if (strand.touches) return draw_at_surfaces(strand, i, j, move, wanted);
  p += strand.weight[i] * move;
  q -= strand.weight[j] * move;
}

/// The same where the surfaces that they touch let them: what is kept from one of them falls to the
/// other, and none moves farther than both are off.
void Repositioning::draw_at_surfaces(const Strand& strand, std::size_t i, std::size_t j,
                                     const Vec3& move, double wanted) {
  const double weight_i = strand.weight[i], weight_j = strand.weight[j];
  const double both = weight_i + weight_j;
  Vec3 &p = strand.position[i], &q = strand.position[j];
  const Vec3 from_p = p, from_q = q;
  const TouchingBead* at_p = strand.touches->find(strand.connector, i);
  const TouchingBead* at_q = strand.touches->find(strand.connector, j);
  if (!at_p && !at_q) {
    p += weight_i * move;
    q -= weight_j * move;
    return;
  }
  const double distance = (q - p).norm();
  double more = 1;
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    p = from_p + std::min(more * weight_i, both) * move;
    q = from_q - std::min(more * weight_j, both) * move;
    if (at_p) p = BeadTouches::allowed(*at_p, p, strand.dt);
    if (at_q) q = BeadTouches::allowed(*at_q, q, strand.dt);
    const double reached = (distance - (q - p).norm()) / (distance - wanted);
    if (!(reached > 1 / kMostDrawn)) return;  // they can be drawn no nearer
    more /= reached;
  }
}

void Repositioning::stay_in_reach(World& world, const Span& span, BeadTouches& touches, double dt) {
  dividers_.clear();
  dividers_.push_back(span.a.particle);
  for (const TouchingBead& bead : touches.beads()) {
    if (bead.connector != span.connector || bead.role == TouchingBead::Role::free) continue;
    if (bead.particle <= span.a.particle || bead.particle >= span.b.particle) continue;
    dividers_.push_back(bead.particle);
  }
  dividers_.push_back(span.b.particle);
  const Strand at = strand(world, span, touches, dt);
  const std::size_t parts = dividers_.size() - 1;
  for (std::size_t k = 0; k < parts; ++k) {
    const std::size_t first = dividers_[k], last = dividers_[k + 1];
    for (const std::size_t end : {first, last}) reach(at, first, last, end);
    if (parts > 1) meet(at, last, first);  // a corner that slides stays in reach
  }
  if (!as_printed_) meet(at, span.b.particle, span.a.particle);
}

/// Moves the particles between two into the reach of one of these, `end`.
void Repositioning::reach(const Strand& strand, std::size_t first, std::size_t last,
                          std::size_t end) const {
  if (strand.weight[end] > 0) {
    for (std::size_t i = first + 1; i < last; ++i) meet(strand, i, end);
    return;
  }
  const Vec3 place = strand.position[end];
  const double along = strand.along[end];
  for (std::size_t i = first + 1; i < last; ++i) {
    const double longest = limits_.longest * std::abs(strand.along[i] - along);
    const Vec3 apart = strand.position[i] - place;
    const double squared = apart.squaredNorm();
    if (squared <= longest * longest) continue;
    const Vec3 wanted = place + longest / std::sqrt(squared) * apart;
    const TouchingBead* bead = strand.touches ? strand.touches->find(strand.connector, i) : nullptr;
    strand.position[i] = bead ? BeadTouches::allowed(*bead, wanted, strand.dt) : wanted;
  }
}

/// Moves a particle and an end into each other's reach, each by the other's part of their mass.
void Repositioning::meet(const Strand& strand, std::size_t i, std::size_t end) const {
  const double longest = limits_.longest * std::abs(strand.along[i] - strand.along[end]);
  const double squared = (strand.position[end] - strand.position[i]).squaredNorm();
  if (squared > longest * longest) draw(strand, i, end, squared, longest);
}

void Repositioning::set_velocities(World& world, double dt) const {
  const double rate = 1 / dt;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Connector& connector = world.connectors[c];
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      connector.velocity[i] += rate * (connector.position[i] - flown_[c][i]);
    }
  }
}

constexpr std::string_view kImpulse = "impulse";
constexpr int kSettlings = 8;   // times that spans which share a body are gone through at most
constexpr double kSense = 1e6;  // m; no scene is so wide
constexpr std::size_t kEvents = 1024;

class Impulse final : public Method {
 public:
  explicit Impulse(const Settings& settings)
      : step_(number(settings, "step")),
        limits_{number(settings, "l_c"), number(settings, "l_t")},
        passes_(static_cast<int>(number(settings, "passes"))),
        as_printed_(flag(settings, "as_printed")),
        impulses_(limits_, as_printed_),
        repositioning_(limits_, number(settings, "h"), as_printed_) {}

  void advance(World& world, double until) override {
    if (!prepared_ || topology_ != world.topology) prepare(world);
    const StepTimes times(world.time, until, step_);
    for (std::uint64_t i = 0; i < times.count; ++i) {
      check_stop();
      step(world, times.at(i + 1), times.dt);
    }
    world.time = until;
  }

 private:
  void prepare(const World& world);
  void step(World& world, double time, double dt);
  void fly(World& world, double dt);
  void find_paths(World& world, double dt);
  void settle(World& world, double time, double dt);
  bool interact(World& world, std::size_t span, double time, double dt);
  void check(const World& world, double time) const;

  double step_;
  LinkLimits limits_;
  int passes_;
  bool as_printed_;
  SpanImpulses impulses_;
  std::vector<Span> spans_, spans_before_;
  Repositioning repositioning_;
  BeadTouches touches_;
  PathFinder finder_;
  std::vector<SpanPath> paths_;  // of spans_, where there are obstacles
  bool prepared_ = false;
  std::uint64_t topology_ = 0;
  double step_cycles_ = 0, pass_cycles_ = 0;  // see Counters::cycles
};

void Impulse::prepare(const World& world) {
  require(kImpulse, world);
  topology_ = world.topology;
  impulses_.prepare(world);
  touches_.prepare(world);
  if (!prepared_) {
    events_.reserve(kEvents);
    const std::size_t spans = room(world).holds + world.connectors.size();
    spans_.reserve(spans);
    spans_before_.reserve(spans);
  }
  prepared_ = true;
  std::swap(spans_, spans_before_);
  divide(world, spans_before_, spans_);
  repositioning_.prepare(world, spans_);
  if (touches_.any()) {
    if (paths_.capacity() == 0) finder_.reserve(room(world).particles);
    if (paths_.capacity() == 0) paths_.reserve(spans_.capacity());
    paths_.resize(spans_.size());
  }
  // A link that is as long as it may be costs a pass its length and a comparison, another a root, a
  // division and a move that the next link waits for; of a step, flight, reach and velocities are
  // some 80 operations a particle, and a body's impulses as much as thirty of them.
  step_cycles_ = 400 * static_cast<double>(spans_.size());
  pass_cycles_ = 0;
  for (const Connector& connector : world.connectors) {
    step_cycles_ += 40 * static_cast<double>(connector.particles());
    pass_cycles_ += 40 * static_cast<double>(connector.links());
  }
  for (const Body& body : world.bodies) step_cycles_ += body.driven() ? 100 : 1200;
}

void Impulse::step(World& world, double time, double dt) {
  fly(world, dt);
  place_held(world, time);
  if (touches_.any()) {
    touches_.land(world, time, dt);
    find_paths(world, dt);
  }
  settle(world, time, dt);
  if (touches_.any()) touches_.begin_repositioning(world, dt);
  repositioning_.begin(world);
  for (const Span& span : spans_) {
    for (int pass = 0; pass < passes_; ++pass) {
      check_stop();
      repositioning_.pass(world, span, touches_, dt);
    }
    repositioning_.stay_in_reach(world, span, touches_, dt);
  }
  repositioning_.set_velocities(world, dt);
  if (touches_.any()) touches_.finish(world, repositioning_.flown(), dt);
  ++counters_.steps;
  counters_.solves += static_cast<std::uint64_t>(passes_);
  counters_.cycles += step_cycles_ + passes_ * pass_cycles_;
  check(world, time);
}

void Impulse::fly(World& world, double dt) {
  const Vec3 fall = world.gravity * (dt * dt / 2);
  const Vec3 gain = world.gravity * dt;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    Body& body = world.bodies[i];
    if (body.driven()) continue;
    body.position += body.velocity * dt + fall;
    body.velocity += gain;
    impulses_.rotation(i).turn(body.rotation, body.spin, dt);
  }
  for (Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      connector.position[i] += connector.velocity[i] * dt + fall;
      connector.velocity[i] += gain;
    }
  }
}

/// Around what each span pulls in this step, and what that does to its beads there.
void Impulse::find_paths(World& world, double dt) {
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    SpanPath& path = paths_[s];
    path = finder_.find(world, spans_[s], repositioning_.along(spans_[s].connector), touches_);
    if (!path.bends) continue;
    path.state = impulses_.grip(world, spans_[s], path);
    for (TouchingBead* bead : finder_.corners()) {
      if (path.state == SpanPath::State::held) {
        touches_.hold(world, *bead, dt);
      } else if (path.state != SpanPath::State::slack) {
        bead->role = TouchingBead::Role::led;
      }
    }
  }
}

void Impulse::settle(World& world, double time, double dt) {
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (touches_.any() && paths_[s].bends) {
      impulses_.watch_around(world, spans_[s], paths_[s], time, events_);
    } else {
      impulses_.watch(world, spans_[s], time, events_);
    }
  }
  bool moved = true;
  for (int i = 0; moved && i < kSettlings; ++i) {
    moved = false;
    for (std::size_t s = 0; s < spans_.size(); ++s) moved |= interact(world, s, time, dt);
    for (TouchingBead& bead : touches_.beads()) {  // what the impulses have pulled at
      const std::size_t last = world.connectors[bead.connector].particles() - 1;
      if (bead.particle == 0 || bead.particle == last) moved |= touches_.press(world, bead, dt);
    }
  }
  place_carried(world);
}

bool Impulse::interact(World& world, std::size_t index, double time, double dt) {
  Span& span = spans_[index];
  if (!touches_.any() || !paths_[index].bends) {
    return impulses_.act(world, span, time, dt, events_);
  }
  const SpanPath& path = paths_[index];
  if (path.state != SpanPath::State::held) {
    return impulses_.act_around(world, span, path, time, dt, events_);
  }
  Span before = span, after = span;
  before.b = {.kind = SpanEnd::Kind::prescribed, .particle = path.first.particle};
  after.a = {.kind = SpanEnd::Kind::prescribed, .particle = path.last.particle};
  bool moved = false;
  for (Span* part : {&before, &after}) {
    const double length = part == &before ? path.first_length : path.last_length;
    part->mass *= length / part->length;
    part->length = length;
    part->folds = part->links() > 1 || span.folds;
    moved |= impulses_.act(world, *part, time, dt, events_);
  }
  span.taut = before.taut || after.taut;
  return moved;
}

void Impulse::check(const World& world, double time) const {
  for (const Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (connector.position[i].squaredNorm() < kSense * kSense) continue;  // false for NaN
      throw Diverged(std::string(kImpulse), time, counters_.steps, connector.name,
                     i > 0 ? i - 1 : 0,
                     connector.position[i].allFinite() ? "a particle is beyond any scene"
                                                       : "a position is not finite");
    }
  }
}

/// Shorter steps do not take the method to the truth.
SettingInfo impulse_step() {
  SettingInfo info = step_setting({}, 10);
  info.meaning =
      "Length of a time step. Raising it costs less and errs more; lowering it does not reduce the "
      "method's own error.";
  return info;
}

}  // namespace

MethodInfo impulse_method() {
  return {
      .name = kImpulse,
      .summary = "impulses between the ends, particles repositioned",
      .settings = {impulse_step(),
                   {.name = "h",
                    .meaning = "Length error up to which a link is not repositioned. Raising it "
                               "costs less and errs more.",
                    .unit = "m",
                    .fallback = 1e-5},
                   {.name = "l_c",
                    .meaning = "Shortest length of a link, as a share of its rest length; 0: links "
                               "can fold. Raising it makes links resist compression earlier.",
                    .unit = "1",
                    .fallback = 1.0,
                    .maximum = 1},
                   {.name = "l_t",
                    .meaning = "Longest length of a link or span, as a share of its rest length. "
                               "Raising it lets the connector stretch.",
                    .unit = "1",
                    .fallback = 1.0,
                    .minimum = 1,
                    .maximum = 10},
                   {.name = "passes",
                    .meaning = "Repositioning passes over all links per step. Raising it keeps "
                               "lengths better and costs more.",
                    .unit = "1",
                    .fallback = 1.0,
                    .minimum = 1,
                    .maximum = 1000,
                    .whole = true,
                    .sweep = {1.0, 4.0, 16.0}},
                   {.name = "as_printed",
                    .meaning = "Whether to use equation (5) and the ends as the paper prints them, "
                               "without corrections.",
                    .unit = "",
                    .fallback = false}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Impulse>(settings);
      },
      .paper_role = PaperRole::proposed,
      .forms = {{"as-printed", {{"as_printed", true}}}},
      .abilities = {kPlainFeatures | Features{Feature::span, Feature::obstacle,
                                              Feature::moving_obstacle, Feature::friction,
                                              Feature::restitution},
                    {{Feature::span, kContactFeatures}}},
      .companion =
          [](const MethodInfo&, const Settings&) {
            return Companion{.none = "does not converge to the exact solution, whatever its step"};
          },
      .particle_memory = 100,
  };
}

}  // namespace taut::methods
