// The links of a system as plain arrays, and the loops over all of them.
#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

#include "sim/methods/direct/system/vector.h"
#include "sim/motion/plane.h"

namespace taut::direct {

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
