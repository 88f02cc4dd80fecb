// Extended position-based dynamics with small steps (Macklin et al. 2016 and 2019).
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/run/method.h"

namespace taut::methods {

// Free bodies, moved by constraints one after another.

/// How easily the carried point `along` moves, a gradient of any length: 1/kg of it squared.
double mobility(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& along,
                const double* state);
/// The same of a whole body: `by_place` is the gradient by its place (world axes), `by_turn` that
/// by its turn (m, body axes).
double mobility(const Mechanism& mechanism, std::size_t body, const Vec3& by_place,
                const Vec3& by_turn);

/// Moves the body that carries a point as `by` (kg m) at that point does, and all its points.
void pull(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
          double* state);
/// The same of a whole body: `by` moves its centre of mass, `turn` (kg m^2, body axes) turns it.
void pull(const Mechanism& mechanism, std::size_t body, const Vec3& by, const Vec3& turn,
          double* state);

// Stretch, bending and air as games do them: compliant constraints, projected one after another.

/// Macklin, Mueller and Chentanez, XPBD, 2016: a constraint C of energy k C^2 / 2 has a multiplier
/// (kg m) of its own. Damping c acts on velocities when positions have made these, as Mueller and
/// others do, Detailed rigid body simulation, 2020: in the same pass as stiffness it would take a
/// share c / (c + k dt) of what the pass moves back, and heavy loads would stretch ropes.
class XpbdMaterial {
 public:
  void rebuild(const Mechanism& mechanism);
  bool any() const { return any_; }

  /// The air's push in a step of `dt` (s), before particles fly.
  void blow(const Mechanism& mechanism, double dt, std::vector<double>& state);
  /// Forgets the multipliers, as a step begins.
  void begin();
  /// Goes through all elements once.
  void pass(const Mechanism& mechanism, double dt, double* state);
  /// Goes through their dampers once, after begin_damping(). Places carried points' velocities
  /// nowhere: Mechanism::place() does.
  void begin_damping() { std::ranges::fill(damper_, 0.0); }
  void damp(const Mechanism& mechanism, double dt, double* state);
  bool damps() const { return damps_; }

 private:
  struct Change {  // of C with a point
    std::uint32_t point = 0;
    Vec3 gradient = Vec3::Zero();
  };
  struct BodyChange {  // of C with a body's place, and its turn in body axes
    std::uint32_t body = 0;
    Vec3 by_place = Vec3::Zero(), by_turn = Vec3::Zero();
  };
  /// C and its gradient by free points and by bodies, at the places of a state.
  struct Constraint {
    double value = 0, mobility = 0;  // 1/kg
    double given = 0;                // 1/s of C: its rate that is no matter of damping
    bool pulls = false;              // C pushes nothing
    std::size_t points = 0, bodies = 0;
    std::array<Change, 3> point;
    std::array<BodyChange, 3> body;
  };
  void add(const Mechanism& mechanism, std::uint32_t point, const Vec3& gradient,
           const double* state, Constraint& to) const;
  static BodyChange& change_of(std::uint32_t body, Constraint& in);
  bool measure(const Mechanism& mechanism, const material::StretchElement& link,
               const double* state, Constraint& made) const;
  bool measure(const Mechanism& mechanism, const material::BendElement& bend, const double* state,
               Constraint& made) const;

  /// The body's point at a point that a free body carries; null: none does.
  const Mechanism::BodyPoint* carried(const Mechanism& mechanism, std::uint32_t point) const {
    const std::uint32_t at = carried_.empty() ? kNone : carried_[point];
    return at == kNone ? nullptr : &mechanism.body_points()[at];
  }

  static constexpr std::uint32_t kNone = 0xffffffff;
  bool any_ = false, damps_ = false;
  std::vector<std::uint32_t> carried_;  // of each point, in body_points(); empty: no body
  // Of stretches, then of bends, then of twists: kg m, and N s.
  std::vector<double> multiplier_, damper_;
  std::vector<Vec3> force_;
};

/// Per step everything moves freely; then passes over the links, in order, move their ends towards
/// the rest length, and velocities follow from positions. With compliance a (m/N) each pass adds
///   dl = -(C + a l / dt^2) / (w_a + w_b + a / dt^2)
/// to the link's multiplier l (kg m), C (m) its excess and w (1/kg) its ends' inverse masses along
/// it; at a rigid body w is 1/m + (r x n).I^-1 (r x n) (Mueller et al. 2020).
MethodInfo xpbd_method();

}  // namespace taut::methods
