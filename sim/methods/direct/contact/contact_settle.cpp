// The second stage of a step at obstacles: velocities.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/contact/creep.h"
#include "sim/contact/damping.h"
#include "sim/contact/restitution.h"
#include "sim/methods/direct/contact/contact_step.h"
#include "sim/methods/direct/contact/entry.h"
#include "sim/motion/larger.h"
#include "sim/motion/stop.h"

namespace taut::direct {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

Eigen::Map<Vec3> vector(double* at) {
  return Eigen::Map<Vec3>(at);
}

constexpr double kStopped = 1e-13;  // of the speeds
constexpr double kLeftOver = 1e4;   // times that, at most
constexpr int kIterations = 40;

}  // namespace

/// Gives bodies a `share` of the rows' impulses.
void ContactStep::kick(std::span<const double> impulse, std::span<const Vec3> along, double share) {
  for (const auto& end : mechanism_.row_ends()) {
    const auto& carried = mechanism_.body_points()[end.body_point];
    const auto& body = mechanism_.bodies()[carried.body];
    const Vec3 pull = end.sign * share * impulse[end.row] * along[end.row];
    double* u = &next_[mechanism_.twist(carried.body)];
    vector(u) += body.inverse_mass * pull;
    vector(u + 3) += body.world_inverse * carried.arm.cross(pull);
  }
}

/// How fast (m/s) a bead comes to what it hits. Links may pull it there for the rest of a step in
/// which it has been stopped: that is no speed of its own, and a bounce of it would be work from
/// nowhere.
double ContactStep::arriving(const BeadTouch& at, double h) const {
  const contact::Touch& touch = at.touch;
  const auto coming = [&](const Vec3& velocity) {
    return -touch.normal.dot(velocity - touch.surface);
  };
  const double pulled = coming(middle_[at.point] - touch.pushed - touch.friction_before);
  if (!(touch.push > 0)) return pulled;
  const Vec3 began = ConstMap(&state_[mechanism_.velocity(at.point)]);
  return std::min(pulled,
                  std::max(coming(middle_[at.point]), coming(began + h * mechanism_.gravity())));
}

/// Tells the touches of the second stage what the first has given.
void ContactStep::aim_velocities(double h, double least) {
  std::erase_if(touches_, [&](const BeadTouch& at) {
    return at.gap > (at.hits ? kShortOf * touching_ : touching_);
  });
  for (BeadTouch& at : touches_) {
    contact::Touch& touch = at.touch;
    touch.pushed = 2 * touch.push * touch.normal;
    touch.friction_before = 2 * touch.friction;
    const FrameMotion& end = end_[at.obstacle];
    const Obstacle& obstacle = (*obstacles_)[at.obstacle];
    const Vec3 to = position(next_, at.point);
    touch.normal = gap(obstacle, end.pose(), to, radius_[at.point]).normal;
    touch.surface = end.point(end.rotation.conjugate() * (to - end.position)).velocity;
    touch.least = touch.normal.dot(touch.surface);
    if (!at.hits) continue;
    const double bounce = obstacle.restitution * arriving(at, h);
    at.bounce = bounce > least ? bounce : 0;
    touch.least += at.bounce;
  }
}

/// Applies the first stage's impulses to bodies and sets the velocities that the second aims at.
void ContactStep::begin_settling(double time, double h, double least) {
  std::vector<Mat3> inverse;
  for (const auto& body : mechanism_.bodies()) inverse.push_back(body.world_inverse);
  bodies_.kick(mechanism_, next_, inverse, next_);
  for (std::size_t b = 0; b < pushed_.size(); ++b) {
    const std::size_t u = mechanism_.twist(b);
    pushed_[b] =
        (Eigen::Map<const contact::Vec6>(&next_[u]) - Eigen::Map<const contact::Vec6>(&state_[u])) /
        h;
  }
  bodies_.aim_velocities(body_step(time, h), next_, least);
}

bool ContactStep::settle(double time, double h, double least) {
  double speed = 0;
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    const Vec3 velocity = ConstMap(&state_[mechanism_.velocity(p)]);
    acceleration_[p] = 2 / h * (mean_[p] - velocity);
    if (mechanism_.inverse_mass()[p] == 0) {
      middle_[p] = ConstMap(&next_[mechanism_.velocity(p)]);
    } else {
      middle_[p] = 2 * mean_[p] - velocity;
    }
    speed = std::max(speed, middle_[p].squaredNorm());
  }
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    vector(&next_[mechanism_.twist(b)]) += h / 2 * mechanism_.gravity();
  }
  kick(pull_, along_, 0.5);
  links_.kick_more(mechanism_, next_);
  beads_.kick_more(mechanism_, next_);
  if (mechanism_.material().any()) damp_bends(h);
  aim_velocities(h, least);
  if (!pushed_.empty()) begin_settling(time, h, least);
  if (couples()) {
    carry_middle();
    links_.aim_velocities(body_step(time, h), next_, middle_, least, located_);
    beads_.aim_velocities(body_step(time, h), next_, middle_, least, located_);
  }
  for (std::size_t r = 0; r < pull_.size(); ++r) tension_[r] = pull_[r] / h;
  glided_ = next_;
  keep_taut();
  const double stopped = kStopped * (1 + std::sqrt(speed));
  if (!stop(stopped)) return false;
  end_settling();
  if (!lower_bounces(stopped)) return false;
  mechanism_.place(time + h, next_.data());
  return true;
}

/// The velocities of points that bodies carry, after the first stage.
void ContactStep::carry_middle() {
  for (const auto& carried : mechanism_.body_points()) {
    middle_[carried.point] =
        contact::velocity_at(twist_at(&next_[mechanism_.twist(carried.body)]), carried.arm);
  }
}

/// Velocities change by what damps bends, as they are at the end of the step: explicitly, which is
/// stable in steps below longest_damped().
void ContactStep::damp_bends(double h) {
  carry_middle();
  damping_.assign(middle_.size(), Vec3::Zero());
  mechanism_.material().add_bends(next_.data(), middle_.front().data(), damping_);
  for (std::size_t p = 0; p < middle_.size(); ++p) {
    middle_[p] += h * mechanism_.inverse_mass()[p] * damping_[p];
  }
  for (const auto& carried : mechanism_.body_points()) {
    const auto& body = mechanism_.bodies()[carried.body];
    double* u = &next_[mechanism_.twist(carried.body)];
    vector(u) += h * body.inverse_mass * damping_[carried.point];
    vector(u + 3) += h * body.world_inverse * carried.arm.cross(damping_[carried.point]);
  }
}

/// The velocities at the end of the step.
void ContactStep::end_settling() {
  for (std::size_t p = 0; p < free_.size(); ++p) {
    vector(&next_[mechanism_.velocity(p)]) = free_[p];
  }
  if (bodies_.any()) {
    for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
      Eigen::Map<contact::Vec6>(&next_[mechanism_.twist(b)]) += bodies_.added(b);
    }
  }
}

/// Where the impact would make energy, it goes with the share of what is thrown back that makes
/// none, see contact::share_thrown_back(). False: no impact without restitution was found.
bool ContactStep::lower_bounces(double stopped) {
  const bool beads =
      std::ranges::any_of(touches_, [](const BeadTouch& at) { return at.bounce > 0; });
  const bool others = links_.rebounds() || beads_.rebounds() || bodies_.rebounds();
  if (!(beads || others) || is_driven()) return true;
  for (std::size_t p = 0; p < middle_.size(); ++p) {
    vector(&glided_[mechanism_.velocity(p)]) = middle_[p];
  }
  contact::ImpactEnergies energy{.before = energy_of(glided_, glided_),
                                 .thrown = energy_of(next_, next_)};
  if (!contact::gains_energy(energy.before, energy.thrown)) return true;
  const std::vector<double>& thrown = aimed_ = next_;
  for (BeadTouch& at : touches_) at.touch.least -= std::exchange(at.bounce, 0);
  links_.stop_bounces();
  beads_.stop_bounces();
  bodies_.stop_bounces();
  if (!stop(stopped)) return false;
  end_settling();
  energy.stopped = energy_of(next_, next_);
  energy.mixed = energy_of(next_, thrown);
  const double share = contact::share_thrown_back(energy);
  for (std::size_t i = mechanism_.velocity(0); i < next_.size(); ++i) {
    next_[i] += share * (thrown[i] - next_[i]);
  }
  return true;
}

/// Finds the second stage's impulses; friction creeps as in glide().
bool ContactStep::stop(double stopped) {
  scale_friction(1);
  clear_pulls();
  if (stop_creeping(stopped, contact::kCreep)) return true;
  if (touches_.empty() && !bodies_.any() && !couples()) return false;
  clear_pulls();
  const double creep = approach([&](double to) { return stop_creeping(stopped, to); });
  return creep <= contact::kCreep ||
         with_less_friction([&] { return stop_creeping(stopped, contact::kCreep); });
}

/// All touches have that share of their friction.
void ContactStep::scale_friction(double share) {
  for (BeadTouch& at : touches_) {
    at.touch.stick = share * (*obstacles_)[at.obstacle].static_friction;
    at.touch.slide = share * (*obstacles_)[at.obstacle].kinetic_friction;
  }
  bodies_.scale_friction(share);
  links_.scale_friction(*obstacles_, share);
  beads_.scale_friction(share);
}

void ContactStep::clear_pulls() {
  std::ranges::fill(pull_, 0.0);
  links_.release();
  beads_.release();
}

void ContactStep::keep_pulls() {
  kept_pull_ = pull_;
  links_.keep();
  beads_.keep();
}

void ContactStep::restore_pulls() {
  pull_ = kept_pull_;
  links_.restore();
  beads_.restore();
}

/// Approaches friction from a viscous one. Newton's method alone leads fastest there; where it does
/// not, what touches links is relaxed before each of its iterations.
double ContactStep::approach(const std::function<bool(double)>& solve) {
  const auto from_here = [&] {
    return contact::approach_friction(
        solve, [&] { keep_pulls(); }, [&] { restore_pulls(); });
  };
  const double creep = from_here();
  if (creep <= contact::kCreep || !links_.any()) return creep;
  clear_pulls();
  relaxes_all_ = true;
  const double relaxed = from_here();
  relaxes_all_ = false;
  return relaxed;
}

/// With friction raised in shares from none, as much as there is a solution with.
bool ContactStep::with_less_friction(const std::function<bool()>& solve) {
  clear_pulls();
  double most = -1;
  for (const double share : {0.0, 0.3, 0.6, 0.8}) {
    keep_pulls();
    scale_friction(share);
    if (!solve()) break;
    most = share;
  }
  if (most < 0) return false;
  restore_pulls();
  scale_friction(most);
  return solve();
}

/// Newton's method on the impulses, from those that there are.
bool ContactStep::stop_creeping(double stopped, double creep) {
  std::copy(glided_.begin() + static_cast<std::ptrdiff_t>(mechanism_.velocity(0)), glided_.end(),
            next_.begin() + static_cast<std::ptrdiff_t>(mechanism_.velocity(0)));
  kick(pull_, to_, 1);
  links_.take_back_kicks();
  beads_.take_back_kicks();
  creep_ = creep;
  relaxes_ = false;
  contact::Damping damping;
  const std::vector<Row>& rows = mechanism_.rows();
  const auto errors = [&] {
    free_ = middle_;
    spread(pull_, to_, 1, free_);
    respond_all(free_);
    links_.kick_more(mechanism_, next_);
    beads_.kick_more(mechanism_, next_);
    jams_ = bodies_.any() && !bodies_.settle(mechanism_, next_, creep);
    for (const auto& carried : mechanism_.body_points()) {
      const double* u = &next_[mechanism_.twist(carried.body)];
      free_[carried.point] = ConstMap(u) + ConstMap(u + 3).cross(carried.arm);
      if (!bodies_.any()) continue;
      free_[carried.point] += contact::velocity_at(bodies_.added(carried.body), carried.arm);
    }
    for (std::size_t r = 0; r < rows.size(); ++r) {
      change_[r] = to_[r].dot(free_[rows[r].b] - free_[rows[r].a]);
    }
    links_.find_errors(free_, creep);
    beads_.find_errors(mechanism_, free_, next_, bodies_, creep);
  };
  for (int i = 0; i < kIterations; ++i) {
    check_stop();
    errors();
    if (sort_strings(1)) {
      kick(dropped_, to_, 1);
      errors();
    }
    if (jams_) return false;
    double worst = 0;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const double noise = noise_[rows[r].a] + noise_[rows[r].b];
      worst = larger(worst, wrong(r, change_[r]) - noise);
    }
    worst = larger(larger(worst, links_.error(noise_)), beads_.error(noise_));
    if (!std::isfinite(worst)) return false;
    // Where states go to and fro within rounding, what is left does no harm.
    if (worst <= stopped || (i >= kIterations / 2 && worst <= kLeftOver * stopped)) return sticks();
    ++solves_;
    if (damping.relaxes(pattern())) {
      relax(to_, 1, free_);
      relaxes_ = true;
    } else if (couples()) {
      solve_with_touches(to_, 1);
      advance_touches(damping.share());
      for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] += change_[r] *= damping.share();
    } else {
      mask();
      const std::vector<Vec3>& along = mechanism_.has_strings() ? left_ : to_;
      system_.assemble(mechanism_, mobility_, along, along, bodies_.coupled());
      system_.solve(change_);
      for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] += change_[r] *= damping.share();
    }
    kick(change_, to_, 1);
  }
  return false;
}

}  // namespace taut::direct
