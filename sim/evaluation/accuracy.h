// Errors of recorded states against reference states at the same times.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "sim/motion/types.h"
#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut::study {

// Points by which motions are compared, whatever chain of particles stands for the connector.

/// The material points of one world: every particle of its connectors, and of each body the ends of
/// the box with its mass and inertia (for a stick, the ends of the stick).
class SamplePoints {
 public:
  /// `start`: the state at the beginning, from which lengths along the connectors are taken.
  SamplePoints(const World& world, const Snapshot& start);

  /// Where the sample points of `of` are in a state of this world (m). Connectors and bodies must
  /// be those of `of`; a connector may have another number of particles, between which its links
  /// are straight. Where winches and pulleys change a connector's length, a point keeps its share
  /// of that, by which material flows past it.
  std::vector<Vec3> places(const SamplePoints& of, const Snapshot& state) const;

 private:
  /// A connector whose length changes.
  struct Running {
    std::shared_ptr<const Winch> winch;
    std::vector<std::size_t> enters, leaves;  // pulleys, by which rope comes and goes
  };
  /// The shares of the length at which a connector's particles are in a state of either world.
  std::vector<double> along(std::size_t connector, const Snapshot& state) const;

  std::vector<std::vector<double>> along_;  // [connector][particle], share of the length at first
  std::vector<Running> running_;            // [connector], without a winch where it keeps that
  std::vector<std::vector<Vec3>> ends_;     // [body], m, body frame
};

/// How far a particle at `at` is from where it should be (`truth`), both m, at `time` (s); in
/// whatever unit the metric has.
using Distance = std::function<double(const Vec3& at, const Vec3& truth, double time)>;

struct Metric {
  std::string name;  // "share of the length"
  std::string unit;  // "1", "px"
  Distance distance;
};

/// Distance as a share of `length` (m).
Metric share_of_length(double length);

/// RMS of the distance over all particles and all frames up to `horizon` (s). Infinite where
/// `frames` end before the horizon does. The particles must match; throws std::invalid_argument.
double rms_error(std::span<const Snapshot> frames, std::span<const Snapshot> truth, double horizon,
                 const Distance& distance);

/// RMS of the distance over the particles of one frame.
double frame_error(const Snapshot& frame, const Snapshot& truth, const Distance& distance);

/// Mean distance (m) of the segments' midpoints: the measure of the paper's Figure 6.
double segment_difference(const Snapshot& frame, const Snapshot& reference);

// Statistics that compare two motions once neither is predictable: energy, stretch of links, and
// speeds of points.

/// The speeds of points from frame to frame.
class Speeds {
 public:
  /// Where the points are in the next frame, `dt` (s) after the one before.
  void add(const std::vector<Vec3>& points, double dt);
  /// The next frame does not follow on the one before.
  void pause() { last_.clear(); }
  /// All of them so far (m/s), rising.
  std::vector<double> sorted() const;

 private:
  std::vector<Vec3> last_;
  std::vector<double> speeds_;
};

/// How far energies (J) are apart.
class EnergyDifference {
 public:
  /// `more` (J) than the other's in one more frame.
  void add(double more);
  double largest() const { return largest_; }
  double of_means() const;

 private:
  double largest_ = 0, sum_ = 0;
  std::size_t frames_ = 0;
};

/// The Kolmogorov-Smirnov distance of two samples, both rising: the largest difference of the
/// shares that lie below any value. Values that differ by at most `same` count as equal.
double distribution_distance(std::span<const double> a, std::span<const double> b, double same);

}  // namespace taut::study
