// A step of a chain in a plane by the places of its particles.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim/methods/direct/planar_chain.h"
#include "sim/methods/direct/sincos.h"
#include "sim/methods/direct/tridiagonal.h"
#include "sim/methods/direct/vector.h"

namespace taut::direct {
namespace {

using Out = double* __restrict;
using In = const double* __restrict;

/// The gains of a link's change by the tensions of itself and of those beside it.
struct Gains {
  const double *next, *last, *wave;  // wave is twice its own
};

/// Where links that turn on from b over u go under the tensions x, by one component. Second
/// differences over unequal steps are accelerations at the mean of their three times, where u has
/// turned on by a third of (ratio - 1).
TAUT_VECTOR_CLONES
void drift(std::size_t n, double ratio, double half_square, Gains gains, In x, In b, In u, Out e) {
  In next = gains.next, last = gains.last, wave = gains.wave;
  const double on = (2 + ratio) / 3, back = (ratio - 1) / 3;
  for (std::size_t k = 0; k < n; ++k) {
    const double after = half_square * next[k] * x[k + 1];
    const double before = half_square * last[k] * x[k - 1];
    const double own = half_square / 2 * wave[k] * x[k];
    e[k] = (1 + ratio - own * on) * u[k] - (ratio - own * back) * b[k] +
           after * (on * u[k + 1] - back * b[k + 1]) + before * (on * u[k - 1] - back * b[k - 1]);
  }
}

/// Half way from u to e, and by how much those are too long there.
TAUT_VECTOR_CLONES
void chords(std::size_t n, double per_half_square, In weight, In ux, In uy, In ex, In ey, Out mx,
            Out my, Out diagonal, Out right) {
  for (std::size_t k = 0; k < n; ++k) {
    mx[k] = (ux[k] + ex[k]) / 2;
    my[k] = (uy[k] + ey[k]) / 2;
    diagonal[k] = 2 * (mx[k] * mx[k] + my[k] * my[k]);
    right[k] = weight[k] * per_half_square / 2 * (ex[k] * ex[k] + ey[k] * ey[k] - 1);
  }
}

TAUT_VECTOR_CLONES
void neighbours(std::size_t n, In beside, In mx, In my, Out off) {
  for (std::size_t k = 0; k < n; ++k) {
    off[k] = beside[k] * (mx[k] * mx[k + 1] + my[k] * my[k + 1]);
  }
}

struct Largest {
  double change = 0, wave = 0;  // squares
};

/// Takes the changes of the tensions, which act along the chords; writes where the links turn to
/// and by how much of that the changes turned them. Links turn by a right angle at most.
TAUT_VECTOR_CLONES
Largest turn(std::size_t n, double half_square, Gains gains, In change, In mx, In my, In ux, In uy,
             Out ex, Out ey, In q, Out x, Out q_next, Out next_x, Out next_y, Out turned) {
  In next = gains.next, last = gains.last, wave = gains.wave;
  for (std::size_t k = 0; k < n; ++k) {
    const double after = half_square * next[k] * change[k + 1];
    const double before = half_square * last[k] * change[k - 1];
    const double own = half_square / 2 * wave[k] * change[k];
    const double dx = after * mx[k + 1] + before * mx[k - 1] - own * mx[k];
    const double dy = after * my[k + 1] + before * my[k - 1] - own * my[k];
    const double fx = ex[k] + dx, fy = ey[k] + dy;
    const double cross = ux[k] * fy - uy[k] * fx, dot = ux[k] * fx + uy[k] * fy;
    const double length = std::sqrt(cross * cross + dot * dot), per_length = 1 / length;
    next_x[k] = fx * per_length;
    next_y[k] = fy * per_length;
    q_next[k] = q[k] + two_arctangents(cross / (length + (dot > 0 ? dot : 0)));
    turned[k] = fx * dy - fy * dx;
    x[k] += change[k];
    ex[k] = dx * dx + dy * dy;
    ey[k] = x[k] > 0 ? x[k] : 0;  // only what pulls makes waves
  }
  return {largest(n, ex), largest(n, ey, wave)};
}

}  // namespace

double PlanarChain::fastest_hanging() const {
  double below = 0, most = 0;
  for (std::size_t k = links_; k > 0; --k) {
    below += mass_[k];
    most = std::max(most, wave_gain_[k] / scale_[k] * below);
  }
  return std::sqrt(most * gravity());
}

bool PlanarChain::pushes() const {
  return std::all_of(unknown_ + 1, unknown_ + links_ + 1,
                     [](double tension) { return tension < 0; });
}

/// With u the directions of the links and e where the tensions x lead them, each length holds if
/// (e' - u) . (e' + u) = 0 for the new e'. With the chord m = (e + u) / 2 for that mean, and the
/// changes of the tensions along the chords too, that is a system like that of the acceleration,
/// linear, symmetric and positive definite.
double PlanarChain::leap(double time, double h, double last, const double* q,
                         const double* q_before, double* q_next, double* turned) {
  set_pull(time);
  const double half_square = h * (h + last) / 2;
  const Gains gains{next_gain_, last_gain_, wave_gain_};
  const auto same = [&](const double* a, const double* b) {
    return std::memcmp(a, b, loop_ * sizeof(double)) == 0;
  };
  if (same(q, leapt_to_) && same(q_before, leapt_from_)) {
    std::swap(past_x_, now_x_), std::swap(now_x_, next_x_);
    std::swap(past_y_, now_y_), std::swap(now_y_, next_y_);
  } else {
    directions(loop_, q_before, past_x_, past_y_);
    directions(loop_, q, now_x_, now_y_);
  }
  drift(loop_, h / last, half_square, gains, unknown_, past_x_, now_x_, lead_x_);
  drift(loop_, h / last, half_square, gains, unknown_, past_y_, now_y_, lead_y_);
  lead_x_[1] += half_square * pull_.dot(plane_.x) / rest_[1];
  lead_y_[1] += half_square * pull_.dot(plane_.y) / rest_[1];
  chords(loop_, 1 / half_square, weight_, now_x_, now_y_, lead_x_, lead_y_, chord_x_, chord_y_,
         chord_diagonal_, right_);
  neighbours(loop_, beside_, chord_x_, chord_y_, off_);
  solve_tridiagonal(links_, chord_diagonal_ + 1, off_ + 1, right_ + 1, change_ + 1, work_);
  const Largest most = turn(loop_, half_square, gains, change_, chord_x_, chord_y_, now_x_, now_y_,
                            lead_x_, lead_y_, q, unknown_, q_next, next_x_, next_y_, turned);
  std::copy_n(q, loop_, leapt_from_);
  std::copy_n(q_next, loop_, leapt_to_);
  fastest_squared_ = most.wave;
  for (std::size_t k = loop_; k < size(); ++k) q_next[k] = turned[k] = 0;
  return std::sqrt(most.change);
}

}  // namespace taut::direct
