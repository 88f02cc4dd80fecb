// The first stage of a step at obstacles: positions.
#include <algorithm>
#include <cmath>

#include "sim/contact/creep.h"
#include "sim/contact/damping.h"
#include "sim/methods/direct/contact/contact_step.h"
#include "sim/motion/larger.h"
#include "sim/motion/stop.h"

namespace taut::direct {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

Eigen::Map<Vec3> vector(double* at) {
  return Eigen::Map<Vec3>(at);
}

constexpr int kTrial = 8;         // iterations from the pulls of the step before
constexpr double kDiverges = 10;  // times the first error: a trial that is given up
constexpr int kIterations = 40;   // of Newton's method, at most
constexpr double kWave = 0.5;     // rad^2: faster ones turn links within a step
constexpr double kSlow = 0.1;     // of an error, from one iteration to the next

}  // namespace

/// Newton's method on positions and pulls together, in which links turn and surfaces curve. Before
/// each iteration the pulls are found that what touches asks for, where the beads are.
bool ContactStep::glide(double time, double h) {
  h_ = h;
  slips_ = false;
  for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] = h * last_tension_[r];
  if (mechanism_.has_strings()) {
    for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] *= taut_[r];
    std::ranges::fill(given_, 0.0);
    pulls_ = taut_;
  }
  next_ = state_;
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    vector(&next_[mechanism_.position(p)]) += h * ConstMap(&state_[mechanism_.velocity(p)]);
  }
  for (BeadTouch& at : touches_) at.touch.push = 0;
  bodies_.release();
  links_.release();
  beads_.release();
  scale_friction(1);
  move_bodies(time, h);
  double before = INFINITY;
  bool turns = false;
  for (int i = 0; i < kIterations; ++i) {
    check_stop();
    measure();
    aim(h);
    if (bodies_.any()) turn_ = std::max(turn_, bodies_.aim(body_step(time, h), next_));
    if (links_.any()) links_.aim(body_step(time, h), next_);
    if (beads_.any()) turn_ = std::max(turn_, beads_.aim(body_step(time, h), next_));
    if (!pull(time, h)) return false;
    const double worst = residual(h);
    if (!std::isfinite(worst)) return false;
    const bool settled = worst < touching_ && worst > before / 2;
    if (worst <= exact_ || (i > 0 && settled)) {
      for (std::size_t p = 0; p < mean_.size(); ++p) {
        vector(&next_[mechanism_.position(p)]) = position(state_, p) + h * mean_[p];
      }
      move_bodies(time, h);
      return true;
    }
    turns = turns || worst > kSlow * before || wave_turn(h) > kWave;
    before = worst;
    if (!turns) {  // where links hardly turn, the mean velocities are enough
      for (std::size_t p = 0; p < mean_.size(); ++p) {
        vector(&next_[mechanism_.position(p)]) = position(state_, p) + h * mean_[p];
      }
      continue;
    }
    ++solves_;
    bend(h);
    stiffen(h);
    mask();
    links_.linearize(body_step(time, h), next_, mean_, behind_, creep_);
    beads_.linearize(body_step(time, h), next_, behind_, creep_);
    const bool strings = mechanism_.has_strings();
    glide_system_.assemble(mechanism_, {.h = h,
                                        .mobility = mobility_,
                                        .bend = bend_,
                                        .turn = stiffness_,
                                        .along = strings ? right_ : along_,
                                        .to = strings ? left_ : to_,
                                        .bodies = bodies_.coupled(),
                                        .touches = links_.linear(),
                                        .beads = beads_.linear()});
    glide_system_.solve(behind_, change_, links_.missing(), beads_.missing());
    advance_touches(1);
    for (std::size_t p = 0; p < behind_.size(); ++p) {
      vector(&next_[mechanism_.position(p)]) += h * behind_[p];
    }
    for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] += change_[r];
  }
  return false;
}

/// The square of the angle (rad) by which the fastest wave along the rows advances in the step.
double ContactStep::wave_turn(double h) const {
  double most = 0;
  const auto& mobile = mechanism_.inverse_mass();
  for (std::size_t r = 0; r < pull_.size(); ++r) {
    const Row& row = mechanism_.rows()[r];
    if (row.axis != Row::kAlongLink) continue;
    most = std::max(most, (mobile[row.a] + mobile[row.b]) * std::abs(pull_[r]) / row.rest);
  }
  return 2 * h * most;
}

/// The pulls with which rows get their lengths, as directions and normals are. From those that
/// there are or, where that leads nowhere, with friction that first is viscous.
bool ContactStep::pull(double time, double h) {
  keep_pulls();
  if (pull_creeping(time, h, contact::kCreep, true)) return true;
  restore_pulls();
  const double creep = approach([&](double to) { return pull_creeping(time, h, to); });
  if (creep <= contact::kCreep) return true;
  if (h > slippery_) return false;
  slips_ = true;
  return with_less_friction([&] { return pull_creeping(time, h, contact::kCreep); });
}

/// Where it is a trial, few iterations have to do, and none may lead far away.
bool ContactStep::pull_creeping(double time, double h, double creep, bool trial) {
  contact::Damping damping;
  double first = 0, before = INFINITY;
  creep_ = creep;
  relaxes_ = false;
  const auto& rows = mechanism_.rows();
  const int most = trial ? kTrial : kIterations;
  const auto errors = [&] {
    respond(time, h);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const std::size_t a = rows[r].a, b = rows[r].b;
      const Vec3 start = position(state_, b) - position(state_, a);
      // |gap| + to . (h (v_b - v_a) - what the gap has changed) = rest
      const double wanted = (rows[r].rest - to_[r].dot(start)) / h;
      change_[r] = to_[r].dot(mean_[b] - mean_[a]) - wanted;
    }
  };
  for (int i = 0; i < most; ++i) {
    errors();
    if (sort_strings(0.5)) errors();
    if (jams_) return false;
    double worst = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      worst = larger(worst, wrong(r, change_[r]) - noise_[rows[r].a] - noise_[rows[r].b]);
    }
    worst = larger(larger(worst, links_.error(noise_)), beads_.error(noise_));
    if (!std::isfinite(worst)) return false;
    // Rows that others determine already keep what roundings left of their errors.
    if (worst * h <= exact_ || (worst * h < touching_ && worst > before / 2)) return sticks();
    if (i == 0) first = worst;
    if (trial && worst > kDiverges * first) return false;
    before = worst;
    ++solves_;
    if (damping.relaxes(pattern())) {
      relax(along_, 0.5, mean_);
      relaxes_ = true;
      continue;
    }
    const double share = damping.share();
    if (couples()) {
      solve_with_touches(along_, 0.5);
      advance_touches(share);
    } else {
      for (double& change : change_) change *= 2;  // of a pull half makes the mean velocities
      mask();
      const bool strings = mechanism_.has_strings();
      system_.assemble(mechanism_, mobility_, strings ? left_ : to_, strings ? right_ : along_,
                       bodies_.coupled());
      system_.solve(change_);
    }
    for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] += share * change_[r];
  }
  return false;
}

/// How the geometry makes rows and carried points respond.
void ContactStep::stiffen(double h) {
  const auto& rows = mechanism_.rows();
  for (std::size_t r = 0; r < rows.size(); ++r) {
    if (rows[r].axis != Row::kAlongLink) continue;
    const Vec3 gap = position(next_, rows[r].b) - position(next_, rows[r].a);
    if (!pulls_[r]) {
      stiffness_[r].setZero();
      continue;
    }
    const Mat3 across_mean = Mat3::Identity() - along_[r] * along_[r].transpose();
    const Mat3 across = Mat3::Identity() - to_[r] * to_[r].transpose();
    stiffness_[r] = pull_[r] / ((from_[r] + to_[r]).norm() * gap.norm()) * across_mean * across;
  }
  mobilize_carried();
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    behind_[p] = mean_[p] - (position(next_, p) - position(state_, p)) / h;
  }
  for (std::size_t r = 0; r < rows.size(); ++r) change_[r] = pulls_[r] ? -rest_[r] / h : 0;
}

/// The mean velocities of all points under the pulls as they are.
void ContactStep::respond(double time, double h) {
  const Vec3 gain = h / 2 * mechanism_.gravity();
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    mean_[p] = ConstMap(&state_[mechanism_.velocity(p)]) + gain;
  }
  spread(pull_, along_, 0.5, mean_);
  if (links_.any()) carry_held(h);
  respond_all(mean_);
  if (!mechanism_.bodies().empty()) {
    aimed_ = next_;
    const auto move = [&] { move_bodies(time, h); };
    jams_ = bodies_.any() && !bodies_.respond(body_step(time, h), inverse_, next_, creep_, move);
    if (!bodies_.any()) move();
  }
  carry_held(h);
  links_.find_errors(mean_, creep_);
  beads_.find_errors(body_step(time, h), next_, mean_, creep_);
  if (mechanism_.bodies().empty()) return;
  if (bodies_.any() || beads_.any()) {  // where they are aimed from next
    const auto poses = static_cast<std::ptrdiff_t>(mechanism_.pose(0));
    const auto end = static_cast<std::ptrdiff_t>(mechanism_.velocity(0));
    std::copy(next_.begin() + poses, next_.begin() + end, aimed_.begin() + poses);
  }
  next_.swap(aimed_);
}

/// The mean velocities of held points.
void ContactStep::carry_held(double h) {
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] > 0) continue;
    mean_[p] = (position(next_, p) - position(state_, p)) / h;
  }
}

/// By how much (m) points are elsewhere than they respond, a row is too long, or a touch is open
/// or broken.
double ContactStep::residual(double h) const {
  double worst = std::max(
      {bodies_.residual(next_, mechanism_), links_.residual(), beads_.residual(mechanism_, next_)});
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    const Vec3 off = position(state_, p) + h * mean_[p] - position(next_, p);
    for (const double apart : off) worst = larger(worst, std::abs(apart) - h * noise_[p]);
  }
  for (const BeadTouch& at : touches_) {
    const double apart = at.touch.push > 0 ? std::abs(at.gap) : -at.gap;
    worst = larger(worst, apart - h * noise_[at.point]);
  }
  for (std::size_t r = 0; r < rest_.size(); ++r) {
    const Row& row = mechanism_.rows()[r];
    worst = larger(worst, wrong(r, rest_[r]) - h * (noise_[row.a] + noise_[row.b]));
  }
  return worst;
}

/// How directions and lengths are at the end of the step.
void ContactStep::measure() {
  const auto& rows = mechanism_.rows();
  turn_ = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Row& row = rows[r];
    const Vec3 gap = position(next_, row.b) - position(next_, row.a);
    if (row.axis != Row::kAlongLink) {
      to_[r] = along_[r] = Vec3::Unit(row.axis);
      rest_[r] = gap[row.axis];
      continue;
    }
    const double length = gap.norm();
    rest_[r] = length - row.rest;
    if (row.pulls) {
      mean_direction(r, gap);
      continue;
    }
    to_[r] = gap / length;
    along_[r] = (from_[r] + to_[r]).normalized();
    turn_ = std::max(turn_, (to_[r] - from_[r]).norm());
  }
}

/// Moves bodies by the pulls: half of the impulses at the start, a turn without torque, the other
/// half at the end. Points that are held follow.
void ContactStep::move_bodies(double time, double h) {
  const Vec3 gain = h / 2 * mechanism_.gravity();
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    const double* u = &state_[mechanism_.twist(b)];
    vector(&next_[mechanism_.twist(b)]) = ConstMap(u) + gain;
    vector(&next_[mechanism_.twist(b) + 3]) = ConstMap(u + 3);
  }
  for (const auto& end : mechanism_.row_ends()) {
    const std::size_t body = mechanism_.body_points()[end.body_point].body;
    const Vec3 pull = end.sign * 0.5 * pull_[end.row] * along_[end.row];
    double* u = &next_[mechanism_.twist(body)];
    vector(u) += mechanism_.bodies()[body].inverse_mass * pull;
    vector(u + 3) += inverse_[body] * arm_[end.body_point].cross(pull);
  }
  links_.kick(mechanism_, arm_, inverse_, next_);
  beads_.kick(mechanism_, inverse_, next_);
  bodies_.kick(mechanism_, state_, inverse_, next_);
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    const double *u = &next_[mechanism_.twist(b)], *q = &state_[mechanism_.pose(b)];
    Quat rotation = quaternion(q + 3);
    Vec3 spin = ConstMap(u + 3);
    mechanism_.bodies()[b].rotation.turn(rotation, spin, h);
    vector(&next_[mechanism_.twist(b) + 3]) = spin;
    vector(&next_[mechanism_.pose(b)]) = ConstMap(q) + h * ConstMap(u);
    set_quaternion(rotation.normalized(), &next_[mechanism_.pose(b) + 3]);
  }
  mechanism_.place(time + h, next_.data());
}

}  // namespace taut::direct
