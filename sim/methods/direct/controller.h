// Step control: which scheme takes a step, and how far it goes.
#pragma once

#include <array>

namespace taut::direct {

/// What the user asked for: an error, or a step.
struct Options {
  double tolerance = 1e-4;  // m
  double step = 0;          // s; zero: steps follow from the tolerance
};

enum class Scheme { dop853, verlet, bdf };
inline constexpr std::size_t kSchemes = 3;

/// All constants of the step control.
struct Constants {
  /// What the errors of dop853's steps may add up to in a second by its estimate, in tolerances;
  /// and what the error of a scheme of order 2 may be at any time.
  double rate = 60, share = 0.1;
  /// The time that an error of speed counts for, in those of a pendulum, sqrt(L/g).
  double memory = 0.15;
  /// The time in which errors of order 2 accumulate, in the same.
  double span = 4;
  /// What a step costs, in accelerations.
  std::array<double, kSchemes> cost = {14, 1.2, 2.5};
  /// The frequency (rad) times the step up to which the explicit schemes are stable while tensions
  /// rise.
  std::array<double, 2> stable = {5.2, 1.5};
  /// A step is as long as its error allows, times this.
  double safety = 0.9;
  /// A step of a scheme of order 2 is done again where its error is so many times the one allowed;
  /// in any case the next one is shorter.
  double refused = 3;
  /// Of its length, the most that a link may be off before its length is kept.
  double most_excess = 0.03;
  /// Another scheme has to be so many times as fast.
  double worthwhile = 1.3;
  /// Errors of a step may be this share of a link, or links fold.
  double roughness = 0.3;
  /// s, of any step; where ends are driven, of one that no shown state ends.
  double longest = 0.25, longest_driven = 1.0 / 30;
};

/// A step to be taken.
struct Step {
  Scheme scheme = Scheme::dop853;
  double h = 0;        // s
  double end = 0;      // s
  double allowed = 0;  // m, the error
};

/// How it went.
struct Outcome {
  double error = 0;      // m, estimated
  double excess = 0;     // of its length, the most that a link was off
  double frequency = 0;  // rad/s, of the waves at its end
  double bent = 0;  // m, of dop853: the error that a step of Verlet's at its stability limit has
};

class Controller {
 public:
  explicit Controller(const Options& options) : options_(options) {}

  struct Component {
    double length = 0, shortest = 0;  // m
    double time_scale = 0;            // s
    double rounding = 0;              // 1, what the last digits of a link leave of its acceleration
    bool driven = false;              // some hold moves
    bool only_bodies_free = false;    // position Verlet can follow it
  };
  void begin(const Component& component, double frequency, double first_step);

  Step choose(double time, double until, double frequency);
  /// Whether the step is good; chooses the next scheme and step.
  bool accept(const Step& step, const Outcome& outcome);

  double span() const { return constants_.span * component_.time_scale; }      // s
  double memory() const { return constants_.memory * component_.time_scale; }  // s
  Scheme scheme() const { return scheme_; }
  double verlet_limit(double frequency) const { return constants_.stable[1] / frequency; }

 private:
  double allowed(Scheme scheme, double h, double frequency) const;
  double longest() const {
    return component_.driven ? constants_.longest_driven : constants_.longest;
  }
  void choose_scheme(const Step& step, const Outcome& outcome);
  void change_to(Scheme scheme, double h);

  Options options_;
  Constants constants_;
  Component component_;
  Scheme scheme_ = Scheme::dop853;
  std::array<double, kSchemes> step_{};  // s, what errors allow each scheme, as last known
  int refused_ = 0;                      // in a row
  double longest_shown_ = 0;             // s, between two shown states
};

}  // namespace taut::direct
