// The way of a course on which errors of many per cents of the length will do: by BDF2, past the
// frames, in steps as long as Newton's method can follow.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/control.h"

namespace taut::direct {
namespace {

/// The error that a step may make, in tolerances: so much per second, and at most so much.
constexpr double kRate = 30, kShare = 0.03;  // 1/s, 1

/// Nor may it exceed this share of a link, or links fold.
constexpr double kRoughness = 0.3;

/// Newton's iteration may turn a link by so much (rad), of which it leaves about the square.
constexpr double kMostCorrected = 0.1;

/// A step is done again only where its error is so many times what it may be; in any case the next
/// one is shorter.
constexpr double kRefused = 3;

constexpr double kSafety = 0.8, kMostGrowth = 2, kMostShrink = 0.3;

/// The first step turns a link by about so much (rad).
constexpr double kFirstTurn = 0.1;

/// It has nothing to gain from steps so short (s) that waves allow the explicit methods the same.
constexpr double kShort = 1e-4;

/// What a step costs, in accelerations; measured.
constexpr double kCost = 2;

}  // namespace

/// Steps to `until` or beyond, or until the ladder does as well. Without a last step to look back
/// to, or where it led astray, the acceleration says what it would have been.
void Course::advance_loosely(World& world, double until, double tolerance, Counters& counters) {
  while (time_ < until) {
    if (!looks_back_) {
      refresh(counters);
      if (step_ == 0) step_ = first_step(kFirstTurn);
      backward_.begin(step_, q_.data(), rate_.data(), acceleration_.data(), q_before_.data(),
                      rate_before_.data());
      before_ = time_ - step_;
      looks_back_ = true;
    }
    const double h = std::min(step_, longest_);
    if (h < kShort && h < stable_step(adams)) {
      counters.handed_over += 1;
      loose_ = rough_ = false;
      return begin();
    }
    const auto [error, correction] =
        backward_.attempt(*motion_, time_, h, time_ - before_, q_.data(), rate_.data(),
                          q_before_.data(), rate_before_.data());
    counters.solves += 1;
    counters.work += kCost * motion_->work();
    fastest_ = motion_->fastest();
    fresh_ = false;
    if (leave_plane(world)) continue;
    const double allowed =
        std::min(std::min(kRate * h, kShare) * tolerance, kRoughness * motion_->shortest());
    const double excess = std::max(error / allowed, correction / kMostCorrected);
    const double scale = kSafety * std::pow(excess, -1 / BackwardStep::kErrorOrder);
    step_ = h * (scale > kMostShrink ? std::min(scale, kMostGrowth) : kMostShrink);
    looks_back_ = excess <= kRefused;  // false for NaN
    if (looks_back_) {
      q_before_.swap(q_);
      rate_before_.swap(rate_);
      backward_.accept(q_, rate_);
      before_ = time_;
      time_ += h;
      counters.steps += 1;
      motion_->project(time_, q_.data(), rate_.data());
    } else {
      counters.rejected += 1;
    }
  }
}

}  // namespace taut::direct
