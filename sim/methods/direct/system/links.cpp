#include "sim/methods/direct/system/links.h"

#include <algorithm>
#include <cmath>

#include "sim/links/link_loops.h"

namespace taut::direct {
namespace {

// Divisions that keep the minors of factor_twisted() in range are done so often.
constexpr std::size_t kRows = kRowsPerScaling<double>;

}  // namespace

TAUT_VECTOR_CLONES
void solve_chain(std::size_t n, const double* diagonal_first, const double* diagonal_second,
                 const double* e, const double* sine_squared, const double* r, double* x,
                 double* scratch) {
  solve_chain_loop(n, diagonal_first, diagonal_second, e, sine_squared, r, x, scratch);
}

/// Of the matrix scaled to a diagonal of 1, whose leading minors are Q_i, the pivots are Q_i /
/// Q_{i-1}.
TAUT_VECTOR_CLONES
void factor_twisted(std::size_t n, double* __restrict pivot, double* __restrict up,
                    double* __restrict down, double* __restrict scratch) {
  if (n == 0) return;
  const std::size_t m = n / 2;
  double* __restrict couple = scratch;  // what row i and the next take from each other
  double* __restrict before = scratch + n;
  double* __restrict now = scratch + 2 * n;
  for (std::size_t i = 0; i < n; ++i) pivot[i] = 1 / pivot[i];
  for (std::size_t i = 0; i + 1 < n; ++i) couple[i] = up[i] * down[i] * (pivot[i] * pivot[i + 1]);
  before[m] = 1;
  before[0] = before[n - 1] = now[0] = now[n - 1] = 1;
  double d0 = 1, d1 = 1, u0 = 1, u1 = 1;  // the last two minors, going down and going up
  for (std::size_t k = 1; k < m; ++k) {
    const std::size_t i = k, j = n - 1 - k;
    const double d2 = d1 - couple[i - 1] * d0, u2 = u1 - couple[j] * u0;
    before[i] = d0 = d1, now[i] = d1 = d2;
    if (j > m) before[j] = u0 = u1, now[j] = u1 = u2;
    if (k % kRows == 0) d0 /= d1, u0 /= u1, d1 = u1 = 1;
  }
  now[m] = 1;
  if (m > 0) now[m] -= couple[m - 1] * before[m - 1] / now[m - 1];
  if (m + 1 < n) now[m] -= couple[m] * before[m + 1] / now[m + 1];
  for (std::size_t i = 0; i < n; ++i) pivot[i] *= before[i] / now[i];
  for (std::size_t i = 0; i + 1 < n; ++i) {
    down[i] *= i < m ? pivot[i] : pivot[i + 1];
    up[i] *= i < m ? pivot[i] : pivot[i + 1];
  }
}

namespace {

template <int kColumns>
[[gnu::always_inline]] inline void solve_columns(std::size_t n, const double* __restrict pivot,
                                                 const double* __restrict up,
                                                 const double* __restrict down, std::size_t stride,
                                                 double* __restrict x) {
  const std::size_t m = n / 2;
  double above[kColumns], below[kColumns];
  for (int c = 0; c < kColumns; ++c) above[c] = x[c * stride], below[c] = x[c * stride + n - 1];
  for (std::size_t k = 0; k < m; ++k) {
    const std::size_t i = k, j = n - 1 - k;
    for (int c = 0; c < kColumns; ++c) {
      double* __restrict r = x + c * stride;
      above[c] = r[i + 1] += down[i] * above[c];
      if (j > m) below[c] = r[j - 1] += up[j - 1] * below[c];
    }
  }
  for (int c = 0; c < kColumns; ++c) {
    double* __restrict r = x + c * stride;
    r[m] *= pivot[m];
    above[c] = below[c] = r[m];
  }
  for (std::size_t k = 1; k <= m; ++k) {
    for (int c = 0; c < kColumns; ++c) {
      double* __restrict r = x + c * stride;
      above[c] = r[m - k] = pivot[m - k] * r[m - k] + up[m - k] * above[c];
      if (m + k < n) below[c] = r[m + k] = pivot[m + k] * r[m + k] + down[m + k - 1] * below[c];
    }
  }
}

}  // namespace

TAUT_VECTOR_CLONES
void solve_twisted(std::size_t n, const double* pivot, const double* up, const double* down,
                   int columns, std::size_t stride, double* x) {
  if (n == 0) return;
  if (columns == 1) {
    solve_columns<1>(n, pivot, up, down, stride, x);
  } else if (columns == 2) {
    solve_columns<2>(n, pivot, up, down, stride, x);
  } else {
    solve_columns<3>(n, pivot, up, down, stride, x);
  }
}

namespace {

constexpr std::size_t kArrays = 26;

using Out = double* __restrict;
using In = const double* __restrict;

// In space coordinates are directions.

TAUT_VECTOR_CLONES
void assemble_directions(std::size_t n, In q, In rate, In coupling, In weight, Out off_diagonal,
                         Out sine_squared, Out right) {
  assemble_loop<3>(n, q, rate, coupling, weight, off_diagonal, sine_squared, right);
}
/// Returns the largest of own * |x|.
TAUT_VECTOR_CLONES
double pull_directions(std::size_t n, In q, In next, In last, In own, In x, Out out) {
  pull_loop<3>(n, q, next, last, own, x, out);
  return largest(n, x, own);
}
TAUT_VECTOR_CLONES
void normalise_directions(std::size_t count, std::size_t n, Out q, Out rate) {
  normalise_loop<3>(count, n, q, rate);
}
TAUT_VECTOR_CLONES
bool retract_directions(std::size_t n, In base, Out x, Out rate) {
  return retract_loop<3>(n, base, x, rate) == 0;
}
TAUT_VECTOR_CLONES
void to_tangent_of_directions(std::size_t n, In base, Out x) {
  to_tangent_loop<3>(n, base, x);
}

// In a plane they are angles, of which only the differences matter to the links.

TAUT_VECTOR_CLONES
void assemble_angles(std::size_t n, In angle, In rate, In coupling, In weight, Out cosine, Out sine,
                     Out off_diagonal, Out sine_squared, Out right) {
  for (std::size_t i = 0; i < n; ++i) {
    const SinCos turn = sine_and_cosine(angle[i + 1] - angle[i]);
    cosine[i] = turn.cosine;
    sine[i] = turn.sine;
    off_diagonal[i] = coupling[i] * turn.cosine;
    const double across = coupling[i] * turn.sine;
    sine_squared[i] = across * across;
    right[i] = weight[i] * (rate[i] * rate[i]);
  }
}
TAUT_VECTOR_CLONES
double pull_angles(std::size_t n, In sine, In next, In last, In own, In x, Out out) {
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = next[i] * x[i + 1] * sine[i] - last[i] * x[i - 1] * sine[i - 1];
  }
  return largest(n, x, own);
}
/// False where an angle has changed by half a turn.
TAUT_VECTOR_CLONES
bool retract_angles(std::size_t n, In base, Out x) {
  constexpr double kHalfTurn = 3.141592653589793;
  std::size_t outside = 0;
  for (std::size_t i = 0; i < n; ++i) {
    outside |= std::abs(x[i]) < kHalfTurn ? 0 : 1;
    x[i] += base[i];
  }
  return outside == 0;
}
TAUT_VECTOR_CLONES
void place_angles(std::size_t n, In angle, Out cosine, Out sine) {
  for (std::size_t i = 0; i < n; ++i) {
    const SinCos place = sine_and_cosine(angle[i]);
    cosine[i] = place.cosine;
    sine[i] = place.sine;
  }
}

template <int kComponents>
double sum_of_squares(std::size_t count, std::size_t stride, In rest, In change) {
  double place[kComponents] = {}, squares[kComponents] = {};
  for (std::size_t i = 0; i < count; ++i) {
    for (int c = 0; c < kComponents; ++c) {
      place[c] += rest[i] * change[static_cast<std::size_t>(c) * stride + i];
      squares[c] += place[c] * place[c];
    }
  }
  double sum = 0;
  for (const double square : squares) sum += square;
  return sum;
}

}  // namespace

void Links::reserve(std::size_t links) {
  arena_.reserve(kPad + kArrays * (links + kLanes + 2 * kPad));
}

void Links::rebuild(std::span<const Link> links, const std::optional<Plane>& plane) {
  count_ = links.size();
  stride_ = (links.size() + kLanes - 1) / kLanes * kLanes;
  plane_ = plane;
  components_ = plane ? 1 : 3;
  arena_.assign(kPad + kArrays * (stride_ + 2 * kPad), 0.0);
  double** const arrays[] = {&rest_,
                             &inverse_rest_,
                             &inverse_mass_sum_,
                             &inverse_mass_shared_,
                             &scale_,
                             &coupling_,
                             &weight_,
                             &next_gain_,
                             &last_gain_,
                             &own_gain_,
                             &diagonal_first_,
                             &diagonal_second_,
                             &sine_squared_,
                             &off_diagonal_,
                             &right_,
                             &unknown_,
                             &factored_pivot_,
                             &factored_up_,
                             &factored_down_,
                             &cosine_,
                             &sine_,
                             &place_cosine_,
                             &place_sine_,
                             &scratch_};
  static_assert(std::size(arrays) + 2 == kArrays);  // scratch_ is three
  for (std::size_t k = 0; k < std::size(arrays); ++k) {
    *arrays[k] = arena_.data() + kPad + k * (stride_ + 2 * kPad);
  }
  for (std::size_t i = 0; i < count_; ++i) {
    const Link& link = links[i];
    rest_[i] = link.rest;
    inverse_rest_[i] = link.rest > 0 ? 1 / link.rest : 0;
    inverse_mass_sum_[i] = link.inverse_mass_first + link.inverse_mass_second;
    inverse_mass_shared_[i] = link.shares_second ? link.inverse_mass_second : 0;
    const double sum = inverse_mass_sum_[i] + link.end;
    scale_[i] = sum > 0 ? std::sqrt(2 / sum) : 1;
    weight_[i] = rest_[i] * scale_[i];
    own_gain_[i] = inverse_mass_sum_[i] * scale_[i] * inverse_rest_[i];
    diagonal_first_[i] = link.inverse_mass_first * scale_[i] * scale_[i];
    diagonal_second_[i] = link.inverse_mass_second * scale_[i] * scale_[i];
  }
  for (std::size_t i = 0; i + 1 < count_; ++i) {
    coupling_[i] = inverse_mass_shared_[i] * scale_[i] * scale_[i + 1];
    next_gain_[i] = inverse_mass_shared_[i] * scale_[i + 1] * inverse_rest_[i];
    last_gain_[i + 1] = inverse_mass_shared_[i] * scale_[i] * inverse_rest_[i + 1];
  }
}

void Links::point(std::size_t link, const Vec3& u, const Vec3& turn, double* q,
                  double* rate) const {
  if (plane_) {
    q[begin(0) + link] = std::atan2(u.dot(plane_->y), u.dot(plane_->x));
    rate[begin(0) + link] = turn.dot(plane_->normal.cross(u));
    return;
  }
  add(link, u, u, q);
  add(link, u, turn, rate);
}

void Links::lay(const double* q, const double* rate, std::size_t first, std::size_t count,
                Point point, Point* out) {
  const double *x = q + begin(0), *v = rate + begin(0);
  if (!plane_) {
    for (std::size_t i = first; i < first + count; ++i) {
      point.position += rest_[i] * Vec3(x[i], x[i + stride_], x[i + 2 * stride_]);
      point.velocity += rest_[i] * Vec3(v[i], v[i + stride_], v[i + 2 * stride_]);
      *out++ = point;
    }
    return;
  }
  place_angles(stride_, x, place_cosine_, place_sine_);
  const Vec3 along = plane_->x, across = plane_->y;
  for (std::size_t i = first; i < first + count; ++i) {
    const double cosine = rest_[i] * place_cosine_[i], sine = rest_[i] * place_sine_[i];
    point.position += cosine * along + sine * across;
    point.velocity += v[i] * (cosine * across - sine * along);
    *out++ = point;
  }
}

double Links::displacement(const double* change, std::size_t first, std::size_t count) const {
  const auto sum = plane_ ? sum_of_squares<1> : sum_of_squares<3>;
  return sum(count, stride_, rest_ + first, change + begin(0) + first);
}

void Links::assemble(const double* q, const double* rate) {
  if (plane_) {  // from the pad on, which says how the first link stands
    assemble_angles(stride_ + kPad, q, rate, coupling_ - kPad, weight_ - kPad, cosine_ - kPad,
                    sine_ - kPad, off_diagonal_ - kPad, sine_squared_ - kPad, right_ - kPad);
  } else {
    assemble_directions(stride_, q + kPad, rate + kPad, coupling_, weight_, off_diagonal_,
                        sine_squared_, right_);
  }
}

void Links::set_end(std::size_t link, bool first, double value) {
  double* side = first ? diagonal_first_ : diagonal_second_;
  side[link] = value * scale_[link] * scale_[link];
  // Links of different spans are solved as if they stood at right angles.
  const auto turn = [&](std::size_t k) {
    sine_squared_[k] = diagonal_second_[k] * diagonal_first_[k + 1];
  };
  if (first && link > 0) turn(link - 1);
  if (!first && link + 1 < count_) turn(link);
}

void Links::solve() {
  solve_chain(count_, diagonal_first_, diagonal_second_, off_diagonal_, sine_squared_, right_,
              unknown_, scratch_);
}

void Links::clear_right() {
  std::fill(right_, right_ + count_, 0.0);
}

void Links::respond(double* response) {
  solve_chain(count_, diagonal_first_, diagonal_second_, off_diagonal_, sine_squared_, right_,
              response, scratch_);
}

void Links::add_response(const double* response, double factor) {
  for (std::size_t i = 0; i < count_; ++i) unknown_[i] += factor * response[i];
}

void Links::pull(const double* q, double* out) {
  wave_squared_ = 2 * (plane_ ? pull_angles(stride_, sine_, next_gain_, last_gain_, own_gain_,
                                            unknown_, out + kPad)
                              : pull_directions(stride_, q + kPad, next_gain_, last_gain_,
                                                own_gain_, unknown_, out + kPad));
}

void Links::factor(double sigma_squared) {
  for (std::size_t i = 0; i < count_; ++i) {
    const double pull = std::max(tension(i), 0.0);
    factored_pivot_[i] =
        sigma_squared * (rest_[i] > 0 ? rest_[i] : 1) + inverse_mass_sum_[i] * pull;
    const auto coupling = [&](std::size_t k) {  // across the other link, in a plane
      return inverse_mass_shared_[k] * (plane_ ? std::max(cosine_[k], 0.0) : 1) * pull;
    };
    factored_down_[i] = coupling(i);
    if (i > 0) factored_up_[i - 1] = coupling(i - 1);
  }
  factor_twisted(count_, factored_pivot_, factored_up_, factored_down_, scratch_);
}

void Links::solve_factored(double* x) const {
  for (int c = 0; c < components_; ++c) {
    double* __restrict column = x + begin(c);
    for (std::size_t i = 0; i < count_; ++i) column[i] *= rest_[i];
  }
  solve_twisted(count_, factored_pivot_, factored_up_, factored_down_, components_, stride_,
                x + kPad);
}

void Links::normalise(double* q, double* rate) const {
  if (!plane_) normalise_directions(count_, stride_, q + kPad, rate + kPad);
}

bool Links::retract(const double* base, double* x, double* rate) const {
  if (plane_) return retract_angles(stride_, base + kPad, x + kPad);
  return retract_directions(stride_, base + kPad, x + kPad, rate + kPad);
}

void Links::to_tangent(const double* base, double* x) const {
  if (!plane_) to_tangent_of_directions(stride_, base + kPad, x + kPad);
}

}  // namespace taut::direct
