// The first stage of a step of bodies that touch something: positions.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/contact/body_touches.h"

namespace taut::direct {
namespace {

using contact::kNoBody;
using contact::SpotGap;
using contact::Vec6;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kPlaceRounding = 2e-15;  // of a place, by which a displacement is off

/// How the arm of a side turns over the step.
Vec3 mean_arm(const Quat& before, const Quat& after, const Vec3& mean, const Vec3& down) {
  return (before * mean + after * mean) / 2 + down;
}

}  // namespace

Vec3 BodyTouches::way(const double* from, const double* to, const Vec3& at) {
  const Vec3 is = ConstMap(to) + quaternion(to + 3) * at;
  const Vec3 was = ConstMap(from) + quaternion(from + 3) * at;
  return is - was;
}

double BodyTouches::aim(const Step& step, const std::vector<double>& next) {
  double turned = 0;
  const Mechanism& mechanism = step.mechanism;
  aimed_.assign(next.begin() + static_cast<std::ptrdiff_t>(mechanism.pose(0)),
                next.begin() + static_cast<std::ptrdiff_t>(mechanism.pose(capsules_.size())));
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    contact::BodyTouch& at = touches_[i];
    Place& place = places_[i];
    const contact::BodyMeeting& meeting = meetings_[at.meeting];
    const double *from = &step.state[mechanism.pose(at.body)], *to = &next[mechanism.pose(at.body)];
    const contact::Capsule own = capsule(to, at.body);
    const SpotGap near =
        contact::gap_at(meeting.shape, solid(meeting, step.end, mechanism, next), own, at.spot);
    place.gap = near.distance;
    const BodyCapsule& local = capsules_[at.body];
    const auto on_axis = [&](double along) -> Vec3 {
      return local.from + along * (local.to - local.from);
    };
    place.own.at = on_axis(near.along);
    place.own.mean = place.hits ? place.own.at : on_axis((near.along + place.along_start) / 2);
    // Along the mean normal a body that stays at a round surface moves no way at all.
    Vec3 normal = near.normal;
    if (!place.hits) normal += place.start_normal;
    at.touch.normal = normal.squaredNorm() > 1 ? Vec3(normal.normalized()) : near.normal;
    place.own.down = -own.radius * at.touch.normal;
    const Quat before = quaternion(from + 3), after = quaternion(to + 3);
    turned = std::max(turned, angle(after * before.conjugate()).norm());
    at.arm = mean_arm(before, after, place.own.mean, place.own.down);
    const Vec3 moves = way(from, to, place.own.at);
    if (at.other == kNoBody) {
      const FrameMotion& end = step.end[meeting.obstacle];
      const Vec3 there = ConstMap(to) + after * place.own.at + place.own.down;
      const Vec3 carried = end.rotation.conjugate() * (there - end.position);
      at.touch.surface = (there - step.start[meeting.obstacle].pose().to_world(carried)) / step.h;
      at.touch.least = (at.touch.normal.dot(moves) - near.distance) / step.h;
      continue;
    }
    const double* others_from = &step.state[mechanism.pose(at.other)];
    const double* others_to = &next[mechanism.pose(at.other)];
    const Quat others_before = quaternion(others_from + 3),
               others_after = quaternion(others_to + 3);
    turned = std::max(turned, angle(others_after * others_before.conjugate()).norm());
    Side& other = place.other;
    other.at = foot(meeting, own, near, others_to);
    other.mean = place.hits ? other.at : Vec3((other.at + place.other_start) / 2);
    other.down = meeting.shape.radius * at.touch.normal;
    at.other_arm = mean_arm(others_before, others_after, other.mean, other.down);
    at.touch.surface.setZero();
    const Vec3 others_move = way(others_from, others_to, other.at);
    at.touch.least = (at.touch.normal.dot(moves - others_move) - near.distance) / step.h;
  }
  return turned;
}

/// m/s, of a body's surface at a touch.
Vec3 BodyTouches::mean_velocity(const Step& step, const std::vector<double>& next,
                                std::uint32_t body, const Side& side) const {
  const double* from = &step.state[step.mechanism.pose(body)];
  const double* to = &next[step.mechanism.pose(body)];
  const Quat before = quaternion(from + 3), after = quaternion(to + 3);
  const Vec3 spin = angle(after * before.conjugate()) / step.h;
  const Vec3 moves = ConstMap(to) + after * side.at - ConstMap(from) - before * side.at;
  return moves / step.h + spin.cross(side.down);
}

/// How bodies respond without what they touch.
void BodyTouches::free_mobilities(const Mechanism& mechanism, std::span<const Mat3> inverse) {
  for (std::size_t b = 0; b < mobility_.size(); ++b) {
    mobility_[b] = contact::mobility(mechanism.bodies()[b].inverse_mass, inverse[b]);
  }
  coupled_.set_apart(mobility_);
}

bool BodyTouches::solve_means(const Step& step, std::span<const Mat3> inverse,
                              const std::vector<double>& next, double creep, double& change) {
  free_mobilities(step.mechanism, inverse);
  bool finds = true;
  clusters_.each(touches_, [&](std::size_t first, std::size_t count) {
    const std::span touches(&touches_[first], count);
    system_.assemble(mobility_, touches, 0.5);
    for (std::size_t k = 0; k < system_.bodies().size(); ++k) {
      moves_[system_.bodies()[k]] = 0.5 * system_.twist(touches, k);
    }
    bare_.clear();
    last_.clear();
    double most = 0, noise = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Place& place = places_[first + i];
      Vec3 moves = mean_velocity(step, next, touches[i].body, place.own);
      if (touches[i].other != kNoBody) {
        moves -= mean_velocity(step, next, touches[i].other, place.other);
      }
      bare_.push_back(moves - contact::passing(moves_, touches[i]));
      last_.push_back(touches[i].given);
      const double place_size = ConstMap(&next[step.mechanism.pose(touches[i].body)]).norm();
      noise =
          std::max(noise, kPlaceRounding * place_size / step.h / mobility_[touches[i].body](0, 0));
    }
    finds = system_.solve(bare_, touches, creep) && finds;
    double moved = 0;
    for (std::size_t i = 0; i < count; ++i) {
      most = std::max(most, touches[i].given.norm());
      moved = std::max(moved, (touches[i].given - last_[i]).norm());
    }
    if (moved > noise) change = std::max(change, moved / std::max(most, moved));
    if (!step.mechanism.rows().empty()) system_.couple(touches, coupled_);
  });
  return finds;
}

void BodyTouches::kick(const Mechanism& mechanism, const std::vector<double>& poses,
                       std::span<const Mat3> inverse, std::vector<double>& twists) const {
  const auto push = [&](std::uint32_t b, const Side& side, const Vec3& given) {
    const Quat rotation = quaternion(&poses[mechanism.pose(b) + 3]);
    const Vec3 arm = rotation * side.mean + side.down;
    Eigen::Map<Vec6> u(&twists[mechanism.twist(b)]);
    u.head<3>() += mechanism.bodies()[b].inverse_mass * given;
    u.tail<3>() += inverse[b] * arm.cross(given);
  };
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    const Vec3 given = 0.5 * touches_[i].given;
    push(touches_[i].body, places_[i].own, given);
    if (touches_[i].other != kNoBody) push(touches_[i].other, places_[i].other, -given);
  }
}

double BodyTouches::residual(const std::vector<double>& next, const Mechanism& mechanism) const {
  double worst = 0;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    for (const std::uint32_t b : {touches_[i].body, touches_[i].other}) {
      if (b == kNoBody) continue;
      const contact::Capsule a = capsule(&aimed_[7 * b], b);
      const contact::Capsule c = capsule(&next[mechanism.pose(b)], b);
      worst = std::max({worst, (a.from - c.from).lpNorm<Eigen::Infinity>(),
                        (a.to - c.to).lpNorm<Eigen::Infinity>()});
    }
    const double gap = places_[i].gap;
    worst = std::max(worst, touches_[i].touch.push > 0 ? std::abs(gap) : -gap);
  }
  return worst;
}

}  // namespace taut::direct
