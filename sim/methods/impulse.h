// Impulse and reposition: the flexible connectors of "An Efficient Method for Simulating Flexible
// Connectors", sections IV.A to IV.C.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/contact/touch.h"
#include "sim/motion/rotation.h"
#include "sim/run/method.h"
#include "sim/topology/span.h"
#include "sim/world/world.h"

namespace taut::methods {

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

/// Bodies and particles move freely. A span longer than its length whose ends separate gives them
/// the impulse of equation (5). Particles are repositioned where a neighbour is nearer or farther
/// than allowed, then where an end is farther than its share of the length, the ends last; their
/// velocities follow from their positions. Held particles divide a connector into spans, each
/// simulated by itself.
///
/// The paper's equation (5) holds for a fixed other end, lets a handle sink, and no rule clamps the
/// end body. Where `as_printed` is false both ends' terms stand in its denominator, the mass ratio
/// scales the rebound alone, and the impulse acts at the moment within the step at which the span
/// became taut: the ends have moved with their new velocities since, which leaves them within reach
/// and keeps momentum, angular momentum and, while a span stays taut, energy.
///
/// Beads inside of obstacles after their flight are placed on the surfaces. Where a span's pull
/// presses them on, they are its corners: held by friction they divide it, as pins do; else it
/// slides around them, and equation (5) is that of the whole way from end to end, with pulls that
/// differ by what friction takes (SpanPath). Where `as_printed`, corners always divide.
MethodInfo impulse_method();

}  // namespace taut::methods
