// The error of a simulation, told while it runs, without any truth.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim/coarse_method.h"
#include "sim/simulation.h"

namespace taut {

/// Lets the same world and timeline go beside a simulation by the same method with coarser settings
/// (MethodInfo::coarse), and takes the error from the difference of the two by Richardson's
/// extrapolation: |difference| / (r - 1), where the coarser one's error is r times as large. Where
/// the difference is above a tenth of the longest connector, or of how far the motion has gone, the
/// errors are no longer in proportion, and the difference itself is the estimate.
///
/// The error is the RMS distance (m) of all particles of all connectors and of the ends of all free
/// bodies (see box_ends()); a body that is simulated as a link counts by its link's far particle.
/// It is that of the discretisation in time alone: what else there is between a method and the
/// truth (the stretch of springs, say) it does not tell.
///
/// The cost is less than that of the simulation itself. Where frames end steps, and have fewer than
/// four, frames are compared every four steps; those between have the estimate of the one before.
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

  /// At the last frame, and the largest so far (m); infinite once the coarser one has diverged.
  double error() const { return error_; }
  double largest() const { return largest_; }
  /// What the coarser one diverged of; empty: it did not.
  const std::string& diverged() const { return diverged_; }

  /// The error (m) up to which a motion counts as foretold: the tolerance, where the method was
  /// given one in metres, otherwise a hundredth of the longest connector.
  double limit() const { return limit_; }
  /// The first time (s) at which the estimate was above limit(); none: it never was.
  std::optional<double> foretold_until() const { return foretold_until_; }

 private:
  struct Ends {
    std::size_t body = 0;
    std::array<Vec3, 6> at;  // m, body frame
  };
  using Points = std::vector<Vec3>;  // m

  bool due(const Simulation& simulation);
  void look(const World& world, Points& points) const;
  void compare(const Simulation& simulation);
  void note(double time, double error);

  std::string none_, diverged_;
  double ratio_ = 0, order_ = 0;  // as CoarseMethod has them
  double length_ = 0;             // m, of the longest connector
  double limit_ = 0;
  double error_, largest_;
  std::optional<double> foretold_until_;
  std::optional<Simulation> coarse_;
  std::vector<Ends> ends_;       // of the free bodies
  double time_ = 0;              // s, of the simulation when it was followed last
  std::uint64_t followed_ = 0;   // steps of the simulation then
  bool passes_frames_ = false;   // the simulation's steps do not end at frames
  std::uint64_t steps_ = 0;      // of the simulation when it was compared last
  double gone_ = 0;              // m, how far from where it was when the topology was new
  std::uint64_t topology_ = 0;   // of `from_`
  Points here_, beside_, from_;  // of the simulation, of the coarser one, where gone_ is from
};

}  // namespace taut
