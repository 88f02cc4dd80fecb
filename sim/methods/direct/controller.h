// Step control: its constants, how far each step goes, and why one fails.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "sim/links/mechanism.h"
#include "sim/run/method.h"
#include "sim/topology/components.h"

namespace taut::direct {

// Every constant of the step control, in one place.

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

/// The user's wish: an error, or a step.
struct StepOptions {
  double tolerance = 1e-4;  // m
  double step = 0;          // s; zero: steps follow from the tolerance
  double finer = 1;         // the factor by which steps are shorter, for estimates of the error

  /// The error (m) that a run of something so long (m) may make: with a fixed step, the one at
  /// which a step is done again in shorter ones.
  double asked(double length) const;
};

inline constexpr double kNever = std::numeric_limits<double>::infinity();

/// What a step that was tried came to.
struct Attempt {
  bool solved = false;          // else a shorter one may be
  double error = 0, limit = 0;  // m: the estimate, and what it may be
  double event = kNever;        // s after its start: where it has to end instead
  double least = 0;             // s: the next step is no shorter
  bool may_grow = true;         // whether the next step may be longer, if the error is small
};

/// Something that takes single steps, on from a state of its own.
class Stepping {
 public:
  virtual ~Stepping() = default;
  virtual double first_step() const = 0;  // s, where nothing is known of errors
  /// The longest step (s) from the present state at `time`.
  virtual double longest_step(double time) = 0;
  /// The power of a step's length with which its error grows.
  virtual double order() const = 0;
  /// Whether steps, which may be as long as `wish`, end at the time that is asked for and `left`
  /// away. Else they go beyond.
  virtual bool lands(double left, double wish) const = 0;
  /// Tries a step of `h` from `time`. Nobody sees what comes after `until`.
  virtual Attempt attempt(double time, double h, double until) = 0;
  /// Goes on from the end, at `time`, of the step that was tried.
  virtual void accept(double time) = 0;
  /// Throws Diverged with the cause, where no step leads on from `time`.
  [[noreturn]] virtual void give_up(double time) = 0;
};

/// Counts steps, and says where they get nowhere.
class StallWatch {
 public:
  void start(double time) {
    since_ = time;
    steps_ = 0;
  }
  /// Of a step that ended at `time`: false where there were too many in too short a time.
  bool count(double time);

 private:
  double since_ = 0;  // s, from which on steps are counted
  int steps_ = 0;
};

/// The step (s) whose error would be the one allowed, after one of h with `error` where `limit` was
/// allowed.
double suited_step(double h, double error, double limit, double order);

/// Leads a stepper through time: each step is as long as its error allows, or fixed and shorter
/// only where that cannot be.
class Controller {
 public:
  explicit Controller(const StepOptions& options) : options_(options) {}

  /// Begins at a state of that time; what is known of errors stays.
  void start(double time) { time_ = before_ = time; }
  double time() const { return time_; }      // s, where the last step ended
  double before() const { return before_; }  // s, where it began
  /// Goes as far as `until`, or beyond where steps do not land.
  void follow(Stepping& stepper, double until, Counters& counters);

 private:
  double to_multiple() const;
  void learn(double h, double suited);

  StepOptions options_;
  double time_ = 0, before_ = 0;
  double step_ = 0;  // s, what the error allows; zero: not known yet
  StallWatch watch_;
};

// Why no step is small enough: links at their full length between two holds.

/// The link, or massless span, between two places that are held, as is known beforehand, which the
/// world's state stretches or, a link, compresses: says so. Empty where there is none. No part has
/// such a link. Connectors that stretch, bend or meet the air are left out.
struct LedAway {
  std::size_t connector = 0, link = 0;
  std::string what;
};
std::optional<LedAway> led_away(const World& world);

/// Where links of the part have no slack left between two places that are held, as is known
/// beforehand, and so have nowhere to go: says so. Empty where there is none.
std::string full_length(const World& world, const Component& part, double time);

/// What to throw where no step leads on from a state of the world's mechanism at `time` (s), after
/// so many steps. Names the connector that is pressed together or at its full length, else the
/// fastest particle.
Diverged no_step(const World& world, const Mechanism& mechanism, const double* state, double time,
                 std::uint64_t steps);

}  // namespace taut::direct
