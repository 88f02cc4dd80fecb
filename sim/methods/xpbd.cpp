// Extended position-based dynamics with small steps (Macklin et al. 2016 and 2019).
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/contact/body_contacts.h"
#include "sim/contact/connector_contacts.h"
#include "sim/links/mechanism.h"
#include "sim/material/elements.h"
#include "sim/measure/frequency.h"
#include "sim/methods/methods.h"
#include "sim/methods/stepped.h"
#include "sim/motion/stop.h"
#include "sim/run/error_estimate.h"
#include "sim/run/method.h"

namespace taut::methods {
namespace {

// Free bodies, moved by constraints one after another.

/// The moment of `by` at a carried point, in body axes.
Vec3 moment(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
            const double* state) {
  const Quat rotation = quaternion(state + mechanism.pose(point.body) + 3);
  return point.local.cross(rotation.conjugate() * by);
}

/// The inverse mass (1/kg) of a body along a constraint: `by_place` is the constraint's gradient by
/// the body's place (world axes), `by_turn` by its turn (m, body axes).
double mobility(const Mechanism& mechanism, std::size_t body, const Vec3& by_place,
                const Vec3& by_turn) {
  const auto& moved = mechanism.bodies()[body];
  return moved.inverse_mass * by_place.squaredNorm() + by_turn.dot(moved.inverse_inertia * by_turn);
}

/// The same at a carried point; `along` is the constraint's gradient there.
double mobility(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& along,
                const double* state) {
  return mobility(mechanism, point.body, along, moment(mechanism, point, along, state));
}

/// Moves a body's centre of mass by `by` (kg m) and turns it by `turn` (kg m^2, body axes), and
/// takes the points that it carries along.
void pull(const Mechanism& mechanism, std::size_t body, const Vec3& by, const Vec3& turn,
          double* state) {
  const auto& moved = mechanism.bodies()[body];
  double* q = state + mechanism.pose(body);
  const Quat rotation = quaternion(q + 3);
  Eigen::Map<Vec3> centre(q);
  centre += moved.inverse_mass * by;
  rotate(rotation * (moved.inverse_inertia * turn), q + 3);
  const Quat turned = quaternion(q + 3);
  for (const auto& other : mechanism.body_points()) {
    if (other.body != body) continue;
    Eigen::Map<Vec3> position(state + mechanism.position(other.point));
    position = centre + turned * other.local;
  }
}

/// The same by `by` (kg m) at a carried point.
void pull(const Mechanism& mechanism, const Mechanism::BodyPoint& point, const Vec3& by,
          double* state) {
  pull(mechanism, point.body, by, moment(mechanism, point, by, state), state);
}

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

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

void XpbdMaterial::rebuild(const Mechanism& mechanism) {
  const material::MaterialForces& material = mechanism.material();
  any_ = material.any();
  if (!any_) return;
  multiplier_.reserve(2 * (mechanism.state_room() / 6));
  multiplier_.assign(
      material.stretches().size() + material.bends().size() + material.twists().size(), 0.0);
  damper_.reserve(multiplier_.capacity());
  damper_.assign(multiplier_.size(), 0.0);
  const auto damps = [](const auto& element) { return element.damping > 0; };
  damps_ = std::ranges::any_of(material.stretches(), damps) ||
           std::ranges::any_of(material.bends(), damps) ||
           std::ranges::any_of(material.twists(), damps);
  force_.reserve(mechanism.state_room() / 6);
  force_.resize(mechanism.points());
  carried_.clear();
  if (mechanism.body_points().empty()) return;
  carried_.assign(mechanism.points(), kNone);
  for (std::size_t i = 0; i < mechanism.body_points().size(); ++i) {
    carried_[mechanism.body_points()[i].point] = static_cast<std::uint32_t>(i);
  }
}

void XpbdMaterial::blow(const Mechanism& mechanism, double dt, std::vector<double>& state) {
  const material::MaterialForces& material = mechanism.material();
  if (material.drags().empty() && !material.has_applied()) return;
  std::ranges::fill(force_, Vec3::Zero());
  material.add_drag(state.data(), &state[mechanism.velocity(0)], force_);
  material.add_applied(state.data(), &state[mechanism.velocity(0)], force_);
  for (std::size_t p = 0; p < mechanism.points(); ++p) {
    Eigen::Map<Vec3> velocity(&state[mechanism.velocity(p)]);
    velocity += dt * mechanism.inverse_mass()[p] * force_[p];
  }
  for (const Mechanism::BodyPoint& at : mechanism.body_points()) {
    const Mechanism::FreeBody& body = mechanism.bodies()[at.body];
    const Quat rotation = quaternion(&state[mechanism.pose(at.body) + 3]);
    const Vec3 torque = at.local.cross(rotation.conjugate() * force_[at.point]);  // body axes
    Eigen::Map<Vec3> velocity(&state[mechanism.twist(at.body)]);
    Eigen::Map<Vec3> spin(&state[mechanism.twist(at.body) + 3]);
    velocity += dt * body.inverse_mass * force_[at.point];
    spin += dt * (rotation * (body.inverse_inertia * torque));
  }
}

void XpbdMaterial::begin() {
  std::ranges::fill(multiplier_, 0.0);
}

XpbdMaterial::BodyChange& XpbdMaterial::change_of(std::uint32_t body, Constraint& in) {
  for (std::size_t b = 0; b < in.bodies; ++b)
    if (in.body[b].body == body) return in.body[b];
  in.body[in.bodies] = {.body = body};
  return in.body[in.bodies++];
}

void XpbdMaterial::add(const Mechanism& mechanism, std::uint32_t point, const Vec3& gradient,
                       const double* state, Constraint& to) const {
  if (const Mechanism::BodyPoint* at = carried(mechanism, point)) {
    BodyChange& body = change_of(at->body, to);
    const Quat rotation = quaternion(state + mechanism.pose(at->body) + 3);
    body.by_place += gradient;
    body.by_turn += at->local.cross(rotation.conjugate() * gradient);
  } else {
    to.point[to.points++] = {point, gradient};
    to.mobility += mechanism.inverse_mass()[point] * gradient.squaredNorm();
  }
}

/// False where C is no matter there: a string is slack, or has no direction.
bool XpbdMaterial::measure(const Mechanism& mechanism, const material::StretchElement& link,
                           const double* state, Constraint& made) const {
  const Vec3 gap =
      ConstMap(state + mechanism.position(link.b)) - ConstMap(state + mechanism.position(link.a));
  const double length = gap.norm();
  if (!(length > 0) || (link.pulls && length <= link.rest)) return false;
  const Vec3 unit = gap / length;
  made.value = length - link.rest;
  made.pulls = link.pulls;
  if (link.rest_rate != 0) made.given = length / link.rest * link.rest_rate;
  add(mechanism, link.a, -unit, state, made);
  add(mechanism, link.b, unit, state, made);
  return true;
}

bool XpbdMaterial::measure(const Mechanism& mechanism, const material::BendElement& bend,
                           const double* state, Constraint& made) const {
  Vec3 e0, e1, by_e0, by_e1;
  mechanism.material().edges(bend, state, e0, e1);
  const auto clamp = mechanism.clamp_on_body(bend);
  if (clamp) {  // turned since the last place()
    (bend.clamped_before() ? e0 : e1) =
        quaternion(state + mechanism.pose(clamp->body) + 3) * clamp->local;
  }
  const material::Bend shape(e0, e1, bend.rest);
  // The gradient of C is that of C^2 / 2 over C.
  made.value = std::sqrt(2 * shape.energy(1));
  if (!(made.value > 0)) return false;
  shape.slope(1 / made.value, by_e0, by_e1);
  if (clamp) {
    const Quat rotation = quaternion(state + mechanism.pose(clamp->body) + 3);
    const Vec3& gradient = bend.clamped_before() ? by_e0 : by_e1;
    change_of(clamp->body, made).by_turn += clamp->local.cross(rotation.conjugate() * gradient);
  }
  if (bend.clamped_before()) by_e0.setZero();
  if (bend.clamped_behind()) by_e1.setZero();
  if (!bend.clamped_before()) add(mechanism, bend.a, -by_e0, state, made);
  add(mechanism, bend.b, by_e0 - by_e1, state, made);
  if (!bend.clamped_behind()) add(mechanism, bend.c, by_e1, state, made);
  return true;
}

void XpbdMaterial::pass(const Mechanism& mechanism, double dt, double* state) {
  const material::MaterialForces& material = mechanism.material();
  double* multiplier = multiplier_.data();
  const auto project = [&](const auto& element) {
    Constraint at;
    double& sum = *multiplier++;
    if (!measure(mechanism, element, state, at)) return;
    for (std::size_t b = 0; b < at.bodies; ++b)
      at.mobility += mobility(mechanism, at.body[b].body, at.body[b].by_place, at.body[b].by_turn);
    const double hard = element.stiffness * dt * dt;  // kg
    const double more = -(hard * at.value + sum) / (1 + hard * at.mobility);
    sum += more;
    for (std::size_t p = 0; p < at.points; ++p) {
      const auto& [point, gradient] = at.point[p];
      Map(state + mechanism.position(point)) += more * mechanism.inverse_mass()[point] * gradient;
    }
    for (std::size_t b = 0; b < at.bodies; ++b) {
      pull(mechanism, at.body[b].body, more * at.body[b].by_place, more * at.body[b].by_turn,
           state);
    }
  };
  for (const material::StretchElement& link : material.stretches()) project(link);
  for (const material::BendElement& bend : material.bends()) project(bend);
  for (const material::TwistElement& rod : material.twists()) {
    material.twist_slope(rod, state, force_);
    double mobility = 0;
    for (std::uint32_t i = 0; i <= rod.links; ++i)
      mobility += mechanism.inverse_mass()[material.point_of(rod, i)] * force_[i].squaredNorm();
    const double hard = rod.stiffness * dt * dt;
    double& sum = *multiplier++;
    const double more = -(hard * material.twist(rod, state) + sum) / (1 + hard * mobility);
    sum += more;
    for (std::uint32_t i = 0; i <= rod.links; ++i) {
      const std::uint32_t point = material.point_of(rod, i);
      Map(state + mechanism.position(point)) += more * mechanism.inverse_mass()[point] * force_[i];
    }
  }
}

void XpbdMaterial::damp(const Mechanism& mechanism, double dt, double* state) {
  const material::MaterialForces& material = mechanism.material();
  const double* multiplier = multiplier_.data();
  double* damper = damper_.data();
  const auto slow = [&](const auto& element) {
    Constraint at;
    const double pulled = *multiplier++ / dt;  // N s, by the stiffness
    double& sum = *damper++;
    if (!(element.damping > 0) || !measure(mechanism, element, state, at)) return;
    double rate = -at.given;
    for (std::size_t p = 0; p < at.points; ++p) {
      rate += at.point[p].gradient.dot(ConstMap(state + mechanism.velocity(at.point[p].point)));
    }
    for (std::size_t b = 0; b < at.bodies; ++b) {
      const BodyChange& change = at.body[b];
      at.mobility += mobility(mechanism, change.body, change.by_place, change.by_turn);
      const double* twist = state + mechanism.twist(change.body);
      const Quat rotation = quaternion(state + mechanism.pose(change.body) + 3);
      rate += change.by_place.dot(ConstMap(twist)) +
              change.by_turn.dot(rotation.conjugate() * ConstMap(twist + 3));
    }
    const double hard = element.damping * dt;  // kg
    double more = -(hard * rate + sum) / (1 + hard * at.mobility);
    if (at.pulls) more = std::min(more, -pulled - sum);
    sum += more;
    for (std::size_t p = 0; p < at.points; ++p) {
      const auto& [point, gradient] = at.point[p];
      Map(state + mechanism.velocity(point)) += more * mechanism.inverse_mass()[point] * gradient;
    }
    for (std::size_t b = 0; b < at.bodies; ++b) {
      const BodyChange& change = at.body[b];
      const auto& body = mechanism.bodies()[change.body];
      double* twist = state + mechanism.twist(change.body);
      const Quat rotation = quaternion(state + mechanism.pose(change.body) + 3);
      Map(twist) += more * body.inverse_mass * change.by_place;
      Map(twist + 3) += more * (rotation * (body.inverse_inertia * change.by_turn));
    }
  };
  for (const material::StretchElement& link : material.stretches()) slow(link);
  for (const material::BendElement& bend : material.bends()) slow(bend);
  for (const material::TwistElement& rod : material.twists()) {
    double& sum = *damper++;
    if (!(rod.damping > 0)) continue;
    material.twist_slope(rod, state, force_);
    double mobility = 0;
    for (std::uint32_t i = 0; i <= rod.links; ++i)
      mobility += mechanism.inverse_mass()[material.point_of(rod, i)] * force_[i].squaredNorm();
    const double hard = rod.damping * dt;
    const double rate = material.twist_rate(rod, state, state + mechanism.velocity(0));
    const double more = -(hard * rate + sum) / (1 + hard * mobility);
    sum += more;
    for (std::uint32_t i = 0; i <= rod.links; ++i) {
      const std::uint32_t point = material.point_of(rod, i);
      Map(state + mechanism.velocity(point)) += more * mechanism.inverse_mass()[point] * force_[i];
    }
  }
}

constexpr std::string_view kXpbd = "xpbd";
constexpr int kRounds = 100;  // of links and touches in an impact; most take ten

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

Map vector(double* at) {
  return Map(at);
}

/// At rest a pass gives each link the T dt^2 that gravity and its neighbours took, by which the
/// next link's turn moves the particle between them: so much, over m, a link stays too long. More
/// passes share it. A bend of moment M moves it by M dt^2 / (m l), and such turns add up along a
/// rod.
double stiff_step(const World& world, double iterations) {
  constexpr double kStretched = 0.01;  // of a link; and radians, of a rod
  const double most = std::max({heaviest_link(world), tightest_link(world), heaviest_bend(world)});
  return std::sqrt(kStretched * iterations / most);
}

/// The step (s) where the settings leave it open.
double own_step(const World& world, double iterations) {
  constexpr double kLeast = 1e-5, kMost = 1e-3;
  return std::clamp(stiff_step(world, iterations), kLeast, kMost);
}

class Xpbd final : public SteppedMethod {
 public:
  explicit Xpbd(const Settings& settings)
      : SteppedMethod(kXpbd, number(settings, "step")),
        own_step_(number(settings, "step")),
        compliance_(number(settings, "compliance")),
        iterations_(static_cast<int>(number(settings, "iterations"))) {}

 private:
  static constexpr int kNone = -1;
  struct Carriers {
    int a = kNone, b = kNone;  // indices into Mechanism::body_points()
    bool any() const { return a != kNone || b != kNone; }
  };

  double prepare(Mechanism& mechanism, const World& world) override;
  bool stops_stretch() const override { return false; }  // velocities come from positions
  void step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) override;
  void share_impact(Mechanism& mechanism, double time, std::vector<double>& state);
  void flow(Mechanism& mechanism, double time, double dt, std::vector<double>& state);
  void pass(const Mechanism& mechanism, double softness, double* state);

  double own_step_;    // s; zero until the first world is known
  double compliance_;  // m/N
  int iterations_;
  double step_cycles_ = 0, pass_cycles_ = 0;  // see Counters::cycles
  std::vector<Carriers> carriers_;            // per row
  std::vector<double> multiplier_, flown_;    // kg m per row; the state after free motion
  std::vector<double> started_;               // the state before it
  std::vector<Vec3> force_;                   // N, per point, of what flows past it
  contact::ConnectorContacts connectors_;
  contact::BodyContacts bodies_;
  Projection projection_;  // where bodies touch
  XpbdMaterial material_;
};

double Xpbd::prepare(Mechanism& mechanism, const World& world) {
  connectors_.rebuild(mechanism, world);
  bodies_.rebuild(mechanism, world);
  if (bodies_.any()) projection_.rebuild(mechanism);
  material_.rebuild(mechanism);
  resize_within(mechanism.row_room(), mechanism.rows().size(), multiplier_);
  flown_.reserve(mechanism.state_room());
  started_.reserve(mechanism.state_room());
  carriers_.reserve(mechanism.row_room());
  carriers_.assign(mechanism.rows().size(), {});
  for (const auto& end : mechanism.row_ends()) {
    Carriers& carriers = carriers_[end.row];
    (end.sign > 0 ? carriers.a : carriers.b) = static_cast<int>(end.body_point);
  }
  // In a pass each row waits for the one before: a difference, a norm, two divisions and a move,
  // one after another. A end turns its body.
  const auto count = [](std::size_t number) { return static_cast<double>(number); };
  pass_cycles_ =
      20 + 80 * count(mechanism.rows().size()) + 450 * count(mechanism.row_ends().size());
  pass_cycles_ += mechanism.material().cycles();
  step_cycles_ = 150 + 20 * count(mechanism.points()) + 700 * count(mechanism.bodies().size());
  if (own_step_ == 0) own_step_ = own_step(world, iterations_);
  return own_step_;
}

void Xpbd::step(Mechanism& mechanism, double time, double dt, std::vector<double>& state) {
  if (connectors_.any() || bodies_.any()) started_ = state;
  if (material_.any()) {
    material_.begin();
    material_.blow(mechanism, dt, state);
  }
  if (mechanism.has_winches()) flow(mechanism, time, dt, state);
  const Vec3 gain = dt * mechanism.gravity();
  for (std::size_t p = 0; p < mechanism.points(); ++p)
    vector(&state[mechanism.velocity(p)]) += gain;
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    vector(&state[mechanism.twist(b)]) += gain;
  }
  drift(mechanism, dt, state);
  mechanism.place(time + dt, state.data());
  flown_ = state;

  std::ranges::fill(multiplier_, 0.0);
  for (int i = 0; i < iterations_; ++i) {
    check_stop();
    pass(mechanism, compliance_ / (dt * dt), state.data());
    if (material_.any()) material_.pass(mechanism, dt, state.data());
  }
  if (connectors_.any()) connectors_.move_out(mechanism, time + dt, dt, started_, state);
  if (bodies_.any()) bodies_.move_out(mechanism, time + dt, dt, started_, state);
  counters_.solves += static_cast<std::uint64_t>(iterations_);
  counters_.cycles += step_cycles_ + iterations_ * pass_cycles_;

  const std::size_t velocities = mechanism.velocity(0);
  for (std::size_t i = 0; i < 3 * mechanism.points(); ++i) {
    state[velocities + i] += (state[i] - flown_[i]) / dt;
  }
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    const std::size_t q = mechanism.pose(b);
    Map velocity(&state[mechanism.twist(b)]), spin(&state[mechanism.twist(b) + 3]);
    velocity += (ConstMap(&state[q]) - ConstMap(&flown_[q])) / dt;
    const Quat turned = quaternion(&state[q + 3]) * quaternion(&flown_[q + 3]).conjugate();
    spin += angle(turned) / dt;
  }
  if (material_.damps()) {
    material_.begin_damping();
    for (int i = 0; i < iterations_; ++i) material_.damp(mechanism, dt, state.data());
  }
  if (connectors_.any()) connectors_.rebound(mechanism, dt, started_, state);
  if (bodies_.any() && bodies_.rebound(mechanism, dt, started_, state)) {
    share_impact(mechanism, time + dt, state);
  }
}

/// Rigid links answer an impact of a body at once: the impulses of the links and of the touches, in
/// turn. A step later the body would have left already.
void Xpbd::share_impact(Mechanism& mechanism, double time, std::vector<double>& state) {
  const bool rigid = compliance_ == 0 && !mechanism.has_strings();
  if (!rigid || mechanism.row_ends().empty()) return;
  for (int round = 0; round < kRounds; ++round) {
    projection_.rates(mechanism, time, state);
    ++counters_.solves;
    if (bodies_.push(mechanism, state)) return;
  }
}

/// Changes velocities by what flows past the particles.
void Xpbd::flow(Mechanism& mechanism, double time, double dt, std::vector<double>& state) {
  mechanism.place(time, state.data());
  force_.assign(mechanism.points(), Vec3::Zero());
  mechanism.add_flow(state.data(), force_);
  for (std::size_t p = 0; p < force_.size(); ++p) {
    vector(&state[mechanism.velocity(p)]) += dt * mechanism.inverse_mass()[p] * force_[p];
  }
}

/// Goes through the rows once; `softness` is the compliance over dt^2, 1/kg.
void Xpbd::pass(const Mechanism& mechanism, double softness, double* state) {
  const auto& rows = mechanism.rows();
  const auto& w = mechanism.inverse_mass();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    Map a(state + mechanism.position(row.a)), b(state + mechanism.position(row.b));
    const Vec3 gap = b - a;
    Vec3 along;
    double violation;
    if (row.axis == Row::kAlongLink) {
      const double length = gap.norm();
      if (length == 0) continue;  // no direction: the neighbours part the points
      along = gap / length;
      violation = length - row.rest;
    } else {
      along = Vec3::Unit(row.axis);
      violation = gap[row.axis];
    }
    const Carriers& carriers = carriers_[r];
    const auto carried = [&](int at) -> const Mechanism::BodyPoint& {
      return mechanism.body_points()[static_cast<std::size_t>(at)];
    };
    const double wa =
        carriers.a == kNone ? w[row.a] : mobility(mechanism, carried(carriers.a), along, state);
    const double wb =
        carriers.b == kNone ? w[row.b] : mobility(mechanism, carried(carriers.b), along, state);
    const double stiff = wa + wb + softness;
    if (stiff == 0) continue;  // both ends are held
    double change = -(violation + softness * multiplier_[r]) / stiff;
    if (row.pulls) change = std::min(change, -multiplier_[r]);  // it pushes nothing
    multiplier_[r] += change;
    const Vec3 move = change * along;
    a -= w[row.a] * move;
    b += w[row.b] * move;
    if (carriers.a != kNone) pull(mechanism, carried(carriers.a), -move, state);
    if (carriers.b != kNone) pull(mechanism, carried(carriers.b), move, state);
  }
}

}  // namespace

MethodInfo xpbd_method() {
  return {
      .name = kXpbd,
      .summary = "extended position-based dynamics with small steps",
      .settings =
          {step_setting("Length of a time step; 0: 1 ms, or down to 10 us under heavy loads or "
                        "with stiff rods, so that links stretch by at most 1% at rest. Raising it "
                        "costs less and errs more.",
                        12),
           {.name = "compliance",
            .meaning = "Compliance of each link; 0: rigid links. Raising it softens the connector.",
            .unit = "m/N",
            .fallback = 0.0},
           {.name = "iterations",
            .meaning =
                "Solver passes over all links per step. Raising it reduces stretch and costs more.",
            .unit = "1",
            .fallback = 1.0,
            .minimum = 1,
            .maximum = 10000,
            .whole = true,
            .sweep = {1.0, 4.0, 16.0}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Xpbd>(settings);
      },
      .fit =
          [](const World& world, Settings settings) {
            double& step = std::get<double>(settings.find("step")->second);
            if (step == 0) step = own_step(world, number(settings, "iterations"));
            return settings;
          },
      .longest_step =
          [](const World& world, const Settings& settings) {
            return stiff_step(world, number(settings, "iterations"));
          },
      .longest_step_law = "1% of stretch at rest, dt^2 = m l / 100 T",
      .abilities = abilities_on_mechanisms(),
      .companion = [](const MethodInfo& xpbd,
                      const Settings& settings) { return with_step_doubled(xpbd, settings, 1); },
      .particle_memory = 250,
  };
}

}  // namespace taut::methods
