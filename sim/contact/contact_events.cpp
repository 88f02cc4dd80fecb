// The consequences of an event: impacts and new active sets, as nonsmooth systems of all rows.
#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/contact/contact_motion.h"
#include "sim/contact/damping.h"
#include "sim/motion/hash.h"
#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;

constexpr double kSolved = 1e-12;   // of the velocities or accelerations
constexpr double kArrives = 1e-10;  // m/s
constexpr double kImmobile = 1e-12;
constexpr int kTrials = 8;
constexpr int kSweeps = 8;       // along the rows and back, of a relaxation
constexpr int kShrinkings = 30;  // of the interval of a tension
constexpr double kFlat = 1e-12;  // m, m/s: out of a plane by rounding

}  // namespace

/// Marks all beads at surfaces as open or sliding, where they do not stick already.
void ContactMotion::find_touches(const State& state) {
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (radius_[p] < 0) continue;
    Bead& bead = beads_[p];
    int count = 0;
    const Bead was = bead;
    for (std::uint32_t o = 0; o < obstacles_.size(); ++o) {
      if (!obstacles_[o].touches(category_[p])) continue;
      const SurfaceDistance near =
          gap(obstacles_[o], frames_[o].pose(), place(state, p), radius_[p]);
      if (near.distance > touching_) continue;
      Bead found{.mode = Mode::slides, .obstacle = o, .touch = {}};
      if (was.mode == Mode::sticks && was.obstacle == o) found = was;
      found.touch.normal = near.normal;
      found.touch.stick = obstacles_[o].static_friction;
      found.touch.slide = obstacles_[o].kinetic_friction;
      const Vec3 passing = velocity(state, p) - surface(found, place(state, p)).velocity;
      if (near.normal.dot(passing) > kArrives) continue;  // it leaves
      found.touch.sliding = passing - near.normal.dot(passing) * near.normal;
      bead = found;
      ++count;
    }
    if (count == 0) bead = {};
    if (count > 1) throw Unresolved{0, "a bead touches two obstacles at once"};
  }
  find_body_touches(state);
}

/// The direction of sliding. In motions in a plane exactly along it: sliding out of it by rounding
/// is a stiff equation, for friction turns slow sliding at once.
Vec3 ContactMotion::heading(const Vec3& across, const Vec3& ahead) const {
  const Vec3 within = across - aside_.dot(across) * aside_;
  return (within.dot(ahead) < 0 ? -1 : 1) * within.normalized();
}

/// How a bead goes on without what it touches, and with it.
Response ContactMotion::response(Bead& bead, const Vec3& bare) const {
  Touch& touch = bead.touch;
  if (bead.mode == Mode::open) return {bare, Mat3::Identity()};
  if (bead.ahead.isZero(0)) return respond(bare, {&touch, 1});
  // Already sliding: friction is against that, whatever accelerates it.
  touch.push = touch.least - touch.normal.dot(bare);
  if (!(touch.push > 0)) {
    touch.state = Touch::State::open;
    return {bare, Mat3::Identity()};
  }
  touch.state = Touch::State::slides;
  const Vec3 force = touch.normal - touch.slide * bead.ahead;
  return {bare + touch.push * force, Mat3::Identity() - force * touch.normal.transpose()};
}

/// The response of all beads to tension_; returns the largest error of a row.
double ContactMotion::measure(std::span<const double> start) {
  const auto& mobile = mechanism_.inverse_mass();
  const auto& rows = mechanism_.rows();
  const auto& along = mechanism_.direction();
  std::ranges::fill(pulled_, Vec3::Zero());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    pulled_[rows[r].a] += mobile[rows[r].a] * tension_[r] * along[r];
    pulled_[rows[r].b] -= mobile[rows[r].b] * tension_[r] * along[r];
  }
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    const Response found = response(beads_[p], free_[p] + pulled_[p]);
    mobility_[p] = mobile[p] * found.derivative;
    added_[p] = mobile[p] > 0 ? Vec3(found.velocity - free_[p]) : Vec3(Vec3::Zero());
  }
  couple_bodies(tension_, along, false);
  double worst = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    change_[r] = start[r] + along[r].dot(added_[rows[r].b] - added_[rows[r].a]);
    if (taut_[r]) worst = std::max(worst, pulls_[r] ? std::abs(change_[r]) : change_[r]);
  }
  return worst;
}

/// Tensions (or impulses) under which no row's error, `start` without them, is left.
void ContactMotion::balance(std::span<const double> start) {
  if (!parts_.empty()) return balance_together(start);
  Damping damping;
  for (int i = 0; i < kIterations; ++i) {
    double worst = measure(start);
    if (mechanism_.has_strings()) {
      sort_strings();
      worst = measure(start);
    }
    double scale = 1;
    for (std::size_t p = 0; p < beads_.size(); ++p) {
      scale = std::max({scale, free_[p].squaredNorm(), pulled_[p].squaredNorm()});
    }
    if (worst <= kSolved * std::sqrt(scale)) return;
    if (!std::isfinite(worst)) break;
    Hash pattern;
    for (const Bead& bead : beads_) pattern.word(static_cast<std::uint64_t>(bead.touch.state));
    for (const BodyTouch& at : body_touches_) {
      pattern.word(static_cast<std::uint64_t>(at.touch.state));
    }
    if (mechanism_.has_strings()) {
      for (const char pulls : pulls_) pattern.word(std::uint64_t(pulls != 0));
    }
    if (damping.relaxes(pattern.value())) {
      relax(start);
      continue;
    }
    const std::span<const Vec3> along = pulling();
    system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
    for (std::size_t r = 0; r < change_.size(); ++r) change_[r] *= pulls_[r];
    const std::vector<double> error = change_;
    system_.solve(change_);
    ++solves_;
    for (std::size_t r = 0; r < change_.size(); ++r) {
      const bool sticks = system_.left_out(r) && std::abs(error[r]) > kSolved * std::sqrt(scale);
      tension_[r] += damping.share() * (sticks ? until_it_slides(r, error[r]) : change_[r]);
    }
  }
  throw Unresolved{0, "contact and friction have no solution"};
}

/// By how much more a row pulls that leads apart what sticks, until some of it slides.
double ContactMotion::until_it_slides(std::size_t row, double error) const {
  double mobile = 0, size = 0;
  for (const std::size_t p : {mechanism_.rows()[row].a, mechanism_.rows()[row].b}) {
    mobile += mechanism_.inverse_mass()[p];
    size += free_[p].norm() + pulled_[p].norm();
  }
  return mobile > 0 ? std::copysign(size / mobile, error) : 0;
}

/// Nonlinear Gauss-Seidel along the rows and back (Jean 1999, section 5).
void ContactMotion::relax(std::span<const double> start) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    check_stop();
    for (std::size_t r = 0; r < start.size(); ++r) relax_row(r, start[r]);
    for (std::size_t r = start.size(); r-- > 0;) relax_row(r, start[r]);
  }
}

void ContactMotion::relax_row(std::size_t row, double start) {
  const std::size_t a = mechanism_.rows()[row].a, b = mechanism_.rows()[row].b;
  const double mobile_a = mechanism_.inverse_mass()[a], mobile_b = mechanism_.inverse_mass()[b];
  const Vec3& along = mechanism_.direction()[row];
  const bool string = mechanism_.rows()[row].pulls;
  if (!taut_[row] || is_carried_[a] || is_carried_[b]) return;
  for (int i = 0; i < kTrials && mobile_a + mobile_b > 0; ++i) {
    Bead bead_a = beads_[a], bead_b = beads_[b];
    const Response at_a = response(bead_a, free_[a] + pulled_[a]);
    const Response at_b = response(bead_b, free_[b] + pulled_[b]);
    double error = start, slope = 0;
    for (const auto& [mobile, found, free, sign] :
         {std::tuple(mobile_a, at_a, free_[a], -1.0), std::tuple(mobile_b, at_b, free_[b], 1.0)}) {
      if (mobile == 0) continue;
      error += sign * along.dot(found.velocity - free);
      const double gives = along.dot(found.derivative * along);
      if (std::abs(gives) > kImmobile) slope += mobile * gives;
    }
    if (std::abs(error) <= 1e-2 * kSolved || !(slope > 0)) return;
    double more = error / slope;
    if (string) more = std::max(more, -tension_[row]);
    if (more == 0) return;
    tension_[row] += more;
    pulled_[a] += mobile_a * more * along;
    pulled_[b] -= mobile_b * more * along;
  }
}

/// Stops what arrives; whether anything did.
bool ContactMotion::arrive(double time, State& state) {
  bool any = find_taut(time, state);
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    free_[p] = velocity(state, p);
    bead.ahead.setZero();
    if (bead.mode == Mode::open) continue;
    Touch& touch = bead.touch;
    touch.surface = surface(bead, place(state, p)).velocity;
    const double carried = touch.normal.dot(touch.surface);
    const double into = carried - touch.normal.dot(free_[p]);
    any = any || into > kArrives;
    const double bounce = obstacles_[bead.obstacle].restitution * into;
    touch.least = carried + (bounce > slowest_ ? bounce : 0);
  }
  any = bodies_arrive(state) || any;
  if (!any) return false;
  mechanism_.update(time, state.data());
  std::ranges::copy(mechanism_.rate(), start_.begin());
  const std::vector<double> tension = tension_;
  std::ranges::fill(tension_, 0.0);
  balance(start_);
  if (!is_driven()) lower_bounces(state);
  tension_ = tension;
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] > 0) Map(&state[mechanism_.velocity(p)]) += added_[p];
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    Eigen::Map<Vec6>{&state[mechanism_.twist(b)]} += body_added_[b];
  }
  mechanism_.place(time, state.data());  // what bodies carry
  return true;
}

/// The active set: which touches close, and which of them stick, so that accelerations agree with
/// the laws.
void ContactMotion::choose(double time, const State& state) {
  scratch_ = state;
  find_taut(time, scratch_);
  mechanism_.update(time, scratch_.data());
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    free_[p] = weight(p);
    bead.ahead.setZero();
    if (bead.mode == Mode::open) continue;
    const Vec3 at = place(state, p);
    Touch& touch = bead.touch;
    const double speed = touch.sliding.norm();
    touch.least = least_acceleration(bead, at, velocity(state, p));
    touch.surface = surface(bead, at).acceleration;
    if (speed > kStill) bead.ahead = heading(touch.sliding, touch.sliding);
    touch.sliding.setZero();
  }
  ask_of_bodies(scratch_);
  for (std::size_t r = 0; r < start_.size(); ++r) start_[r] = mechanism_.free_acceleration(r);
  balance(start_);
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    Touch& touch = bead.touch;
    if (bead.mode == Mode::open) continue;
    if (touch.state == Touch::State::open) {
      bead = {};
      continue;
    }
    const bool stuck = bead.mode == Mode::sticks;
    const bool sticks = touch.state == Touch::State::sticks && touch.stick > 0;
    bead.mode = sticks ? Mode::sticks : Mode::slides;
    const FrameMotion& frame = frames_[bead.obstacle];
    if (sticks && !stuck) {
      bead.anchor = frame.rotation.conjugate() * (place(state, p) - frame.position);
    }
    if (sticks || !bead.ahead.isZero(0)) continue;
    const Vec3 slip = free_[p] + added_[p] - touch.surface;
    const Vec3 across = slip - touch.normal.dot(slip) * touch.normal;
    if (across.squaredNorm() > 0) bead.ahead = heading(across, across);
  }
  take_touches();
}

/// The normal of the plane in which all places, velocities and gravity lie; zero: there is none.
Vec3 ContactMotion::plane_of(const State& state) const {
  std::vector<Vec3> places, ways{mechanism_.gravity()};
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    places.push_back(place(state, p));
    ways.push_back(velocity(state, p));
    if (beads_[p].mode == Mode::open) continue;
    ways.push_back(beads_[p].touch.normal);
    ways.push_back(surface(beads_[p], places.back()).velocity);
  }
  add_ways_of_bodies(state, places, ways);
  Vec3 normal = Vec3::Zero(), first = mechanism_.gravity();
  for (const Vec3& at : places) {
    const Vec3 from = at - places[0];
    if (first.squaredNorm() == 0) first = from;
    const Vec3 across = first.cross(from);
    if (across.squaredNorm() > normal.squaredNorm()) normal = across;
  }
  if (!(normal.squaredNorm() > 0)) return Vec3::Zero();
  normal.normalize();
  double out = 0;
  for (const Vec3& at : places) out = std::max(out, std::abs(normal.dot(at - places[0])));
  for (const Vec3& way : ways) out = std::max(out, std::abs(normal.dot(way)));
  if (!turn_within(state, normal)) return Vec3::Zero();
  return out <= kFlat ? normal : Vec3(Vec3::Zero());
}

/// How far (m/s^2) a bead that sticks, and is pulled by so much more, is from sliding.
double ContactMotion::margin(std::size_t point, const Vec3& more) const {
  const Bead& bead = beads_[point];
  if (bead.mode != Mode::sticks) return std::numeric_limits<double>::infinity();
  const Vec3 given = added_[point] - pulled_[point] - more;
  const double push = bead.touch.normal.dot(given);
  return bead.touch.stick * push - (given - push * bead.touch.normal).norm();
}

/// Where tensions are left open, between beads that stick, each gets the value that keeps both
/// beads farthest from sliding: margins are concave, a golden section finds their highest point.
void ContactMotion::centre() {
  const double ratio = (std::sqrt(5.0) - 1) / 2;
  double most = 0;
  for (const double tension : tension_) most = std::max(most, std::abs(tension));
  const auto& rows = mechanism_.rows();
  for (std::size_t i = 0; i < 2 * kSweeps * rows.size(); ++i) {
    const std::size_t k = i % (2 * rows.size());
    const std::size_t r = k < rows.size() ? k : 2 * rows.size() - 1 - k;
    const std::size_t a = rows[r].a, b = rows[r].b;
    const double mobile_a = mechanism_.inverse_mass()[a], mobile_b = mechanism_.inverse_mass()[b];
    const auto is_open = [&](std::size_t point, double mobile) {
      return is_carried_[point] || (mobile > 0 && beads_[point].mode != Mode::sticks);
    };
    if (is_open(a, mobile_a) || is_open(b, mobile_b) || mobile_a + mobile_b == 0) continue;
    if (!pulls_[r]) continue;
    const Vec3& along = mechanism_.direction()[r];
    const auto least = [&](double more) {
      return std::min(margin(a, mobile_a * more * along), margin(b, -mobile_b * more * along));
    };
    double low = rows[r].pulls ? -tension_[r] : -2 * most, high = 2 * most;
    double left = high - ratio * (high - low), right = low + ratio * (high - low);
    double at_left = least(left), at_right = least(right);
    for (int s = 0; s < kShrinkings; ++s) {
      if (at_left > at_right) {
        high = right, right = left, at_right = at_left;
        left = high - ratio * (high - low), at_left = least(left);
      } else {
        low = left, left = right, at_left = at_right;
        right = low + ratio * (high - low), at_right = least(right);
      }
    }
    const double more = (low + high) / 2;
    if (!(least(more) > least(0))) continue;
    tension_[r] += more;
    pulled_[a] += mobile_a * more * along;
    pulled_[b] -= mobile_b * more * along;
  }
}

void ContactMotion::resolve(double time, State& state) {
  mechanism_.place(time, state.data());
  move_obstacles(time);
  find_touches(state);
  if (arrive(time, state)) find_touches(state);
  aside_ = plane_of(state);
  choose(time, state);
  centre();
}

}  // namespace taut::contact
