// A step of links in space by the places of their particles; see PlanarChain::leap().
#include <cmath>

#include "sim/methods/direct/links.h"
#include "sim/methods/direct/tridiagonal.h"

namespace taut::direct {
namespace {

constexpr std::size_t kComponents = 3;

using Out = double* __restrict;
using In = const double* __restrict;

/// Where links that turn on from `before` over q go under the tensions x. Second differences over
/// unequal steps are accelerations at the mean of their three times, where q has turned on by a
/// third of (ratio - 1).
TAUT_VECTOR_CLONES
void drift(std::size_t n, double ratio, double half_square, In next_gain, In last_gain, In own_gain,
           In x, In before, In q, Out lead) {
  const double on = (2 + ratio) / 3, back = (ratio - 1) / 3;
#pragma GCC ivdep  // components do not overlap
  for (std::size_t i = 0; i < n; ++i) {
    const double next = half_square * next_gain[i] * x[i + 1];
    const double last = half_square * last_gain[i] * x[i - 1];
    const double own = half_square * own_gain[i] * x[i];
    for (std::size_t c = 0; c < kComponents; ++c) {
      const std::size_t at = c * n + i;
      lead[at] = (1 + ratio - own * on) * q[at] - (ratio - own * back) * before[at] +
                 next * (on * q[at + 1] - back * before[at + 1]) +
                 last * (on * q[at - 1] - back * before[at - 1]);
    }
  }
}

/// Half way from q to `lead`, and by how much those are too long there. `n` is the stride.
TAUT_VECTOR_CLONES
void chords(std::size_t n, double per_half_square, In weight, In q, In lead, Out chord,
            Out diagonal, Out right) {
#pragma GCC ivdep  // components do not overlap
  for (std::size_t i = 0; i < n; ++i) {
    double square = 0, length = 0;
    for (std::size_t c = 0; c < kComponents; ++c) {
      const std::size_t at = c * n + i;
      chord[at] = (q[at] + lead[at]) / 2;
      square += chord[at] * chord[at];
      length += lead[at] * lead[at];
    }
    diagonal[i] = 2 * square;
    right[i] = weight[i] * per_half_square / 2 * (length - 1);
  }
}

TAUT_VECTOR_CLONES
void neighbours(std::size_t n, In beside, In chord, Out off) {
  for (std::size_t i = 0; i < n; ++i) {
    double dot = 0;
    for (std::size_t c = 0; c < kComponents; ++c) dot += chord[c * n + i] * chord[c * n + i + 1];
    off[i] = beside[i] * dot;
  }
}

struct Largest {
  double change = 0, wave = 0;  // squares
};

/// Takes the changes of the tensions, which act along the chords: writes what of them turns the
/// links, and where those go in place of `lead`. `squares` and `pulls` are workspaces.
TAUT_VECTOR_CLONES
Largest turn(std::size_t n, double half_square, In next_gain, In last_gain, In own_gain, In chord,
             Out x, In change, Out squares, Out pulls, Out lead, Out turned) {
#pragma GCC ivdep
  for (std::size_t i = 0; i < n; ++i) {
    const double next = half_square * next_gain[i] * change[i + 1];
    const double last = half_square * last_gain[i] * change[i - 1];
    const double own = half_square * own_gain[i] * change[i];
    double length = 0, along = 0, square = 0;
    for (std::size_t c = 0; c < kComponents; ++c) {
      const std::size_t at = c * n + i;
      const double d = next * chord[at + 1] + last * chord[at - 1] - own * chord[at];
      const double f = lead[at] + d;
      lead[at] = f;
      turned[at] = d;
      length += f * f;
      along += f * d;
      square += d * d;
    }
    const double known = length > 0 ? length : 1;  // behind the last link is nothing
    const double scale = 1 / std::sqrt(known), radial = along / known;
    for (std::size_t c = 0; c < kComponents; ++c) {
      const std::size_t at = c * n + i;
      turned[at] -= radial * lead[at];
      lead[at] *= scale;
    }
    squares[i] = square;
    x[i] += change[i];
    pulls[i] = x[i] > 0 ? x[i] : 0;  // only what pulls makes waves
  }
  return {largest(n, squares), 2 * largest(n, pulls, own_gain)};
}

}  // namespace

void Links::lead(double h, double last, const double* before, const double* q, double* out) const {
  drift(stride_, h / last, h * (h + last) / 2, next_gain_, last_gain_, own_gain_, unknown_,
        before + kPad, q + kPad, out + kPad);
}

double Links::mend(double half_square, const double* q, double* lead, double* chord,
                   double* turned) {
  chords(stride_, 1 / half_square, weight_, q + kPad, lead + kPad, chord + kPad, diagonal_, right_);
  neighbours(stride_, beside_, chord + kPad, off_);
  solve_tridiagonal(count_, diagonal_, off_, right_, change_, work_);
  const Largest most = turn(stride_, half_square, next_gain_, last_gain_, own_gain_, chord + kPad,
                            unknown_, change_, off_, right_, lead + kPad, turned + kPad);
  fastest_squared_ = most.wave;
  return std::sqrt(most.change);
}

}  // namespace taut::direct
