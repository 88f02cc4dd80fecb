#include "scenes/character/tails.h"

#include <cmath>

#include "sim/motion/rotation.h"

namespace taut::scenes {
namespace {

/// The pelvis' share of what carries the jacket's skirt under a bend and under an end; so much of
/// the rest is the thigh's on the same side.
constexpr double bend_share = 0.26, end_share = 0.15, own_share = 0.63;

/// A pendulum of a tail's length (0.28 m, as a rod) swings at 7 rad/s; half of it, faster. Cloth
/// rubs on cloth: a swing or two and it is still.
constexpr double bend_rate = 9, end_rate = 7, damping = 0.35;

/// The cloth behind keeps bends and ends so far in front of where it carries them, m: tails are
/// straight between them, thighs round.
constexpr double bend_stand_off = 0.008, end_stand_off = 0.006;

constexpr int substeps = 8;

}  // namespace

Tails::Tails(const Skeleton& skeleton) : skeleton_(skeleton) {
  for (const auto& [own, other] : {std::pair<std::string, std::string>{"Left", "Right"},
                                   std::pair<std::string, std::string>{"Right", "Left"}}) {
    if (skeleton.maybe(own + "Tail1") < 0) continue;
    hips_ = skeleton.find("Hips");
    Tail tail{skeleton.find(own + "Tail1"),
              skeleton.find(own + "Tail2"),
              skeleton.find(own + "UpLeg"),
              skeleton.find(other + "UpLeg"),
              Vec3::Zero(),
              Vec3::Zero()};
    tail.bend = skeleton.rest(tail.lower);
    // The lower half is as long as the upper, and hangs steeper.
    const Vec3 upper = tail.bend - skeleton.rest(tail.upper);
    tail.end = tail.bend + upper.norm() * (upper.normalized() - Vec3::UnitY()).normalized();
    tails_.push_back(tail);
  }
}

Vec3 Tails::carried(const Tail& tail, const Vec3& rest, double on_pelvis,
                    const Placement& placed) const {
  const auto with = [&](std::size_t bone) -> Vec3 {
    return placed.position[bone] + placed.turn[bone] * (rest - skeleton_.rest(bone));
  };
  const double thighs = 1 - on_pelvis;
  return on_pelvis * with(hips_) + thighs * own_share * with(tail.own_thigh) +
         thighs * (1 - own_share) * with(tail.other_thigh);
}

std::vector<Vec3> Tails::lying(const Placement& placed) const {
  std::vector<Vec3> points;
  for (const Tail& tail : tails_) {
    points.push_back(carried(tail, tail.bend, bend_share, placed));
    points.push_back(carried(tail, tail.end, end_share, placed));
  }
  return points;
}

/// Each point's offset e from where it lies answers its place p: e'' = -w^2 e - 2 z w e' - p''. By
/// steps of semi-implicit Euler, p'' being the change of p' at each sample. Cloth holds a tail from
/// behind.
Track Tails::swing(double duration, double rate,
                   const std::function<Placement(double time)>& placed) const {
  const std::size_t points = 2 * tails_.size();
  const auto rows = Eigen::Index(3 * points);
  Track offsets =
      Track::sample(duration, rate, [&](double) { return Eigen::VectorXd::Zero(rows).eval(); });
  std::vector<Vec3> e(points, Vec3::Zero()), v(points, Vec3::Zero());
  std::vector<Vec3> last, last_rate(points, Vec3::Zero());
  const double dt = 1 / (rate * substeps);
  for (Eigen::Index i = 0; i < offsets.count(); ++i) {
    const Placement now = placed(offsets.time(i));
    const std::vector<Vec3> lies = lying(now);
    if (last.empty()) last = lies;
    const Vec3 front = tails_.empty() ? Vec3::Zero().eval() : Vec3(now.turn[hips_] * Vec3::UnitZ());
    for (std::size_t k = 0; k < points; ++k) {
      const bool is_end = k % 2 == 1;
      const double w = is_end ? end_rate : bend_rate;
      // An end hangs on its bend: the cloth and the bend's swing carry it.
      const Vec3 place = is_end ? Vec3(lies[k] + e[k - 1]) : lies[k];
      const Vec3 placed_rate = (place - last[k]) * rate;
      v[k] -= placed_rate - last_rate[k];
      last[k] = place;
      last_rate[k] = placed_rate;
      for (int step = 0; step < substeps; ++step) {
        v[k] += dt * (-w * w * e[k] - 2 * damping * w * v[k]);
        e[k] += dt * v[k];
      }
      const double into = (is_end ? end_stand_off : bend_stand_off) - e[k].dot(front);
      if (into > 0) {
        e[k] += into * front;
        v[k] -= std::min(v[k].dot(front), 0.0) * front;
      }
      offsets.samples().col(i).segment<3>(Eigen::Index(3 * k)) =
          is_end ? Vec3(e[k] + e[k - 1]) : e[k];
    }
  }
  return offsets;
}

void Tails::hang(const Eigen::VectorXd& offsets, Placement& placed) const {
  const std::vector<Vec3> lies = lying(placed);
  for (std::size_t i = 0; i < tails_.size(); ++i) {
    const Tail& tail = tails_[i];
    const auto there = [&](std::size_t k) -> Vec3 {
      return lies[k] + offsets.segment<3>(Eigen::Index(3 * k));
    };
    const auto aim = [&](std::size_t bone, const Vec3& rest_along, const Vec3& at) {
      const Vec3 now = placed.turn[bone] * rest_along;
      const Vec3 wanted = at - placed.position[bone];
      placed.turn[bone] = rotation_between(now, wanted) * placed.turn[bone];
    };
    const Vec3 upper = tail.bend - skeleton_.rest(tail.upper);
    aim(tail.upper, upper, there(2 * i));
    placed.position[tail.lower] = placed.position[tail.upper] + placed.turn[tail.upper] * upper;
    placed.turn[tail.lower] = placed.turn[tail.upper];
    aim(tail.lower, tail.end - tail.bend, there(2 * i + 1));
  }
}

}  // namespace taut::scenes
