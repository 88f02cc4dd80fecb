// Putting a state onto its links: positions so that all have their lengths, velocities so that none
// changes it.
#pragma once

#include <vector>

#include "sim/links/mechanism.h"
#include "sim/links/tension.h"

namespace taut {

/// Projects states of one mechanism along M^-1 J^T, which moves as little as it takes, all masses
/// counted. Both change linear momentum only by what holds give, which act at their points.
class Projection {
 public:
  /// Lengths that stay off by more (m) cannot be kept.
  static constexpr double kKept = 1e-8;

  /// The remaining violation of the rows; not finite where the state was not.
  struct Left {
    double violation = 0;  // m, the largest
    std::size_t row = 0;   // where that is
  };

  Projection() = default;
  explicit Projection(const Mechanism& mechanism) { rebuild(mechanism); }

  /// Makes room for the mechanism, and as much as that has.
  void rebuild(const Mechanism& mechanism);

  /// Newton's method on the lengths, to rounding where they can be kept.
  Left lengths(Mechanism& mechanism, double time, std::vector<double>& state);

  /// The impulses that stop all links from changing their length.
  void rates(Mechanism& mechanism, double time, std::vector<double>& state);

 private:
  const std::vector<double>& right_side(const std::vector<double>& rows);

  TensionSystem system_;
  std::vector<double> multiplier_;  // per row: kg m or N s
  std::vector<double> right_;       // where there are pulleys
};

/// Gives all links of `world` their lengths, whatever moves for it: particles and free bodies.
/// False, and nothing has changed, where holds do not let them.
bool restore_lengths(World& world);

/// Whether velocities change the length of some link by more than rounding; held particles are
/// where they are placed.
bool stretches(const World& world);

/// Changes the velocities of a world by the impulses that stop all links from changing their
/// length, as when a moving particle is pinned. Keeps its workspace.
class VelocityProjection {
 public:
  void stop(World& world);

 private:
  Mechanism mechanism_;
  Projection projection_;
  std::vector<double> state_;
};

}  // namespace taut
