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
  kBeside = 13,    // work: entry beside the diagonal
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
template <typename V, typename Scalar>
[[gnu::always_inline]] inline void advance_group(std::size_t links, void* group,
                                                 const Steps<Scalar>& steps) {
  V* const __restrict base = static_cast<V*>(group);
  const auto at = [&](std::size_t array, std::size_t link) -> V& {
    return base[array * links + link];
  };
  const Scalar dt = steps.dt, half = dt / 2, per_dt = 1 / dt;
  Scalar kick = steps.first ? half : dt;
  for (std::size_t step = 0; step < steps.count; ++step, kick = dt) {
    const V* const pull = reinterpret_cast<const V*>(steps.pull + step * steps.pull_stride);

    // Down: the rows (w + w') T - w' c T' - w c'' T'' = l |rate|^2, eliminated on the way.
    V beside = {}, right = {}, pivot = {};  // of the row above
    for (std::size_t i = 0; i < links; ++i) {
      V square = at(kRate, i) * at(kRate, i) + at(kRate + 1, i) * at(kRate + 1, i) +
                 at(kRate + 2, i) * at(kRate + 2, i);
      V wanted = at(kRest, i) * square;
      if (i == 0) {
        wanted += at(kDirection, 0) * pull[0] + at(kDirection + 1, 0) * pull[1] +
                  at(kDirection + 2, 0) * pull[2];
      }
      const V factor = beside * pivot;
      right = wanted + factor * right;
      pivot = Scalar(1) / (at(kBoth, i) - factor * beside);
      if (i + 1 < links) {
        beside = at(kLower, i) * (at(kDirection, i) * at(kDirection, i + 1) +
                                  at(kDirection + 1, i) * at(kDirection + 1, i + 1) +
                                  at(kDirection + 2, i) * at(kDirection + 2, i + 1));
      } else {
        beside = V{};
      }
      at(kBeside, i) = beside;
      at(kRight, i) = right;
      at(kPivot, i) = pivot;
    }

    // Up: the tensions, and with the one above known, each link's turn.
    const auto turn = [&](std::size_t i, const V(&below)[3], const V(&above)[3]) {
      V drift[3], acceleration[3], square = {};
      for (std::size_t c = 0; c < 3; ++c) {
        acceleration[c] = at(kGain, i) * (below[c] - above[c]);
        at(kChord + c, i) += kick * acceleration[c];
        drift[c] = at(kDirection + c, i) + dt * at(kChord + c, i);
        square += drift[c] * drift[c];
      }
      // 1/sqrt(1 + e) by its series: e is of the fourth order in the angle of a step.
      const V excess = square - Scalar(1);
      const V shorten = excess * (Scalar(0.375) * excess - Scalar(0.5));
      for (std::size_t c = 0; c < 3; ++c) {
        const V back = shorten * drift[c];
        at(kDirection + c, i) = drift[c] + back;
        const V chord = at(kChord + c, i) + per_dt * back;
        at(kChord + c, i) = chord;
        at(kRate + c, i) = chord + half * acceleration[c];
      }
    };
    V tension = {}, force[3] = {}, below[3] = {};  // of the link below; of its lower particle
    for (std::size_t i = links; i-- > 0;) {
      tension = (at(kRight, i) + at(kBeside, i) * tension) * at(kPivot, i);
      at(kTension, i) = tension;
      V particle[3];  // acceleration of the particle below link i
      for (std::size_t c = 0; c < 3; ++c) {
        const V own = tension * at(kDirection + c, i);
        particle[c] = at(kLower, i) * (force[c] - own);
        force[c] = own;
      }
      if (i + 1 < links) turn(i + 1, below, particle);
      for (std::size_t c = 0; c < 3; ++c) below[c] = particle[c];
    }
    const V above[3] = {-pull[0], -pull[1], -pull[2]};
    turn(0, below, above);
  }
}

}  // namespace taut::batch
