// Steps a group of connectors side by side, a lane each. Written once, and compiled for every width
// of vectors by the files beside this one. No function of the standard library is used: the linker
// could take its wide form for the whole program.
#pragma once

#include <cstddef>

#include "sim/links/link_loops.h"

namespace taut::batch {

/// The arrays of a group, in the order in which they lie: `links` rows of its vectors each, with a
/// row before the first and behind the last that the loops may look at.
enum Array : std::size_t {
  kDirection = 0,     // x y z, unit vectors along the links
  kChord = 3,         // x y z, 1/s, what the last step turned them by, over the step
  kRate = 6,          // x y z, 1/s, the rates foreseen for where it ended
  kAcceleration = 9,  // x y z, 1/s^2, where it began
  // The constants of the loops, as direct::Links has them.
  kCoupling = 12,
  kWeight = 13,
  kNextGain = 14,
  kLastGain = 15,
  kOwnGain = 16,
  kDiagonalFirst = 17,
  kDiagonalSecond = 18,
  kScale = 19,
  kInverseRest = 20,  // 1/m
  // The tensions' system, see solve_chain().
  kOffDiagonal = 21,
  kSineSquared = 22,
  kRight = 23,
  kUnknown = 24,
  kScratch = 25,
  kArrays = 28,
};

/// Numbers of a group.
constexpr std::size_t group_size(std::size_t links, std::size_t lanes) {
  return (kArrays * links + 2) * lanes;
}

template <typename Scalar>
struct Steps {
  std::size_t count = 0;
  Scalar dt = 0;                 // s
  bool first = false;            // the state is a start: chords hold the rates there
  const Scalar* pull = nullptr;  // x y z of gravity less the upper end's acceleration, a lane each
  std::size_t pull_stride = 0;   // scalars from one step's pull to the next's
};

/// Verlet's method on directions of links: from the tensions that all links need together at one
/// instant, by the loops and the elimination of the method direct, a kick, and a drift that is
/// brought back to the sphere. Second order, one solve a step.
template <typename V, typename Scalar>
[[gnu::always_inline]] inline void advance_group(std::size_t links, void* group,
                                                 const Steps<Scalar>& steps) {
  const std::size_t n = links;
  V* const base = static_cast<V*>(group) + 1;
  const auto array = [&](std::size_t index) -> V* { return base + index * n; };
  V *const q = array(kDirection), *const chord = array(kChord), *const rate = array(kRate);
  V *const acceleration = array(kAcceleration), *const right = array(kRight);
  const V *const scale = array(kScale), *const inverse_rest = array(kInverseRest);
  const Scalar dt = steps.dt, half = dt / 2, per_dt = 1 / dt;

  Scalar kick = steps.first ? half : dt;
  for (std::size_t step = 0; step < steps.count; ++step, kick = dt) {
    const V* const pull = reinterpret_cast<const V*>(steps.pull + step * steps.pull_stride);
    assemble_loop<3, V>(n, q, rate, array(kCoupling), array(kWeight), array(kOffDiagonal),
                        array(kSineSquared), right);
    right[0] += scale[0] * (q[0] * pull[0] + q[n] * pull[1] + q[2 * n] * pull[2]);
    solve_chain_loop<V>(links, array(kDiagonalFirst), array(kDiagonalSecond), array(kOffDiagonal),
                        array(kSineSquared), right, array(kUnknown), array(kScratch));
    pull_loop<3, V>(n, q, array(kNextGain), array(kLastGain), array(kOwnGain), array(kUnknown),
                    acceleration);
    for (std::size_t c = 0; c < 3; ++c) acceleration[c * n] += inverse_rest[0] * pull[c];

    for (std::size_t i = 0; i < n; ++i) {
      V kicked[3], drift[3], square = {};
      for (std::size_t c = 0; c < 3; ++c) {
        kicked[c] = chord[c * n + i] + kick * acceleration[c * n + i];
        drift[c] = q[c * n + i] + dt * kicked[c];
        square += drift[c] * drift[c];
      }
      // 1/sqrt(1 + e) by its series: e is of the fourth order in the angle of a step.
      const V excess = square - Scalar(1);
      const V shorten = excess * (Scalar(0.375) * excess - Scalar(0.5));
      for (std::size_t c = 0; c < 3; ++c) {
        const V back = shorten * drift[c], mean = kicked[c] + per_dt * back;
        q[c * n + i] = drift[c] + back;
        chord[c * n + i] = mean;
        rate[c * n + i] = mean + half * acceleration[c * n + i];
      }
    }
  }
}

}  // namespace taut::batch
