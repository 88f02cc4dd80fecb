// Hits of beads on their way through a step.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/contact/contact_step.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
namespace {

constexpr double kSteady = 1.0 / 60;  // s: what changes faster is a wave

using ConstMap = Eigen::Map<const Vec3>;

}  // namespace

/// Finds what the beads that move as in the last glide() enter on the way. False: nothing.
bool ContactStep::find_hits(double time, double h) {
  found_.clear();
  std::size_t known = 0;
  for (std::uint32_t p = 0; p < radius_.size(); ++p) {
    if (radius_[p] < 0) continue;
    while (known < touches_.size() && touches_[known].point < p) ++known;
    for (std::uint32_t o = 0; o < start_.size(); ++o) {
      bool touches = !(*obstacles_)[o].touches(category_[p]);  // it need not be looked for
      for (std::size_t i = known; i < touches_.size() && touches_[i].point == p; ++i) {
        touches = touches || touches_[i].obstacle == o;
      }
      if (touches) continue;
      const Hit hit = sweep(time, h, p, o);
      if (hit.share <= 1) found_.push_back(hit);
    }
  }
  return !found_.empty();
}

/// Where on its way a bead enters an obstacle; a share above 1: nowhere.
ContactStep::Hit ContactStep::sweep(double time, double h, std::uint32_t point,
                                    std::uint32_t obstacle) const {
  Hit hit{.share = 2, .point = point, .obstacle = obstacle};
  const Obstacle& with = (*obstacles_)[obstacle];
  const Vec3 from = position(state_, point), to = position(next_, point);
  const Vec3 velocity = ConstMap(&state_[mechanism_.velocity(point)]);
  const Vec3 bend = h * (mean_[point] - velocity);
  const Pose start = start_[obstacle].pose(), end = end_[obstacle].pose();
  const double at_start = gap(with, start, from, radius_[point]).distance;
  const Vec3 before = start.rotation.conjugate() * (from - start.position);
  const Vec3 after = end.rotation.conjugate() * (to - end.position);
  const double way = (after - before).norm() + bend.norm();
  if (at_start > way) return hit;
  const auto local = [&](double share) {
    const Vec3 at = from + share * h * velocity + share * share * bend;
    const Pose frame = with.path ? with.frame(time + share * h).pose() : start;
    return Vec3(frame.rotation.conjugate() * (at - frame.position));
  };
  const auto gap_at_share = [&](double share) {
    return with.shape.from(local(share)).distance - radius_[point];
  };
  const double at_end = gap(with, end, to, radius_[point]).distance;
  const Entry entry = find_entry(at_start, at_end, way, gap_at_share);
  hit.share = entry.share;
  hit.passes = entry.passes;
  if (entry.share <= 1) hit.anchor = entry.stays ? before : local(entry.share);
  return hit;
}

void ContactStep::accept() {
  state_.swap(next_);
  last_hits_ = hits_;
  risen_ = rises_;
  last_pattern_ = pattern();
  last_h_ = h_;
  last_pushed_ = pushed_;
  if (!hits_) {
    const double share = watched_ > 0 ? std::min(1.0, h_ / kSteady) : 1;
    for (std::size_t p = 0; p < steady_.size(); ++p) {
      steady_[p] += share * (acceleration_[p] - steady_[p]);
    }
    for (std::size_t b = 0; b < pushed_.size(); ++b) {
      steady_pushed_[b] += share * (pushed_[b] - steady_pushed_[b]);
    }
    watched_ += h_;
  }
  last_acceleration_.swap(acceleration_);
  if (!hits_) last_tension_.swap(tension_);
}

/// The midpoint rule errs by h^3/12 times the third derivative, which the change of the
/// accelerations from the step before tells, as long as the same beads touch. It keeps the energy
/// of waves, whatever their phases. Where all that changes are waves too low to be seen, only what
/// is left of the change after many of them counts.
double ContactStep::error(double lowest) const {
  if (hits_ || last_hits_ || pattern() != last_pattern_) return 0;
  double change = 0, wave = 0;
  std::size_t count = 0, touching = 0;
  std::uint32_t linked = 0;  // a bead behind those whose links touch
  std::size_t next = 0;      // of these links
  std::size_t at_body = 0;   // of the beads that touch bodies
  for (std::size_t p = 0; p < radius_.size(); ++p) {
    while (next < links_.count() && links_.first(next) <= p) linked = links_.first(next++) + 2;
    if (mechanism_.inverse_mass()[p] == 0) continue;
    ++count;
    if (p < linked) continue;
    while (touching < touches_.size() && touches_[touching].point < p) ++touching;
    if (touching < touches_.size() && touches_[touching].point == p) continue;
    while (at_body < beads_.count() && beads_.touches()[at_body].point < p) ++at_body;
    if (at_body < beads_.count() && beads_.touches()[at_body].point == p) continue;
    change += (acceleration_[p] - last_acceleration_[p]).squaredNorm();
    wave += ((acceleration_[p] + last_acceleration_[p]) / 2 - steady_[p]).squaredNorm();
  }
  for (std::size_t b = 0; b < pushed_.size(); ++b) {
    const contact::Vec6 apart = pushed_[b] - last_pushed_[b];
    const double radius = bounding_radius_[b];
    ++count;
    const contact::Vec6 off = (pushed_[b] + last_pushed_[b]) / 2 - steady_pushed_[b];
    change += apart.head<3>().squaredNorm() + radius * radius * apart.tail<3>().squaredNorm();
    wave += off.head<3>().squaredNorm() + radius * radius * off.tail<3>().squaredNorm();
  }
  if (count == 0) return 0;
  change = std::sqrt(change / static_cast<double>(count));
  wave = std::sqrt(wave / static_cast<double>(count));
  const double apart = (h_ + last_h_) / 2;
  const double followed = h_ * h_ * h_ / 12 * change / apart;
  // Of waves of frequency w, x'' = -w^2 x.
  const double height = wave * wave * wave * apart * apart / (change * change);
  if (watched_ < kSteady || !(height < lowest)) return followed;
  return std::min(followed, h_ * h_ * h_ / 12 * wave / kSteady);
}

}  // namespace taut::direct
