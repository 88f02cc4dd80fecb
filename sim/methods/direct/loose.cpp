// The way of a course on which errors of many per cents of the length will do: by leaps or by BDF2,
// past the frames, in steps as long as one solve can follow.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/control.h"

namespace taut::direct {
namespace {

/// The error that a step may make, in tolerances: so much per second, and at most so much. Where
/// the tolerance is small, so many times the root of the share of the length that it is: with the
/// cube of the step it falls, and what leaps err by in all with the square.
constexpr double kRate = 30, kShare = 0.03, kSmallShare = 0.06;  // 1/s, 1, 1

/// Nor may it exceed this share of a link, or links fold.
constexpr double kRoughness = 0.3;

/// Newton's iteration may turn a link by so much (rad), of which it leaves about the square.
constexpr double kMostCorrected = 0.15;

/// Of a link's length, a leap may be off by so many times the share of all links that the tolerance
/// is before its lengths are mended, and at most by so much.
constexpr double kMendedPerShare = 0.7, kMostMended = 0.2;

/// A step is done again only where its error is so many times what it may be; in any case the next
/// one is shorter.
constexpr double kRefused = 3;

constexpr double kSafety = 0.8, kMostGrowth = 2, kMostShrink = 0.3;

/// The first step turns a link by about so much (rad). Leaps never forget what they began with:
/// where the tolerance is small they begin with this share of it.
constexpr double kFirstTurn = 0.1, kFirstLeap = 0.1;

/// It begins with leaps where the fastest wave, now or hanging, turns by less than this (rad) in
/// such a first step; where the tolerance is small and links pull, by less than the other.
constexpr double kStiff = 6, kSoft = 3;

/// Where BDF2 took over from leaps, these go on once that wave turns by less (rad) in a step.
constexpr double kEased = 1;

/// They are stable while it turns by 2, but it has to grow; in none does it turn by more than the
/// one, and where that is too long while it turned by the other, BDF2 goes on.
constexpr double kMostTurned = 3.5, kStiffened = 3.4;

/// It has nothing to gain from steps so short (s) that waves allow the explicit methods the same.
constexpr double kShort = 1e-4;

/// What a step costs, in accelerations; measured.
constexpr double kCost = 2, kLeapCost = 1;

}  // namespace

/// Steps to `until` or beyond, or until the ladder does as well. Without a last step to look back
/// to, or where it led astray, the acceleration says what it would have been.
void Course::advance_loosely(World& world, double until, Counters& counters) {
  while (time_ < until) {
    if (!looks_back_) {
      refresh(counters);
      if (step_ == 0) {
        step_ = first_step(kFirstTurn);
        const double turn = step_ * std::max(fastest_, motion_->fastest_hanging());
        soft_ = leaps_ = closed_ && motion_->leaps() && turn < kStiff;
        if (only_leaps_ && !(soft_ && (turn < kSoft || motion_->pushes()))) {
          loose_ = only_leaps_ = false;
          return begin();
        }
        if (only_leaps_) step_ *= kFirstLeap;
      }
      backward_.begin(step_, q_.data(), rate_.data(), acceleration_.data(), q_before_.data(),
                      rate_before_.data());
      before_ = time_ - step_;
      looks_back_ = true;
    }
    const bool waves = leaps_ && !fresh_;  // else those of links that push count, too
    const double h = std::min({step_, longest_, waves ? kMostTurned / fastest_ : longest_});
    const bool stiffened = only_leaps_ && !leaps_;
    if (stiffened || (h < kShort && h < stable_step(adams))) {
      counters.handed_over += 1;
      rough_ = rough_ && stiffened;
      loose_ = only_leaps_ = false;
      return begin();
    }
    const double excess = attempt_loosely(h, counters);
    if (leave_plane(world)) continue;
    constexpr float kOrder = BackwardStep::kErrorOrder;
    static_assert(kOrder == LeapStep::kErrorOrder);
    // A step needs no more digits.
    const double scale = kSafety * std::pow(static_cast<float>(excess), -1 / kOrder);
    step_ = h * (scale > kMostShrink ? std::min(scale, kMostGrowth) : kMostShrink);
    const bool good = excess <= kRefused;  // false for NaN
    if (good) {
      q_before_.swap(q_);
      rate_before_.swap(rate_);
      if (leaps_) {
        leap_.accept(q_, rate_, rate_before_);
      } else {
        backward_.accept(q_, rate_);
      }
      before_ = time_;
      time_ += h;
      counters.steps += 1;
      // Leaps need no rates, and each interpolated state is projected.
      if (!leaps_) motion_->project(time_, q_.data(), rate_.data());
    } else {
      counters.rejected += 1;
    }
    const bool stiff = leaps_ && !(excess <= 1) && !(h * fastest_ <= kStiffened);
    if (stiff) {
      leaps_ = false;
      motion_->project(time_, q_.data(), rate_.data());
    }
    if (soft_ && good && h * fastest_ < kEased) leaps_ = true;
    looks_back_ = !stiff && (good || leaps_);
  }
}

/// Tries a step of h. Returns its error as a share of the one allowed, or that of what its one
/// solve had to correct.
double Course::attempt_loosely(double h, Counters& counters) {
  const double small = kSmallShare * std::sqrt(tolerance_ / motion_->length());
  const double share = std::min(kRate * h, only_leaps_ ? small : kShare);
  const double allowed = std::min(share * tolerance_, kRoughness * motion_->shortest());
  const double last = time_ - before_;
  double excess = 0;
  if (leaps_) {
    const auto [error, correction] =
        leap_.attempt(*motion_, time_, h, last, q_.data(), q_before_.data());
    const double mended = std::min(kMendedPerShare * tolerance_ / motion_->length(), kMostMended);
    excess = std::max(error / allowed, correction / mended);
  } else {
    const auto [error, correction] = backward_.attempt(
        *motion_, time_, h, last, q_.data(), rate_.data(), q_before_.data(), rate_before_.data());
    excess = std::max(error / allowed, correction / kMostCorrected);
  }
  counters.solves += 1;
  counters.work += (leaps_ ? kLeapCost : kCost) * motion_->work();
  fastest_ = motion_->fastest();
  fresh_ = false;
  return excess;
}

}  // namespace taut::direct
