#include "sim/contact/contact_motion.h"

#include <algorithm>
#include <cmath>

#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kSpare = 1e-9;     // of forces per mass: no event yet
constexpr double kLedApart = 1e-6;  // of accelerations: what links that are left out may be off
constexpr double kLonger = 1e-4;    // times that: a string so much too long is taut
constexpr int kProjections = 20;

}  // namespace

void ContactMotion::rebuild(const World& world, double slowest) {
  obstacles_ = world.obstacles;
  slowest_ = slowest;
  mechanism_.rebuild(world);
  radius_.clear();
  category_.clear();
  double longest = 0;
  for (const Connector& connector : world.connectors) {
    longest = std::max(longest, connector.length);
    radius_.insert(radius_.end(), connector.particles(), connector.radius);
    category_.insert(category_.end(), connector.particles(), connector.category);
  }
  for (std::size_t p = 0; p < radius_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) radius_[p] = -1;
  }
  touching_ = kTouching * longest;
  const std::size_t points = mechanism_.points(), rows = mechanism_.rows().size();
  beads_.assign(points, {});
  for (auto* array : {&free_, &pulled_, &added_}) array->assign(points, Vec3::Zero());
  for (auto* array : {&tension_, &change_, &start_}) array->assign(rows, 0);
  mobility_.assign(points, Mat3::Zero());
  taut_.clear();
  for (const Row& row : mechanism_.rows()) taut_.push_back(!row.pulls);
  pulls_ = taut_;
  along_.assign(rows, Vec3::Zero());
  frames_.resize(obstacles_.size());
  rebuild_bodies(world);
  rebuild_parts(world);
  system_.rebuild(mechanism_, bodies_together(meetings_, capsules_.size()));
}

Vec3 ContactMotion::place(const State& state, std::size_t point) const {
  return ConstMap(&state[mechanism_.position(point)]);
}

Vec3 ContactMotion::velocity(const State& state, std::size_t point) const {
  return ConstMap(&state[mechanism_.velocity(point)]);
}

void ContactMotion::move_obstacles(double time) {
  for (std::size_t o = 0; o < obstacles_.size(); ++o) frames_[o] = obstacles_[o].frame(time);
}

/// The motion of the obstacle's material at a place.
PointMotion ContactMotion::surface(const Bead& bead, const Vec3& at) const {
  const FrameMotion& frame = frames_[bead.obstacle];
  return frame.point(frame.rotation.conjugate() * (at - frame.position));
}

/// The acceleration along the normal with which a bead stays on the surface: the second derivative
/// of its distance is zero.
double ContactMotion::least_acceleration(const Bead& bead, const Vec3& at,
                                         const Vec3& velocity) const {
  const FrameMotion& frame = frames_[bead.obstacle];
  const PointMotion carried = surface(bead, at);
  const Vec3 passing = velocity - carried.velocity;
  const Quat back = frame.rotation.conjugate();
  const Vec3 local = back * passing;
  const Vec3 turning =
      obstacles_[bead.obstacle].shape.normal_rate(back * (at - frame.position), local);
  return bead.touch.normal.dot(carried.acceleration + 2 * frame.spin.cross(passing)) -
         turning.dot(local);
}

/// Finds all accelerations under the active set.
void ContactMotion::accelerate(double time, const State& state) {
  scratch_ = state;
  mechanism_.update(time, scratch_.data());
  move_obstacles(time);
  const auto& mobile = mechanism_.inverse_mass();
  const auto& rows = mechanism_.rows();
  const std::span<const Vec3> along = pulling();
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    Bead& bead = beads_[p];
    free_[p] = weight(p);
    pulled_[p].setZero();
    if (bead.mode == Mode::open) continue;
    const Vec3 at = place(scratch_, p), moves = velocity(scratch_, p);
    const Obstacle& obstacle = obstacles_[bead.obstacle];
    const Pose pose = frames_[bead.obstacle].pose();
    bead.touch.normal = gap(obstacle, pose, at, radius_[p]).normal;
    if (bead.mode == Mode::sticks) {
      bead.touch.surface = frames_[bead.obstacle].point(bead.anchor).acceleration;
      continue;
    }
    bead.touch.least = least_acceleration(bead, at, moves);
    const Vec3 slip = moves - surface(bead, at).velocity;
    const Vec3 across = slip - bead.touch.normal.dot(slip) * bead.touch.normal;
    const double speed = across.norm();
    bead.touch.sliding = bead.ahead;
    if (speed > kStill) bead.touch.sliding = heading(across, bead.ahead);
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    pulled_[rows[r].a] += mobile[rows[r].a] * tension_[r] * along[r];
    pulled_[rows[r].b] -= mobile[rows[r].b] * tension_[r] * along[r];
  }
  free_bodies(nullptr);
  aim_bodies(scratch_);
  if (!parts_.empty()) {
    for (std::size_t r = 0; r < rows.size(); ++r) start_[r] = mechanism_.free_acceleration(r);
    respond_together(start_, true);
    change_ = tension_;
    return;
  }
  const auto respond_all = [&](std::span<const double> tension) {
    for (std::size_t p = 0; p < beads_.size(); ++p) {
      Bead& bead = beads_[p];
      Touch& touch = bead.touch;
      const Vec3 bare = free_[p] + pulled_[p];
      mobility_[p] = mobile[p] * Mat3::Identity();
      added_[p] = pulled_[p];
      if (bead.mode == Mode::slides) {
        touch.push = touch.least - touch.normal.dot(bare);
        const Vec3 force = touch.normal - touch.slide * touch.sliding;
        touch.friction = -touch.slide * touch.push * touch.sliding;
        added_[p] += touch.push * force;
        mobility_[p] -= mobile[p] * force * touch.normal.transpose();
      } else if (bead.mode == Mode::sticks) {
        const Vec3 given = touch.surface - bare;
        touch.push = touch.normal.dot(given);
        touch.friction = given - touch.push * touch.normal;
        added_[p] += given;
        mobility_[p].setZero();
      }
    }
    couple_bodies(tension, along, true);
  };
  // Where links and what sticks leave a tension open, it is what it was.
  respond_all(tension_);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    change_[r] = pulls_[r] ? mechanism_.free_acceleration(r) +
                                 along[r].dot(added_[rows[r].b] - added_[rows[r].a])
                           : 0;
  }
  system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
  system_.solve(change_);
  ++solves_;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    pulled_[rows[r].a] += mobile[rows[r].a] * change_[r] * along[r];
    pulled_[rows[r].b] -= mobile[rows[r].b] * change_[r] * along[r];
    change_[r] += tension_[r];
  }
  respond_all(change_);
}

void ContactMotion::differentiate(double time, const State& state, State& derivative) {
  accelerate(time, state);
  mechanism_.differentiate(scratch_.data(), change_.data(), derivative.data());
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (beads_[p].mode == Mode::open && parts_.empty()) continue;
    if (mechanism_.inverse_mass()[p] == 0) continue;
    double* rate = &derivative[mechanism_.velocity(p)];
    Map{rate} = free_[p] + added_[p];
  }
  for (std::size_t b = 0; b < body_added_.size(); ++b) {
    Eigen::Map<Vec6>{&derivative[mechanism_.twist(b)]} += body_added_[b] - body_pulled_[b];
  }
}

double ContactMotion::project(double time, State& state) {
  move_obstacles(time);
  if (!parts_.empty()) return project_together(time, state);
  const auto& mobile = mechanism_.inverse_mass();
  const auto& rows = mechanism_.rows();
  std::span<const Vec3> along = mechanism_.direction();
  double worst = 0;
  for (std::size_t b = 0; b < capsules_.size(); ++b) {
    double* q = &state[mechanism_.pose(b) + 3];
    set_quaternion(quaternion(q).normalized(), q);
  }
  const auto shift = [&](std::size_t offset) {  // along the surfaces
    for (std::size_t r = 0; r < rows.size(); ++r) {
      const Vec3 pull = change_[r] * along[r];
      Map(&state[offset + 3 * rows[r].a]) += mobility_[rows[r].a] * pull;
      Map(&state[offset + 3 * rows[r].b]) -= mobility_[rows[r].b] * pull;
    }
    shift_bodies(along, offset == mechanism_.position(0), state);
  };
  for (int i = 0; i < kProjections; ++i) {
    check_stop();
    worst = 0;
    for (std::size_t p = 0; p < beads_.size(); ++p) {
      const Bead& bead = beads_[p];
      mobility_[p] = mobile[p] * Mat3::Identity();
      if (bead.mode == Mode::open) continue;
      Map at(&state[mechanism_.position(p)]);
      Map moves(&state[mechanism_.velocity(p)]);
      const FrameMotion& frame = frames_[bead.obstacle];
      if (bead.mode == Mode::sticks) {
        const PointMotion anchor = frame.point(bead.anchor);
        at = anchor.position;
        moves = anchor.velocity;
        mobility_[p].setZero();
        continue;
      }
      const SurfaceDistance near = gap(obstacles_[bead.obstacle], frame.pose(), at, radius_[p]);
      worst = std::max(worst, std::abs(near.distance));
      at -= near.distance * near.normal;
      moves += near.normal.dot(surface(bead, at).velocity - moves) * near.normal;
      mobility_[p] -= mobile[p] * near.normal * near.normal.transpose();
    }
    mechanism_.place(time, state.data());
    if (!capsules_.empty()) worst = std::max(worst, project_bodies(state));
    mechanism_.update(time, state.data());
    along = pulling();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (pulls_[r]) worst = std::max(worst, std::abs(mechanism_.violation()[r]));
    }
    system_.assemble(mechanism_, mobility_, along, along, &body_coupled_);
    ++solves_;
    std::ranges::copy(mechanism_.rate(), change_.begin());
    system_.solve(change_);
    shift(mechanism_.velocity(0));
    if (worst < 1e-3 * touching_) break;
    std::ranges::copy(mechanism_.violation(), change_.begin());
    system_.solve(change_);
    shift(mechanism_.position(0));
  }
  return worst;
}

void ContactMotion::events(double time, const State& state, std::vector<double>& values) {
  values.clear();
  accelerate(time, state);
  for (std::size_t p = 0; p < beads_.size(); ++p) {
    if (radius_[p] < 0) continue;
    const Bead& bead = beads_[p];
    const Vec3 at = place(scratch_, p);
    for (std::size_t o = 0; o < obstacles_.size(); ++o) {
      if (bead.mode != Mode::open && bead.obstacle == o) continue;
      if (!obstacles_[o].touches(category_[p])) continue;
      const SurfaceDistance near = gap(obstacles_[o], frames_[o].pose(), at, radius_[p]);
      const Bead there{.obstacle = static_cast<std::uint32_t>(o), .touch = {}};
      const double separating =
          near.normal.dot(velocity(scratch_, p) - surface(there, at).velocity);  // m/s
      values.push_back(crossing(near.distance + touching_ / 2, separating >= -kStill));
    }
    if (bead.mode == Mode::open) continue;
    const Touch& touch = bead.touch;
    const double spare = kSpare * (free_[p].norm() + pulled_[p].norm() + touch.push);
    values.push_back(touch.push + spare);
    if (touch.stick == 0) continue;
    if (bead.mode == Mode::sticks) {
      values.push_back(touch.stick * touch.push - touch.friction.norm() + spare);
    } else {
      const Vec3 slip = velocity(scratch_, p) - surface(bead, at).velocity;
      values.push_back(slip.dot(bead.ahead) + kStill / 2);
    }
  }
  body_events(scratch_, values);
  // A link whose ends are led apart while what it joins sticks: that has to slide.
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    const Row& row = mechanism_.rows()[r];
    double size = mechanism_.gravity().norm();
    for (const std::uint32_t p : {row.a, row.b}) size += free_[p].norm() + pulled_[p].norm();
    double off = 0;
    if (pulls_[r] && system_.left_out(r)) {
      off = mechanism_.free_acceleration(r) +
            mechanism_.direction()[r].dot(added_[row.b] - added_[row.a]);
    }
    values.push_back(kLedApart * size - std::abs(off));
  }
  if (!mechanism_.has_strings()) return;
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    if (!mechanism_.rows()[r].pulls) continue;
    if (pulls_[r]) {
      values.push_back(change_[r] + spare(r));
      continue;
    }
    values.push_back(
        crossing(kLonger * touching_ - mechanism_.violation()[r], mechanism_.rate()[r] <= kStill));
  }
}

}  // namespace taut::contact
