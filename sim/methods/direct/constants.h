// Every constant of the step control, in one place.
#pragma once

namespace taut::direct {

/// How the integrator chooses steps and schemes. The scheme's own constants (order, stability
/// limit, cost) stand with the scheme.
struct StepConstants {
  // From the tolerance to the error of a step.

  /// A step of h seconds may err by min(rate h, share) tolerances. Errors of steps add up while
  /// they decay or turn as waves, and grow while the motion is unstable, a hundredfold and more
  /// where it can still be foretold. Both numbers are about the largest that keep every error on
  /// drawn scenes below three tolerances (taut_promise).
  double rate = 0.3;      // 1/s
  double share = 0.0025;  // 1
  /// The share of a tolerance by which a step may misplace particles on waves that it passes over:
  /// these die away within a few steps, and do not grow.
  double passed_over = 0.1;  // 1
  /// No error is larger than this share of the length: what is off by more has nothing of the
  /// motion left, and steps that allow more excite waves, which the next steps have to follow.
  double largest = 0.5;  // 1
  /// The acceleration of a link is off by about so many roundings; errors below them do not fall
  /// with the step.
  double roundings = 4;  // 1
  /// An estimated error above this share of the length has a fixed step done again in smaller ones:
  /// then fixed steps add no more to the energy than an error of a hundredth of the length explains
  /// (test_stability, DirectAccuracy).
  double coarsest = 0.005;  // 1

  // From one step to the next (Hairer, Norsett, Wanner, Solving ODEs I, II.4).

  /// The next step aims at this share of the step whose error would be the one allowed.
  double safety = 0.9;  // 1
  /// The step's length grows or shrinks by at most this factor from one step to the next.
  double most_change = 5;  // 1
  /// The angle by which links turn in the first step: large enough for the estimate to say
  /// something, small enough that the step is rarely refused. Nor may a step err by more than what
  /// turns the shortest link so far: beyond it an estimate to first order says nothing of turns.
  double turn = 0.3;  // rad

  // From one scheme to another.

  /// Adams is tried where the error allows DOP853 at least this share of what the waves do: below
  /// it, order 4 would need shorter steps than its lower cost makes up for.
  double held_up = 0.25;  // 1
  /// A scheme that handed over is tried again after so many steps; four times as many after each
  /// failure, up to the second number. Unsuccessful trials then cost less than a hundredth.
  int shortest_rest = 4;    // steps
  int longest_rest = 1024;  // steps

  // Where steps end.

  /// States between steps are interpolated, rather than steps ended there, where the tolerance is
  /// at least this share of the length: quintic interpolation over steps that follow each wave is
  /// off by less.
  double interpolated = 1e-3;  // 1
  /// More steps than that in so short a time lead nowhere: no motion needs them, as of links at
  /// their full length between what holds them.
  int most_steps = 3000;
  double brief = 1e-7;  // s
  /// No motion needs shorter steps than that.
  double shortest = 1e-12;  // s
  /// The longest step; with a driven end, whose motion between two stages no estimate sees, the
  /// other: a frame at 30 a second.
  double longest = 0.25, longest_driven = 1.0 / 30;  // s
};

inline constexpr StepConstants kConstants;

}  // namespace taut::direct
