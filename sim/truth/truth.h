// The truth that methods are scored against, and its horizon.
#pragma once

#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/run/method.h"
#include "sim/run/trajectory.h"

namespace taut::truth {

// The reference that runs are scored against: a converged solution at the frame times.

struct Reference {
  std::vector<Snapshot> frames;
  /// Time (s) up to which errors may be scored. Of solve_truth(): until then a start nudged by a
  /// ten-thousandth of the scored error stays a hundred times closer to the truth than that error,
  /// and so does the second solution. Beyond it states are not predictable, and only invariants can
  /// be compared.
  double horizon = 0;
  /// The largest distance (m) of any particle between two independent solutions until then.
  double self_error = 0;
};

/// Of the scored error: how far a start is nudged, and how far apart solutions may be.
inline constexpr double kTruthNudge = 1e-4, kTruthAgreement = 1e-2;

struct TruthOptions {
  /// The least error (m) that will be scored; it sets the nudge and the horizon.
  double scored_error = 1e-4;
  /// Error allowed in a step: of the first solver in metres, of the second relative.
  double local_error = 1e-12;
  double second_accuracy = 1e-10;
  /// Whether nudged starts are followed too; else the horizon is where the two solvers agree.
  bool nudges = true;
  double cpu_cap = std::numeric_limits<double>::infinity();  // s, of each solution
};

/// Options for a truth that tells runs within `scored_error` (m) from others and no more.
inline TruthOptions quick_truth(double scored_error, double cpu_cap) {
  return {.scored_error = scored_error,
          .local_error = 1e-9,
          .second_accuracy = 1e-5,
          .nudges = false,
          .cpu_cap = cpu_cap};
}

/// A converged solution of the discrete model by two independent solvers (multipliers with
/// projection under Runge-Kutta-Fehlberg 7(8); joint coordinates under Simbody's
/// Runge-Kutta-Merson; among obstacles the first from event to event, and the time stepping of
/// `direct`, whose step is halved until it agrees; with materials or joints the schemes of `direct`
/// for those; where only `direct` follows the world, that at a tight tolerance) and once more from
/// a nudged start. `times` (s) rise from the world's own on. Where one of the two comparisons ends
/// early the horizon does too; where the first solver does, the frames do. Calls `tick`, where
/// there is one, after each frame of each solution; it may throw. Throws Diverged where the first
/// solver gets nowhere.
Reference solve_truth(const World& world, std::span<const double> times,
                      const TruthOptions& options = {}, const Timeline& timeline = {},
                      const std::function<void()>& tick = {});

/// The time stepping of `direct` at a step (s), for worlds whose friction the truth gives up. The
/// self-error is how far twice the step is from it; the horizon ends where that is more than a
/// tenth of `scored_error` (m).
Reference stepped_reference(const World& world, std::span<const double> times, double step,
                            double scored_error, const Timeline& timeline = {},
                            const std::function<void()>& tick = {});

/// `world` with its particles moved sideways by up to `distance` (m): more and more along each
/// connector or, `rough`, by turns to one side and the other. A method's first projection puts the
/// lengths right again.
World nudged(World world, double distance, bool rough);

}  // namespace taut::truth
