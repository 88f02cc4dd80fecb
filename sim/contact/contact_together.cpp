// Where links touch: all links and all touches of a world as one system.
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_motion.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;

constexpr double kOfRounding = 1e-12;  // of velocities or accelerations: by rounding
constexpr int kAtOnce = 20;            // changes of all strings that have to
constexpr int kOneByOne = 1000;        // of the last of these alone, which ends (Murty, 1974)
constexpr int kReturns = 20;

}  // namespace

ContactMotion::Motion ContactMotion::no_motion() const {
  return {std::vector<Vec3>(beads_.size(), Vec3::Zero()),
          std::vector<Vec6>(capsules_.size(), Vec6::Zero())};
}

Vec3 ContactMotion::velocity_of(const Motion& motion, std::uint32_t point) const {
  const std::uint32_t c = carrier(point);
  if (c == kNoBody) return motion.points[point];
  const Mechanism::BodyPoint& carried = mechanism_.body_points()[c];
  return velocity_at(motion.bodies[carried.body], carried.arm);
}

/// The velocity of what touches there: of a body past the other, if there is one.
Vec3 ContactMotion::passing(const Motion& motion, const BodyTouch& at) const {
  if (!is_part(at.body)) return contact::passing(motion.bodies, at);
  const Part& own = part(at.body);
  return (1 - at.share) * velocity_of(motion, own.first) + at.share * velocity_of(motion, own.next);
}

/// Adds what an impulse at a point does to it, or to the body that carries it.
void ContactMotion::give(std::uint32_t point, const Vec3& impulse, Motion& motion) const {
  const std::uint32_t c = carrier(point);
  if (c == kNoBody) {
    motion.points[point] += mechanism_.inverse_mass()[point] * impulse;
    return;
  }
  const Mechanism::BodyPoint& carried = mechanism_.body_points()[c];
  Vec6 wrench;
  wrench << impulse, carried.arm.cross(impulse);
  motion.bodies[carried.body] += body_mobility_[carried.body] * wrench;
}

/// Adds what an impulse of a touch does: to the beads of a link by the lever rule.
void ContactMotion::give(const BodyTouch& at, const Vec3& impulse, Motion& motion) const {
  if (is_part(at.body)) {
    const Part& own = part(at.body);
    give(own.first, (1 - at.share) * impulse, motion);
    if (at.share != 0) give(own.next, at.share * impulse, motion);
    return;
  }
  const auto turn = [&](std::uint32_t body, const Vec3& arm, const Vec3& by) {
    Vec6 wrench;
    wrench << by, arm.cross(by);
    motion.bodies[body] += body_mobility_[body] * wrench;
  };
  turn(at.body, at.arm, impulse);
  if (at.other != kNoBody) turn(at.other, at.other_arm, -impulse);
}

/// Adds what tensions do.
void ContactMotion::pull(std::span<const double> tension, std::span<const Vec3> along,
                         Motion& motion) const {
  const auto& rows = mechanism_.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (tension[r] == 0) continue;
    give(rows[r].a, tension[r] * along[r], motion);
    give(rows[r].b, -tension[r] * along[r], motion);
  }
}

/// The tensions under which no link gets longer that would by `rate` and a motion, to which they
/// add what they do.
std::vector<double> ContactMotion::answer(std::span<const double> rate, std::span<const Vec3> along,
                                          Motion& motion) const {
  const auto& rows = mechanism_.rows();
  std::vector<double> tension(rows.size());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (!pulls_[r]) continue;
    tension[r] =
        rate[r] + along[r].dot(velocity_of(motion, rows[r].b) - velocity_of(motion, rows[r].a));
  }
  system_.solve(tension);
  for (std::size_t r = 0; r < rows.size(); ++r) tension[r] *= pulls_[r];
  pull(tension, along, motion);
  return tension;
}

/// How touches respond to what each of them gives, with all links; the directions of these.
std::span<const Vec3> ContactMotion::assemble_together() {
  const std::span<const Vec3> along = pulling();
  free_mobilities();
  for (std::size_t p = 0; p < mobility_.size(); ++p) {
    mobility_[p] = mechanism_.inverse_mass()[p] * Mat3::Identity();
  }
  system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
  ++solves_;
  const std::vector<double> at_rest(along.size(), 0);
  const auto count = static_cast<Eigen::Index>(body_touches_.size());
  Eigen::MatrixXd coupling(3 * count, 3 * count);
  std::vector<double> inverse_masses;
  for (Eigen::Index k = 0; k < count; ++k) {
    const BodyTouch& by = body_touches_[static_cast<std::size_t>(k)];
    inverse_masses.push_back(inverse_mass(by));
    for (int axis = 0; axis < 3; ++axis) {
      Motion motion = no_motion();
      give(by, Vec3::Unit(axis), motion);
      answer(at_rest, along, motion);
      for (Eigen::Index i = 0; i < count; ++i) {
        coupling.block<3, 1>(3 * i, 3 * k + axis) =
            passing(motion, body_touches_[static_cast<std::size_t>(i)]);
      }
    }
  }
  body_system_.assemble(coupling, inverse_masses);
  return along;
}

/// The response of all where rows get longer at the rates `start` without: in the touches' present
/// states (`held`) or in those that the laws ask for. Finds tension_, what is added, and in change_
/// how rows go on getting longer. False: no solution.
bool ContactMotion::respond_together(std::span<const double> start, bool held) {
  const std::span<const Vec3> along = assemble_together();
  const Motion free{free_, body_free_};
  Motion pulled = no_motion(), given = no_motion();
  tension_ = answer(start, along, pulled);
  std::vector<Vec3> bare;
  for (const BodyTouch& at : body_touches_) bare.push_back(passing(free, at) + passing(pulled, at));
  if (held) {
    body_system_.hold(bare, body_touches_);
  } else if (!body_system_.solve(bare, body_touches_, 0)) {
    return false;
  }
  for (const BodyTouch& at : body_touches_) give(at, at.given, given);
  const Motion touched = given;
  const std::vector<double> at_rest(along.size(), 0);
  const std::vector<double> more = answer(at_rest, along, given);
  for (std::size_t r = 0; r < more.size(); ++r) tension_[r] += more[r];
  for (std::size_t p = 0; p < added_.size(); ++p) {
    added_[p] = pulled.points[p] + given.points[p];
    pulled_[p] = added_[p] - touched.points[p];
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    body_added_[b] = pulled.bodies[b] + given.bodies[b];
    body_pulled_[b] = body_added_[b] - touched.bodies[b];
  }
  for (const auto& carried : mechanism_.body_points()) {
    added_[carried.point] = velocity_at(body_added_[carried.body], carried.arm);
  }
  const auto& rows = mechanism_.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    change_[r] = start[r] + mechanism_.direction()[r].dot(added_[rows[r].b] - added_[rows[r].a]);
  }
  return true;
}

/// Tensions and what touches give, by the laws of all.
void ContactMotion::balance_together(std::span<const double> start) {
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    pulls_[r] = taut_[r] && (pulls_[r] || !mechanism_.rows()[r].pulls);
  }
  for (int i = 0; i < kAtOnce + kOneByOne; ++i) {
    if (!respond_together(start, false)) break;
    if (!swap_strings(i < kAtOnce)) return;
    for (BodyTouch& at : body_touches_) at.given.setZero();
  }
  throw Unresolved{0, "contact and friction have no solution"};
}

/// Lets strings go that push, and others pull that would part; the last of them alone or `all`.
/// Whether there were any.
bool ContactMotion::swap_strings(bool all) {
  if (!mechanism_.has_strings()) return false;
  double scale = 1;
  for (std::size_t p = 0; p < free_.size(); ++p) {
    scale = std::max({scale, free_[p].norm(), pulled_[p].norm()});
  }
  bool any = false;
  for (std::size_t r = pulls_.size(); r-- > 0 && (all || !any);) {
    const Row& row = mechanism_.rows()[r];
    if (!row.pulls || !taut_[r]) continue;
    const double by =
        pulls_[r] ? -(inverse_mass(row.a) + inverse_mass(row.b)) * tension_[r] : change_[r];
    if (by <= kOfRounding * scale) continue;
    pulls_[r] = !pulls_[r];
    any = true;
  }
  return any;
}

/// Takes all back to lengths and surfaces, and from velocities that leave them; returns the largest
/// of what was off (m).
double ContactMotion::project_together(double time, State& state) {
  double worst = 0;
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    double* q = &state[mechanism_.pose(b) + 3];
    set_quaternion(quaternion(q).normalized(), q);
  }
  for (int i = 0; i < kReturns; ++i) {
    mechanism_.update(time, state.data());
    worst = 0;
    std::vector<Vec3> apart, passes;
    for (BodyTouch& at : body_touches_) {
      const SpotGap near = aim(at, state);
      worst = std::max(worst, std::abs(near.distance));
      apart.push_back(near.distance * near.normal);
      passes.push_back(passing(at, state));
    }
    for (std::size_t r = 0; r < pulls_.size(); ++r) {
      if (pulls_[r]) worst = std::max(worst, std::abs(mechanism_.violation()[r]));
    }
    const std::span<const Vec3> along = assemble_together();
    const auto back = [&](std::span<const double> rate, std::vector<Vec3> off, bool places) {
      std::vector<BodyTouch> touches = body_touches_;
      Motion way = no_motion();
      answer(rate, along, way);
      for (std::size_t k = 0; k < touches.size(); ++k) {
        Touch& touch = touches[k].touch;
        touch.least = touch.slide = 0;
        touch.surface.setZero();
        if (places) touch.state = Touch::State::slides;
        off[k] += passing(way, touches[k]);
      }
      body_system_.hold(off, touches);
      Motion given = no_motion();
      for (const BodyTouch& at : touches) give(at, at.given, given);
      answer(std::vector<double>(rate.size(), 0), along, given);
      shift(way, places, state);
      shift(given, places, state);
    };
    back(mechanism_.rate(), passes, false);
    if (worst < 1e-3 * touching_) break;
    back(mechanism_.violation(), apart, true);
  }
  mechanism_.place(time, state.data());
  return worst;
}

/// Adds a motion to velocities, or a way to places.
void ContactMotion::shift(const Motion& way, bool places, State& state) const {
  const std::size_t offset = places ? mechanism_.position(0) : mechanism_.velocity(0);
  for (std::size_t p = 0; p < way.points.size(); ++p) Map(&state[offset + 3 * p]) += way.points[p];
  for (std::size_t b = 0; b < way.bodies.size(); ++b) {
    if (!places) {
      Eigen::Map<Vec6>(&state[mechanism_.twist(b)]) += way.bodies[b];
      continue;
    }
    double* q = &state[mechanism_.pose(b)];
    Map{q} += way.bodies[b].head<3>();
    rotate(way.bodies[b].tail<3>(), q + 3);
  }
}

}  // namespace taut::contact
