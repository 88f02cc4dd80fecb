// One group of connectors side by side, a lane each, through a number of steps. Written once, and
// compiled for every width of vectors by the files beside this one. No function of the standard
// library is used: the linker could take its wide form for the whole program.
#pragma once

#include <cstddef>

namespace taut::batch {

/// The arrays of a group, in the order in which they lie: `links` vectors each.
enum Array : std::size_t {
  kDirection = 0,  // x y z, unit vectors along the links
  kChord = 3,      // x y z, 1/s, what the last step turned them by, over the step
  kRate = 6,       // x y z, 1/s, the rates foreseen for where it ended
  kLower = 9,      // 1/kg, inverse mass of the particle below
  kBoth = 10,      // 1/kg, of both particles together, zero for the held one
  kRest = 11,      // m
  kGain = 12,      // 1/m, one over kRest
  kBeside = 13,    // work: entry that couples a row with the one above
  kRight = 14,     // work: right side, eliminated
  kPivot = 15,     // work: one over the pivot
  kTension = 16,   // N, of the last step
  kArrays = 17,
};

template <typename Scalar>
struct Steps {
  std::size_t count = 0;
  Scalar dt = 0;                 // s
  bool first = false;            // the state is a start: chords hold the rates there
  const Scalar* pull = nullptr;  // x y z of gravity less the upper end's acceleration, a lane each
  std::size_t pull_stride = 0;   // scalars from one step's pull to the next's
};

/// Verlet's method on directions of links: from the tensions that all links need together at one
/// instant (a tridiagonal system; the square of the foreseen rates stands on its right), a kick,
/// and a drift that is brought back to the sphere. Second order, one solve a step.
///
/// `kGroups` vectors lie side by side: while the elimination of one waits for its last result, the
/// others go on. What does not wait has loops of its own, which need few registers.
template <typename V, std::size_t kGroups, typename Scalar>
[[gnu::always_inline]] inline void advance_group(std::size_t links, void* group,
                                                 const Steps<Scalar>& steps) {
  V* const __restrict base = static_cast<V*>(group);
  const auto at = [&](std::size_t array, std::size_t link, std::size_t g) -> V& {
    return base[(array * links + link) * kGroups + g];
  };
  const auto dot = [](const V(&a)[3], const V(&b)[3]) -> V {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  const Scalar dt = steps.dt, half = dt / 2, per_dt = 1 / dt;

  Scalar kick = steps.first ? half : dt;
  for (std::size_t step = 0; step < steps.count; ++step, kick = dt) {
    const V* const pull = reinterpret_cast<const V*>(steps.pull + step * steps.pull_stride);

    // The rows (w + w') T - w' c T' - w'' c'' T'' = l |rate|^2 [+ u . pull, of the first].
    for (std::size_t g = 0; g < kGroups; ++g) {
      V last[3] = {}, lower = {};  // of the link above
      for (std::size_t i = 0; i < links; ++i) {
        V own[3], rate[3];
        for (std::size_t c = 0; c < 3; ++c) {
          own[c] = at(kDirection + c, i, g);
          rate[c] = at(kRate + c, i, g);
        }
        at(kBeside, i, g) = lower * dot(last, own);
        at(kRight, i, g) = at(kRest, i, g) * dot(rate, rate);
        lower = at(kLower, i, g);
        for (std::size_t c = 0; c < 3; ++c) last[c] = own[c];
      }
      at(kRight, 0, g) += at(kDirection, 0, g) * pull[g] +
                          at(kDirection + 1, 0, g) * pull[kGroups + g] +
                          at(kDirection + 2, 0, g) * pull[2 * kGroups + g];
    }

    // Down: eliminated.
    V right[kGroups] = {}, pivot[kGroups] = {};  // of the row above
    for (std::size_t i = 0; i < links; ++i) {
      for (std::size_t g = 0; g < kGroups; ++g) {
        const V beside = at(kBeside, i, g), factor = beside * pivot[g];
        right[g] = at(kRight, i, g) + factor * right[g];
        pivot[g] = Scalar(1) / (at(kBoth, i, g) - factor * beside);
        at(kRight, i, g) = right[g];
        at(kPivot, i, g) = pivot[g];
      }
    }

    // Up: the tensions.
    V carried[kGroups] = {};  // what the link below adds
    for (std::size_t i = links; i-- > 0;) {
      for (std::size_t g = 0; g < kGroups; ++g) {
        const V tension = (at(kRight, i, g) + carried[g]) * at(kPivot, i, g);
        at(kTension, i, g) = tension;
        carried[g] = at(kBeside, i, g) * tension;
      }
    }

    // Each link's turn, by the accelerations of its two particles.
    for (std::size_t g = 0; g < kGroups; ++g) {
      V above[3], force[3], direction[3];  // of the upper particle; the link's own
      for (std::size_t c = 0; c < 3; ++c) {
        above[c] = -pull[c * kGroups + g];
        direction[c] = at(kDirection + c, 0, g);
        force[c] = at(kTension, 0, g) * direction[c];
      }
      for (std::size_t i = 0; i < links; ++i) {
        V chord[3], drift[3], acceleration[3], next[3] = {}, pulled[3] = {};
        if (i + 1 < links) {
          for (std::size_t c = 0; c < 3; ++c) {
            next[c] = at(kDirection + c, i + 1, g);
            pulled[c] = at(kTension, i + 1, g) * next[c];
          }
        }
        const V lower = at(kLower, i, g), gain = at(kGain, i, g);
        for (std::size_t c = 0; c < 3; ++c) {
          const V below = lower * (pulled[c] - force[c]);
          acceleration[c] = gain * (below - above[c]);
          force[c] = pulled[c];
          above[c] = below;
          chord[c] = at(kChord + c, i, g) + kick * acceleration[c];
          drift[c] = direction[c] + dt * chord[c];
          direction[c] = next[c];
        }
        // 1/sqrt(1 + e) by its series: e is of the fourth order in the angle of a step.
        const V excess = dot(drift, drift) - Scalar(1);
        const V shorten = excess * (Scalar(0.375) * excess - Scalar(0.5));
        for (std::size_t c = 0; c < 3; ++c) {
          const V back = shorten * drift[c], mean = chord[c] + per_dt * back;
          at(kDirection + c, i, g) = drift[c] + back;
          at(kChord + c, i, g) = mean;
          at(kRate + c, i, g) = mean + half * acceleration[c];
        }
      }
    }
  }
}

}  // namespace taut::batch
