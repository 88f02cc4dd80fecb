#include "sim/methods/stepped.h"

#include <cmath>
#include <complex>

#include "sim/motion/stop.h"

namespace taut::methods {
namespace {

/// |R(q)|, the growth over a step of x' = q x / dt under RK4.
double rk4_growth(std::complex<double> q) {
  return std::abs(1.0 + q * (1.0 + q / 2.0 * (1.0 + q / 3.0 * (1.0 + q / 4.0))));
}

}  // namespace

void SteppedMethod::advance(World& world, double until) {
  if (!built_ || world.topology != topology_) {
    require(name_, world);
    mechanism_.rebuild(world);
    const bool stops = stops_stretch() && !mechanism_.has_strings();  // which may part as they like
    if (stops) projection_.rebuild(mechanism_);
    topology_ = world.topology;
    resize_within(mechanism_.state_room(), mechanism_.state_size(), state_);
    mechanism_.load(world, state_);
    if (built_ && stops) projection_.rates(mechanism_, world.time, state_);
    built_ = true;
    limit_ = prepare(mechanism_, world);
  } else {
    mechanism_.load(world, state_);
  }
  double time = world.time;
  if (!mechanism_.has_winches() || step_ > 0) {
    go_on(world, time, until);
  } else {
    // The longest step changes with the links' lengths.
    constexpr double kSteps = 100;
    while (time < until) {
      mechanism_.place(time, state_.data());
      limit_ = prepare(mechanism_, world);
      const double next = until - time > 2 * kSteps * limit_ ? time + kSteps * limit_ : until;
      go_on(world, time, next);
      time = next;
    }
  }
  mechanism_.store(state_, until, world);
}

void SteppedMethod::go_on(const World& world, double time, double until) {
  if (!(step_ > 0) && !((until - time) / limit_ <= kMostRunSteps)) {
    throw Diverged(name_, time, counters_.steps, world.connectors.front().name, 0,
                   "the longest step that is stable is too short for a run");
  }
  const StepTimes times(time, until, step_ > 0 ? step_ : limit_);
  for (std::uint64_t i = 0; i < times.count; ++i) {
    check_stop();
    step(mechanism_, times.at(i), times.dt, state_);
    ++counters_.steps;
    mechanism_.follow(times.at(i + 1), state_);
    if (const auto broken = mechanism_.broken_link(state_.data())) {
      throw Diverged(name_, times.at(i + 1), counters_.steps,
                     world.connectors[broken->connector].name, broken->link,
                     "diverged (a link is not finite or a hundred times too long)");
    }
  }
}

Abilities abilities_on_mechanisms() {
  return {Features::all() - Feature::joint_in_flow - kPulleyFeatures -
              Features{Feature::span, Feature::string_rebound},
          {{Feature::winch, kUnlikeReels, {}, Apart::Within::connector},
           {Feature::clamp_on_body, Feature::twist, {}, Apart::Within::connector},
           {kMaterialFeatures - Features{Feature::stretch, Feature::air, Feature::material_on_body},
            Feature::strings,
            {},
            Apart::Within::connector}}};
}

void row_mobility(const Mechanism& mechanism, std::vector<double>& rows) {
  resize_within(mechanism.row_room(), mechanism.rows().size(), rows);
  const auto& mobile = mechanism.inverse_mass();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    rows[r] = mobile[mechanism.rows()[r].a] + mobile[mechanism.rows()[r].b];
  }
  for (const auto& end : mechanism.row_ends()) {
    const auto& carried = mechanism.body_points()[end.body_point];
    const auto& body = mechanism.bodies()[carried.body];
    rows[end.row] += body.inverse_mass + carried.local.squaredNorm() * body.inverse_inertia.norm();
  }
}

void drift(const Mechanism& mechanism, double dt, std::vector<double>& state) {
  const std::size_t velocities = mechanism.velocity(0);
  for (std::size_t i = 0; i < 3 * mechanism.points(); ++i) state[i] += dt * state[velocities + i];
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    double* q = &state[mechanism.pose(b)];
    double* u = &state[mechanism.twist(b)];
    for (int i = 0; i < 3; ++i) q[i] += dt * u[i];
    Quat rotation = quaternion(q + 3);
    Vec3 spin(u[3], u[4], u[5]);
    mechanism.bodies()[b].rotation.turn(rotation, spin, dt);
    set_quaternion(rotation, q + 3);
    Eigen::Map<Vec3>(u + 3) = spin;
  }
}

Integrator integrator_named(std::string_view name) {
  if (name == "explicit-euler") return Integrator::explicit_euler;
  return name == "rk4" ? Integrator::rk4 : Integrator::semi_implicit_euler;
}

double stability_limit(Integrator integrator, double damping_ratio) {
  const double z = damping_ratio;
  if (integrator == Integrator::semi_implicit_euler) return 2 * (std::sqrt(1 + z * z) - z);
  if (integrator == Integrator::explicit_euler) {
    return z <= 1 ? 2 * z : 2 * (z - std::sqrt(z * z - 1));
  }
  // The largest h = w dt at which the oscillator's faster root s/w = -z - sqrt(z^2 - 1) does not
  // grow.
  const std::complex<double> root = -z - std::sqrt(std::complex<double>(z * z - 1));
  double stable = 0, unstable = 4;
  for (int halving = 0; halving < 50; ++halving) {
    const double h = (stable + unstable) / 2;
    (rk4_growth(h * root) <= 1 ? stable : unstable) = h;
  }
  return stable;
}

void Stepper::prepare(const Mechanism& mechanism) {
  const std::size_t size = mechanism.state_size(), room = mechanism.state_room();
  resize_within(mechanism.row_room(), mechanism.rows().size(), tension_);
  resize_within(room, size, k1_);
  if (integrator_ != Integrator::rk4) return;
  for (auto* workspace : {&stage_, &k2_, &k3_, &k4_}) resize_within(room, size, *workspace);
}

void Stepper::add(double dt, const std::vector<double>& k, std::vector<double>& state) {
  for (std::size_t i = 0; i < state.size(); ++i) state[i] += dt * k[i];
}

void Stepper::stage(const std::vector<double>& state, double dt, const std::vector<double>& k) {
  for (std::size_t i = 0; i < state.size(); ++i) stage_[i] = state[i] + dt * k[i];
}

void Stepper::kick_then_drift(const Mechanism& mechanism, double dt, std::vector<double>& state) {
  for (std::size_t i = mechanism.velocity(0); i < state.size(); ++i) state[i] += dt * k1_[i];
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    // Torque alone kicks the spin: drift() knows without error what the body does by itself.
    Eigen::Map<Vec3> spin(&state[mechanism.twist(b) + 3]);
    spin -= dt * mechanism.bodies()[b].gyration;
  }
  drift(mechanism, dt, state);
}

void Stepper::combine(double dt, std::vector<double>& state) {
  for (std::size_t i = 0; i < state.size(); ++i) {
    state[i] += dt / 6 * (k1_[i] + 2 * (k2_[i] + k3_[i]) + k4_[i]);
  }
}

void Stepper::normalize(const Mechanism& mechanism, std::vector<double>& state) {
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    Eigen::Map<Eigen::Vector4d>(&state[mechanism.pose(b) + 3]).normalize();
  }
}

}  // namespace taut::methods
