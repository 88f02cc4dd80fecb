#include "sim/methods/xpbd.h"

#include <algorithm>
#include <cmath>

#include "sim/contact/body_contacts.h"
#include "sim/contact/connector_contacts.h"
#include "sim/measure/frequency.h"
#include "sim/methods/carried.h"
#include "sim/methods/stepped.h"
#include "sim/methods/xpbd_material.h"
#include "sim/motion/stop.h"
#include "sim/run/companion.h"

namespace taut::methods {
namespace {

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
          {step_setting(
               "Length of a time step; 0: 1 ms, down to 10 us where something heavy hangs or "
               "rods are stiff, so that links stretch by 1% at rest. Raising it costs less and "
               "errs more.",
               12),
           {.name = "compliance",
            .meaning = "Stretch of each link per newton; 0: rigid links. Raising it softens the "
                       "connector.",
            .unit = "m/N",
            .fallback = 0.0},
           {.name = "iterations",
            .meaning = "Passes over all links in a step. Raising it stretches less and costs more.",
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
