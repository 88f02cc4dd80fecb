#include "sim/methods/direct/contact_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace taut::direct {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

Eigen::Map<Vec3> vector(double* at) {
  return Eigen::Map<Vec3>(at);
}

constexpr double kTouching = 1e-9;       // of the longest connector
constexpr double kExact = 1e-14;         // m: rounding of positions of about a metre
constexpr double kSameDirection = 1e-9;  // rad
constexpr double kLastResort = 1e-6;     // s, of steps that may go with less friction
constexpr double kWorse = 4;             // times as far from a solution as before
constexpr int kHalvings = 8;             // of a change that leads there
constexpr double kShortest = 1e-7;       // s: nothing is located more precisely
constexpr int kRounds = 12;              // of finding what is hit in a step

}  // namespace

void ContactStep::rebuild(const World& world) {
  mechanism_.rebuild(world);
  system_.rebuild(mechanism_);
  radius_.clear();
  double longest = 0;
  for (const Connector& connector : world.connectors) {
    longest = std::max(longest, connector.length);
    const bool joint = !(connector.length > 0);
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      radius_.push_back(joint ? -1 : connector.radius);
    }
  }
  for (std::size_t p = 0; p < radius_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) radius_[p] = -1;
  }
  touching_ = kTouching * (longest > 0 ? longest : 1);
  const std::size_t points = mechanism_.points(), rows = mechanism_.rows().size();
  for (auto* array : {&mean_, &middle_, &free_, &bare_, &acceleration_, &last_acceleration_}) {
    array->assign(points, Vec3::Zero());
  }
  for (auto* array : {&from_, &along_, &to_}) array->assign(rows, Vec3::Zero());
  for (auto* array : {&pull_, &rest_, &change_, &tension_, &last_tension_}) array->assign(rows, 0);
  answer_.assign(points, Mat3::Zero());
  is_carried_.assign(points, false);
  for (const auto& carried : mechanism_.body_points()) is_carried_[carried.point] = true;
  arm_.resize(mechanism_.body_points().size());
  inverse_.resize(mechanism_.bodies().size());
  touches_.clear();
  before_.clear();
  last_hits_ = true;
  solves_ = 0;
}

void ContactStep::load(const World& world, const std::vector<Obstacle>& obstacles) {
  obstacles_ = &obstacles;
  mechanism_.load(world, state_);
  next_ = state_;
  last_hits_ = true;
}

Vec3 ContactStep::position(const std::vector<double>& state, std::size_t point) const {
  return ConstMap(&state[mechanism_.position(point)]);
}

/// Beads that touch at the start, but for those which are leaving.
void ContactStep::find_touches() {
  before_.swap(touches_);
  touches_.clear();
  for (std::uint32_t p = 0; p < radius_.size(); ++p) {
    if (radius_[p] < 0) continue;
    const Vec3 at = position(state_, p);
    for (std::uint32_t o = 0; o < start_.size(); ++o) {
      const SurfaceDistance near = gap((*obstacles_)[o], start_[o].pose(), at, radius_[p]);
      if (near.distance > touching_) continue;
      const Vec3 velocity = ConstMap(&state_[mechanism_.velocity(p)]);
      const Vec3 surface =
          start_[o].point(start_[o].rotation.conjugate() * (at - start_[o].position)).velocity;
      if (near.normal.dot(velocity - surface) > touching_) continue;
      add_touch({.point = p,
                 .obstacle = o,
                 .anchor = start_[o].rotation.conjugate() * (at - start_[o].position)});
      touches_.back().hits = false;
    }
  }
}

void ContactStep::add_touch(const Hit& hit) {
  const auto same = [&](const BeadTouch& touch) {
    return touch.point == hit.point && touch.obstacle == hit.obstacle;
  };
  if (std::ranges::any_of(touches_, same)) return;
  const auto at = std::ranges::upper_bound(touches_, hit.point, {}, &BeadTouch::point);
  if (std::ranges::count(touches_, hit.point, &BeadTouch::point) == 3) return;
  const Obstacle& obstacle = (*obstacles_)[hit.obstacle];
  BeadTouch made{.point = hit.point,
                 .obstacle = hit.obstacle,
                 .hits = true,
                 .anchor = hit.anchor,
                 .side = obstacle.shape.from(hit.anchor).normal,
                 .touch = {}};
  const auto was = std::ranges::find_if(before_, same);
  const bool stuck = was != before_.end() && was->touch.state == Touch::State::sticks;
  if (!stuck) {
    const FrameMotion& start = start_[hit.obstacle];
    const Vec3 from = position(state_, hit.point) - start.position;
    made.touch.slid =
        ConstMap(&state_[mechanism_.velocity(hit.point)]) - start.velocity - start.spin.cross(from);
  }
  touches_.insert(at, made);
}

double ContactStep::attempt(double time, double h, bool locates, double lowest) {
  const std::vector<Obstacle>& obstacles = *obstacles_;
  start_.resize(obstacles.size());
  end_.resize(obstacles.size());
  for (std::size_t o = 0; o < obstacles.size(); ++o) start_[o] = obstacles[o].frame(time);
  mechanism_.update(time, state_.data());
  from_ = mechanism_.direction();
  for (std::size_t i = 0; i < arm_.size(); ++i) arm_[i] = mechanism_.body_points()[i].arm;
  for (std::size_t b = 0; b < inverse_.size(); ++b) {
    inverse_[b] = mechanism_.bodies()[b].world_inverse;
  }
  find_touches();
  hits_ = false;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t o = 0; o < obstacles.size(); ++o) end_[o] = obstacles[o].frame(time + h);
    for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] = h * last_tension_[r];
    if (!glide(time, h, 1) && !glide_by_parts(time, h)) return 0;
    if (!find_hits(time, h)) return settle(time, h, lowest) ? h : 0;
    hits_ = true;
    double first = 1;
    for (const Hit& hit : found_) {
      if (locates || hit.passes) first = std::min(first, hit.share);
    }
    const bool shortens = first < 1 - 1e-6 && first * h > kShortest;
    for (const Hit& hit : found_) {
      if (!shortens || hit.share <= first * (1 + 1e-6)) add_touch(hit);
    }
    if (shortens) h *= first;
  }
  return 0;
}

/// How directions and lengths are at the end of the step; returns the largest change of a mean
/// direction.
double ContactStep::measure() {
  const auto& rows = mechanism_.rows();
  double changed = 0;
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
    to_[r] = gap / length;
    rest_[r] = length - row.rest;
    const Vec3 mean = (from_[r] + to_[r]).normalized();
    changed = std::max(changed, (mean - along_[r]).squaredNorm());
    turn_ = std::max(turn_, (to_[r] - from_[r]).squaredNorm());
    along_[r] = mean;
  }
  turn_ = std::sqrt(turn_);
  return std::sqrt(changed);
}

/// Tells the touches of the first stage where the beads are; returns by how much (m) a touch that
/// pushes is open, or one is broken.
double ContactStep::aim(double h) {
  double worst = 0;
  for (BeadTouch& at : touches_) {
    const Obstacle& obstacle = (*obstacles_)[at.obstacle];
    const FrameMotion &start = start_[at.obstacle], &end = end_[at.obstacle];
    const Vec3 from = position(state_, at.point), to = position(next_, at.point);
    SurfaceDistance near = gap(obstacle, end.pose(), to, radius_[at.point]);
    const Vec3 side = end.rotation * at.side;
    if (near.normal.dot(side) < 0) {  // on its way to a solution it came out on the other side
      near = {side.dot(to - end.pose().to_world(at.anchor)), side};
    }
    at.gap = near.distance;
    worst = std::max(worst, at.touch.push > 0 ? std::abs(near.distance) : -near.distance);
    // Along the mean normal a bead that stays at a round surface moves no way at all.
    Vec3 normal = near.normal;
    if (!at.hits) normal += gap(obstacle, start.pose(), from, radius_[at.point]).normal;
    at.touch.normal = normal.squaredNorm() > 1 ? Vec3(normal.normalized()) : near.normal;
    const Vec3 local = end.rotation.conjugate() * (to - end.position);
    at.touch.surface = (to - start.pose().to_world(local)) / h;
    at.touch.least = (at.touch.normal.dot(to - from) - near.distance) / h;
    at.touch.pushed.setZero();
    at.touch.rubbed.setZero();
  }
  return worst;
}

/// Moves everything by the pulls as they are.
void ContactStep::move(double time, double h) {
  const Vec3 gain = h / 2 * mechanism_.gravity();
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    mean_[p] = ConstMap(&state_[mechanism_.velocity(p)]) + gain;
  }
  spread(pull_, along_, 0.5, mean_);
  respond_all(mean_);
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    vector(&next_[mechanism_.position(p)]) = position(state_, p) + h * mean_[p];
  }
  // Bodies: half of the impulses at the start, a turn without torque, the other half at the end.
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

/// With friction raised in shares (a homotopy), from no pulls at all. In the shortest steps as much
/// as there is a solution with.
bool ContactStep::glide_by_parts(double time, double h) {
  std::ranges::fill(pull_, 0.0);
  double found = -1;
  for (const double share : kShares) {
    kept_ = pull_;
    if (glide(time, h, share)) {
      found = share;
      continue;
    }
    if (h > kLastResort || found < 0) return false;
    pull_ = kept_;
    return glide(time, h, found);
  }
  return true;
}

/// Finds the first stage's pulls, from those that there are, with so much of all friction.
bool ContactStep::glide(double time, double h, double friction) {
  next_ = state_;
  for (std::size_t p = 0; p < mean_.size(); ++p) {
    vector(&next_[mechanism_.position(p)]) += h * ConstMap(&state_[mechanism_.velocity(p)]);
  }
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    vector(&next_[mechanism_.pose(b)]) += h * ConstMap(&state_[mechanism_.twist(b)]);
  }
  mechanism_.place(time + h, next_.data());
  for (BeadTouch& at : touches_) {
    at.touch.push = 0;
    at.touch.stick = friction * (*obstacles_)[at.obstacle].static_friction;
    at.touch.slide = friction * (*obstacles_)[at.obstacle].kinetic_friction;
  }
  double before = std::numeric_limits<double>::infinity();
  int halvings = 0;
  Damping damping;
  for (int i = 0; i < kIterations; ++i) {
    const double changed = measure();
    const double apart = aim(h);
    double worst = apart;
    for (const double rest : rest_) worst = std::max(worst, std::abs(rest));
    if (!std::isfinite(worst)) return false;
    const bool settled = worst < touching_ && worst > before / 2;
    if (i > 0 && changed < kSameDirection && (worst <= kExact || settled)) return true;
    if (i > 1 && worst > kWorse * before && halvings < kHalvings) {  // too far: half the way back
      for (double& change : change_) change /= 2;
      for (std::size_t r = 0; r < pull_.size(); ++r) pull_[r] -= change_[r];
      ++halvings;
    } else {
      before = worst;
      halvings = 0;
      if (i > 0) {
        for (std::size_t r = 0; r < rest_.size(); ++r) change_[r] = rest_[r] / h;
        improve(damping, along_, 0.5, mean_);
      }
    }
    move(time, h);
  }
  return false;
}

}  // namespace taut::direct
