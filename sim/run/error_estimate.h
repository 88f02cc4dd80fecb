// The error of a simulation, told while it runs, without any truth.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/run/method.h"
#include "sim/run/simulation.h"

namespace taut {

// A method that runs beside another, coarser as a rule, whose error is a known multiple.

/// A method that runs beside another so that the difference tells the error: see ErrorEstimate.
struct Companion {
  std::unique_ptr<Method> method = nullptr;  // null: there is none
  /// `ratio`: its error over the run's (less than 1 where it is the finer one). Where that is zero,
  /// `order`: the error grows with this power of the steps' length.
  double ratio = 0, order = 0;
  /// The companion divides so many frames into one part more, all equal, so that its steps are
  /// shorter in that ratio. Zero: it sees the frames that the run sees.
  int frames = 0;
  /// Tells the companion what the run has done since the last call; null: it need not know.
  void (*heed)(Method& companion, const Method& run) = nullptr;
  double asked = 0;            // m, the error that the settings ask for; 0: they name none
  std::string_view none = {};  // why there is none, to be read after the method's name
};

/// With the tolerance of this name 4 times as large, or as large as it can be, and an error in
/// proportion. None where it cannot be even twice as large. A tolerance in metres is what is asked.
Companion with_tolerance_raised(const MethodInfo& method, Settings settings,
                                std::string_view tolerance);

/// With steps twice as long, for methods of equal steps of the setting `step` and an error in
/// proportion to its power `order`.
Companion with_step_doubled(const MethodInfo& method, Settings settings, double order);

/// Runs the same world and timeline a second time beside it by the same method, finer or coarser
/// (MethodInfo::companion), and takes the error from the difference by Richardson's extrapolation:
/// |difference| / |r - 1|, where the other's error is r times as large. The errors are in
/// proportion while the difference is below a tenth of length_scale() and of how far the motion has
/// gone; above, the difference itself is the estimate.
///
/// The error is what a tolerance is, too: the RMS distance (m) of all particles of all connectors
/// or, where there is no connector, of the ends of all free bodies (see box_ends()). It is the
/// error of the discretisation in time alone: other differences between a method and the truth (the
/// stretch of springs, say) stay unknown.
///
/// A coarser companion costs less than the simulation itself; the finer one of `direct` a fifth
/// more, since a high order makes a far smaller error hardly dearer. Steps that end with frames
/// show a difference only over several frames: a finer companion is compared every four of them,
/// more often in the first dozen, a coarser one every four steps. Frames between have the estimate
/// of the one before.
class ErrorEstimate {
 public:
  /// Of the simulation of `world` by `method` with `settings` (those left out take their defaults)
  /// under `timeline`, as Simulation takes them. Throws std::invalid_argument as make_method().
  ErrorEstimate(const World& world, std::string_view method, const Settings& settings,
                const Timeline& timeline = {});

  /// Goes to where the simulation is now. Allocates nothing where Simulation::advance_to() does
  /// not. Throws std::invalid_argument where the simulation had interventions beside its timeline.
  void follow(const Simulation& simulation);

  /// Why there is no estimate, or empty. Then nothing is run, and the error is not a number.
  const std::string& none() const { return none_; }

  /// At the last frame, and the largest so far (m); infinite once the companion has diverged.
  double error() const { return error_; }
  double largest() const { return largest_; }
  /// The cause of the companion's divergence; empty: it did not diverge.
  const std::string& diverged() const { return diverged_; }

  /// The error (m) up to which a motion counts as predictable: the tolerance, where the method was
  /// given one in metres, otherwise a hundredth of length_scale().
  double limit() const { return limit_; }
  /// The first time (s) at which the estimate was above limit(); none: it never was.
  std::optional<double> predictable_until() const { return predictable_until_; }

 private:
  struct Ends {
    std::size_t body = 0;
    std::array<Vec3, 6> at;  // m, body frame
  };
  using Points = std::vector<Vec3>;  // m

  bool due(const Simulation& simulation);
  void advance_companion(const Simulation& simulation);
  void sample(const World& world, Points& points) const;
  void compare(const Simulation& simulation);
  void note(double time, double error);

  std::string none_, diverged_;
  Companion companion_;  // without its method
  double length_ = 0;    // m, as length_scale() has it
  double limit_ = 0;
  double error_, largest_;
  std::optional<double> predictable_until_;
  std::optional<Simulation> other_;
  std::vector<Ends> ends_;           // of the free bodies
  int frames_ = 0, uncompared_ = 0;  // followed in all, since it was compared last
  double time_ = 0;                  // s, of the simulation when it was followed last
  std::uint64_t followed_ = 0;       // steps of the simulation then
  bool passes_frames_ = false;       // the simulation's steps do not end at frames
  std::uint64_t steps_ = 0;          // of the simulation when it was compared last
  double travelled_ = 0;             // m, RMS, the farthest from start_points_
  std::uint64_t topology_ = 0;       // of start_points_
  Points points_, other_points_;     // of the simulation, of the companion
  Points start_points_;              // where the simulation was when its topology was new
};

}  // namespace taut
