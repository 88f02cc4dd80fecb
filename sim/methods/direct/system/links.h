// The links of a system as plain arrays, and the loops over all of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <new>
#include <optional>
#include <span>
#include <vector>

#include "sim/motion/plane.h"

// Vector code for more than one kind of processor.

// Compiles a function twice, for any x86-64 and for those with AVX2 and FMA, and chooses when the
// program starts. Only plain loops profit: functions they call must be inlined.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define TAUT_VECTOR_CLONES __attribute__((target_clones("arch=x86-64-v3", "default")))
#else
#define TAUT_VECTOR_CLONES
#endif

namespace taut::direct {

/// Numbers in the widest vector that loops are written for.
inline constexpr std::size_t kLanes = 4;

/// As many numbers at once, wherever they begin.
using Vector [[gnu::vector_size(kLanes * sizeof(double)), gnu::aligned(8), gnu::may_alias]] =
    double;

/// The largest |x| of n numbers, a multiple of kLanes, each times its scale; NaN does not count. By
/// hand, since without -ffast-math compilers keep to the order.
template <typename... Scale>
[[gnu::always_inline]] inline double largest(std::size_t n, const double* x,
                                             const Scale*... scale) {
  const auto at = [](const double* array, std::size_t i) -> const Vector& {
    return *reinterpret_cast<const Vector*>(array + i);
  };
  Vector most{};
  for (std::size_t i = 0; i < n; i += kLanes) {
    const Vector size = ((at(x, i) < 0 ? -at(x, i) : at(x, i)) * ... * at(scale, i));
    most = size > most ? size : most;
  }
  return std::max(std::max(most[0], most[1]), std::max(most[2], most[3]));
}

/// Begins a cache line, so that no vector lies across two.
template <typename T>
struct LineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kLine{64};

  LineAllocator() = default;
  template <typename U>
  LineAllocator(const LineAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kLine)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kLine); }
  bool operator==(const LineAllocator&) const = default;
};

using Array = std::vector<double, LineAllocator<double>>;

// Sines and cosines in loops that the compiler can turn into vector code.

struct SinCos {
  double sine, cosine;
};

/// Both to some 2e-16, for |angle| up to 1e6 or so. With r the angle less the nearest multiple of
/// pi, |r/2| <= pi/4, sine and cosine of r/2 follow from Taylor's series, and of r from those.
[[gnu::always_inline]] inline SinCos sine_and_cosine(double angle) {
  // Adding and subtracting 1.5 * 2^52 rounds to a whole number.
  constexpr double kRound = 6755399441055744.0;
  constexpr double kInversePi = 0.3183098861837907;
  constexpr double kPi = 3.141592653589793, kPiRest = 1.2246467991473532e-16;
  const double turns = (angle * kInversePi + kRound) - kRound;
  const double pairs = (0.5 * turns + kRound) - kRound;
  const double odd = turns - 2 * pairs;  // -1, 0 or 1
  const double sign = 1 - 2 * odd * odd;
  const double x = 0.5 * ((angle - turns * kPi) - turns * kPiRest), y = x * x;
  constexpr double s3 = -1.0 / 6, s5 = 1.0 / 120, s7 = -1.0 / 5040, s9 = 1.0 / 362880;
  constexpr double s11 = -1.0 / 39916800, s13 = 1.0 / 6227020800, s15 = -1.0 / 1307674368000;
  constexpr double c4 = 1.0 / 24, c6 = -1.0 / 720, c8 = 1.0 / 40320, c10 = -1.0 / 3628800;
  constexpr double c12 = 1.0 / 479001600, c14 = -1.0 / 87178291200;
  constexpr double c16 = 1.0 / 20922789888000;
  const double s =
      x + x * y * (s3 + y * (s5 + y * (s7 + y * (s9 + y * (s11 + y * (s13 + y * s15))))));
  const double c =
      1 + y * (-0.5 + y * (c4 + y * (c6 + y * (c8 + y * (c10 + y * (c12 + y * (c14 + y * c16)))))));
  return {2 * sign * s * c, sign * (1 - 2 * s * s)};
}

// Symmetric tridiagonal systems, solved from both ends at once.

/// Solves A x = r for a chain of n links whose first or last point is free: the diagonal of A is
/// `diagonal_first` + `diagonal_second`, from the particles that a link shares with the row before
/// and with the next; beside it stands -`off_diagonal` (n-1), with entries sqrt(b_i a_{i+1}) times
/// the cosine of a turn, a and b the two parts of the diagonal; `sine_squared` (n-1) is the square
/// of the same times its sine. `scratch` takes 3n doubles.
///
/// Elimination without divisions: with the leading minors q_i = d_i q_{i-1} - e_i^2 q_{i-2} and
/// z_i = r_i q_{i-1} + e_i z_{i-1}, the rows read x_i = (z_i + e_{i+1} q_{i-1} x_{i+1}) / q_i, and
/// all divisions are done together. The same from the last row backwards; the halves meet in the
/// middle, which halves the chain of operations that wait for each other.
///
/// With q_i = b_i q_{i-1} + g_i the minors are sums, g_i = a_i g_{i-1} + sine_squared_{i-1}
/// q_{i-2}, and every digit of nearly singular systems counts, such as those of straight chains
/// between a hold and a load a million times as heavy as they. Where a system leaves the tensions
/// open, the middle one is zero.
void solve_chain(std::size_t n, const double* diagonal_first, const double* diagonal_second,
                 const double* off_diagonal, const double* sine_squared, const double* right,
                 double* x, double* scratch);

/// A tridiagonal matrix whose columns are diagonally dominant, factored from both ends: `pivot`
/// (n) holds its diagonal and becomes inverse pivots; `up` (entry above the diagonal in row i, at
/// i) and `down` (entry below it in column i, at i) hold -its off-diagonals and become multipliers.
/// `scratch` takes 3n doubles. No division waits for another, as above.
void factor_twisted(std::size_t n, double* pivot, double* up, double* down, double* scratch);

/// Solves for `columns` right sides in place, `stride` apart, with what factor_twisted() left.
void solve_twisted(std::size_t n, const double* pivot, const double* up, const double* down,
                   int columns, std::size_t stride, double* x);

/// Where a point is, and how it moves.
struct Point {
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();
};

/// Links in a row, with the inverse masses that couple them; the arrays of many spans lie one
/// behind the other. In space a state array holds the unit directions of all links, first all x,
/// then all y, then all z; in a plane the angles of all links against the plane's x axis. Each
/// component takes stride() doubles, and kPad zeros stand before the first and behind the last, so
/// that loops may run over whole vectors and look at their neighbours.
class Links {
 public:
  static constexpr std::size_t kPad = 4;

  struct Link {
    double rest = 0;  // m
    // 1/kg, of its two particles, held ones zero.
    double inverse_mass_first = 0, inverse_mass_second = 0;
    bool shares_second = false;  // its second particle with the next link
    double end = 0;              // 1/kg, roughly what bodies at its ends add to these
  };
  Links() = default;
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  /// Room for so many links.
  void reserve(std::size_t links);
  void rebuild(std::span<const Link> links, const std::optional<Plane>& plane);

  std::size_t count() const { return count_; }
  std::size_t stride() const { return stride_; }
  /// Where component c begins in a state array.
  std::size_t begin(int c) const { return kPad + static_cast<std::size_t>(c) * stride_; }
  /// Where the last component ends.
  std::size_t end() const { return begin(components_); }
  double rest(std::size_t link) const { return rest_[link]; }
  double inverse_rest(std::size_t link) const { return inverse_rest_[link]; }

  /// Sets a link's direction and the rate of that, which are across each other.
  void point(std::size_t link, const Vec3& u, const Vec3& turn, double* q, double* rate) const;
  Vec3 direction(const double* q, std::size_t link) const {
    const double* x = q + begin(0) + link;
    if (!plane_) return {x[0], x[stride_], x[2 * stride_]};
    const SinCos place = sine_and_cosine(*x);
    return place.cosine * plane_->x + place.sine * plane_->y;
  }
  /// The rate of the direction, 1/s.
  Vec3 turn(const double* q, const double* rate, std::size_t link) const {
    const double* x = rate + begin(0) + link;
    if (!plane_) return {x[0], x[stride_], x[2 * stride_]};
    return *x * plane_->normal.cross(direction(q, link));
  }
  /// Adds a change of the direction u, or of its derivatives, to an array of such.
  void add(std::size_t link, const Vec3& u, const Vec3& change, double* array) const {
    double* x = array + begin(0) + link;
    if (plane_) {
      *x += change.dot(plane_->normal.cross(u));
    } else {
      x[0] += change.x(), x[stride_] += change.y(), x[2 * stride_] += change.z();
    }
  }
  /// Writes the points behind `start`, one after each of `count` links from `first` on.
  void lay(const double* q, const double* rate, std::size_t first, std::size_t count, Point start,
           Point* out);
  /// The sum of the squares of how far `change` of the directions displaces those points, m^2. In a
  /// plane as if the links were parallel.
  double displacement(const double* change, std::size_t first, std::size_t count) const;

  /// Sets up the system for the tensions that keep u.u'' = -|u'|^2 with nothing but the links.
  void assemble(const double* q, const double* rate);
  /// The direction of the first or last link of a span, after assemble(): in a plane, where there
  /// is one span, its turns against the axis stand before and behind the others.
  Vec3 end_direction(const double* q, std::size_t link) const {
    if (!plane_) return direction(q, link);
    if (link == 0) return cosine_[-1] * plane_->x + sine_[-1] * plane_->y;
    return cosine_[link] * plane_->x - sine_[link] * plane_->y;
  }
  /// Adds to the right side of a row.
  void add_right(std::size_t link, double value) { right_[link] += value * scale_[link]; }
  /// How easily (1/kg) a body moves that holds the first, or else the last, particle of a span, the
  /// first one of `link` or its second. assemble() forgets it.
  void set_end(std::size_t link, bool first, double value);
  /// Solves it; the functions below use the tensions that it leaves.
  void solve();
  /// N, positive where the link pulls.
  double tension(std::size_t link) const { return scale_[link] * unknown_[link]; }
  /// The solution for the right sides that add_right() has added since clear_right(), in an array
  /// of count(); its tensions are scale() times that. Spoils the right side.
  void clear_right();
  void respond(double* response);
  void add_response(const double* response, double factor);
  double scale(std::size_t link) const { return scale_[link]; }
  /// u'' as far as the tensions cause it at particles that nothing holds.
  void pull(const double* q, double* out);

  /// A bound (Gershgorin's, for a row of equal links exact) of the frequencies of the waves under
  /// those tensions, rad/s.
  double wave_frequency() const { return std::sqrt(wave_squared_); }

  /// Factors sigma_squared - L, where L x is what pull() makes of x with the tensions of the last
  /// solve(), as far as they pull: the waves.
  void factor(double sigma_squared);
  void solve_factored(double* x) const;

  /// Unit directions, and rates across them.
  void normalise(double* q, double* rate) const;
  /// From coordinates across `base` to unit directions and their rates; false where a link is
  /// turned by a right angle or more from its base, in a plane by half a turn.
  bool retract(const double* base, double* x, double* rate) const;
  /// Leaves of x what lies across `base`.
  void to_tangent(const double* base, double* x) const;

 private:
  std::size_t count_ = 0, stride_ = 0;
  int components_ = 3;
  std::optional<Plane> plane_;
  double wave_squared_ = 0;  // rad^2/s^2, under the last tensions
  // A single block, so that no two arrays lie a multiple of a page apart, where stores would hold
  // up loads. Rows and columns of the system are scaled to a diagonal of 2, near which neither its
  // minors nor their inverses overflow.
  Array arena_;
  double *rest_, *inverse_rest_, *inverse_mass_sum_, *inverse_mass_shared_, *scale_;
  // Scaled constants of the loops.
  double *coupling_, *weight_, *next_gain_, *last_gain_, *own_gain_;
  // The system, see solve_chain(). Links of different spans are no neighbours.
  double *diagonal_first_, *diagonal_second_, *off_diagonal_, *sine_squared_, *right_;
  double* unknown_;  // T / scale
  double *factored_pivot_, *factored_up_, *factored_down_;
  double *cosine_, *sine_;              // in a plane: of a link's angle to the next
  double *place_cosine_, *place_sine_;  // in a plane: of the links' angles
  double* scratch_;                     // three arrays
};

}  // namespace taut::direct
