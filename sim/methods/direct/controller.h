// Step control: how far each step goes, and what becomes of one that fails.
#pragma once

#include <limits>

#include "sim/run/method.h"

namespace taut::direct {

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

}  // namespace taut::direct
