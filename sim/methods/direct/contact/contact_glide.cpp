// The first stage of a step at obstacles: positions.
#include <algorithm>
#include <cmath>

#include "sim/contact/creep.h"
#include "sim/contact/damping.h"
#include "sim/methods/direct/contact/contact_step.h"

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
constexpr double kNudge = 100;    // times touching(): to see how surfaces curve

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
  scale_friction(1);
  move_bodies(time, h);
  double before = INFINITY;
  bool turns = false;
  for (int i = 0; i < kIterations; ++i) {
    measure();
    aim(h);
    if (bodies_.any()) turn_ = std::max(turn_, bodies_.aim(body_step(time, h), next_));
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
    const bool strings = mechanism_.has_strings();
    glide_system_.assemble(mechanism_, {.h = h,
                                        .mobility = mobility_,
                                        .bend = bend_,
                                        .turn = stiffness_,
                                        .along = strings ? right_ : along_,
                                        .to = strings ? left_ : to_,
                                        .bodies = bodies_.coupled()});
    glide_system_.solve(behind_, change_);
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
  kept_pull_ = pull_;
  if (pull_creeping(time, h, contact::kCreep, true)) return true;
  pull_ = kept_pull_;
  const double creep =
      contact::approach_friction([&](double to) { return pull_creeping(time, h, to); },
                                 [&] { kept_pull_ = pull_; }, [&] { pull_ = kept_pull_; });
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
      worst = std::max(worst, wrong(r, change_[r]) - noise_[rows[r].a] - noise_[rows[r].b]);
    }
    if (!std::isfinite(worst)) return false;
    // Rows that others determine already keep what roundings left of their errors.
    if (worst * h <= exact_ || (worst * h < touching_ && worst > before / 2)) return sticks();
    if (i == 0) first = worst;
    if (trial && worst > kDiverges * first) return false;
    before = worst;
    ++solves_;
    if (damping.relaxes(pattern())) {
      relax(along_, 0.5, mean_);
      continue;
    }
    for (double& change : change_) change *= 2;  // of a pull half makes the mean velocities
    mask();
    const bool strings = mechanism_.has_strings();
    system_.assemble(mechanism_, mobility_, strings ? left_ : to_, strings ? right_ : along_,
                     bodies_.coupled());
    system_.solve(change_);
    const double share = damping.share();
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
  for (const auto& carried : mechanism_.body_points()) {
    if (bodies_.any()) {
      mobility_[carried.point] =
          contact::mobility(bodies_.coupled()->own(carried.body), carried.arm, carried.arm);
      continue;
    }
    const auto& body = mechanism_.bodies()[carried.body];
    Mat3 lever;
    lever << 0, -carried.arm.z(), carried.arm.y(), carried.arm.z(), 0, -carried.arm.x(),
        -carried.arm.y(), carried.arm.x(), 0;
    mobility_[carried.point] =
        body.inverse_mass * Mat3::Identity() - lever * body.world_inverse * lever;
  }
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
  respond_all(mean_);
  if (!mechanism_.bodies().empty()) {
    aimed_ = next_;
    const auto move = [&] { move_bodies(time, h); };
    jams_ = bodies_.any() && !bodies_.respond(body_step(time, h), inverse_, next_, creep_, move);
    if (!bodies_.any()) move();
  }
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] > 0) continue;
    mean_[p] = (position(next_, p) - position(state_, p)) / h;
  }
  if (mechanism_.bodies().empty()) return;
  if (bodies_.any()) {  // where they are aimed from next
    const auto poses = static_cast<std::ptrdiff_t>(mechanism_.pose(0));
    const auto end = static_cast<std::ptrdiff_t>(mechanism_.velocity(0));
    std::copy(next_.begin() + poses, next_.begin() + end, aimed_.begin() + poses);
  }
  next_.swap(aimed_);
}

/// By how much (m) points are elsewhere than they respond, a row is too long, or a touch is open
/// or broken.
double ContactStep::residual(double h) const {
  double worst = bodies_.residual(next_, mechanism_);
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    const Vec3 off = position(state_, p) + h * mean_[p] - position(next_, p);
    worst = std::max(worst, off.lpNorm<Eigen::Infinity>() - h * noise_[p]);
  }
  for (const BeadTouch& at : touches_) {
    const double apart = at.touch.push > 0 ? std::abs(at.gap) : -at.gap;
    worst = std::max(worst, apart - h * noise_[at.point]);
  }
  for (std::size_t r = 0; r < rest_.size(); ++r) {
    const Row& row = mechanism_.rows()[r];
    worst = std::max(worst, wrong(r, rest_[r]) - h * (noise_[row.a] + noise_[row.b]));
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

/// Tells the touches of the first stage where the beads are.
void ContactStep::aim(double h) {
  for (BeadTouch& at : touches_) aim(at, position(next_, at.point), h);
}

/// A touch whose bead ends up at `to`.
void ContactStep::aim(BeadTouch& at, const Vec3& to, double h) const {
  const Obstacle& obstacle = (*obstacles_)[at.obstacle];
  const FrameMotion &start = start_[at.obstacle], &end = end_[at.obstacle];
  const Vec3 from = position(state_, at.point);
  SurfaceDistance near = gap(obstacle, end.pose(), to, radius_[at.point]);
  const Vec3 side = end.rotation * at.side;
  if (near.normal.dot(side) < 0) {  // on its way to a solution it came out on the other side
    near = {side.dot(to - end.pose().to_world(at.anchor)), side};
  }
  at.gap = near.distance;
  // Along the mean normal a bead that stays at a round surface moves no way at all.
  Vec3 normal = near.normal;
  if (!at.hits) normal += gap(obstacle, start.pose(), from, radius_[at.point]).normal;
  at.touch.normal = normal.squaredNorm() > 1 ? Vec3(normal.normalized()) : near.normal;
  const Vec3 local = end.rotation.conjugate() * (to - end.position);
  at.touch.surface = (to - start.pose().to_world(local)) / h;
  at.touch.least = (at.touch.normal.dot(to - from) - near.distance) / h;
  at.touch.pushed.setZero();
  at.touch.friction_before.setZero();
}

/// How the responses of beads at one surface change with where they end up, as it curves.
void ContactStep::bend(double h) {
  std::ranges::fill(bend_, Mat3::Zero());
  const double nudge = kNudge * touching_;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const BeadTouch& at = touches_[i];
    const auto pushes = [&](std::size_t k) {
      return k < touches_.size() && touches_[k].point == at.point && touches_[k].touch.push > 0;
    };
    if (!(at.touch.push > 0) || pushes(i + 1) || (i > 0 && pushes(i - 1))) continue;
    Mat3 normal;
    Vec3 least;
    for (int axis = 0; axis < 3; ++axis) {
      BeadTouch moved = at;
      aim(moved, position(next_, at.point) + nudge * Vec3::Unit(axis), h);
      normal.col(axis) = (moved.touch.normal - at.touch.normal) / nudge;
      least[axis] = (moved.touch.least - at.touch.least) / nudge;
    }
    bend_[at.point] =
        contact::response_to_turning(bare_[at.point], at.touch, normal, least, creep_);
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
