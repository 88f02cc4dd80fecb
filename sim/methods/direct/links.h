// The links of a system as plain arrays, and the loops over all of them.
#pragma once

#include <cmath>
#include <cstddef>
#include <span>

#include "sim/methods/direct/vector.h"

namespace taut::direct {

/// Links in a row, with the inverse masses that couple them; the arrays of many spans lie one
/// behind the other. A state array holds one number per link and component, first all x, then all
/// y (then all z); each component takes stride() doubles and kPad zeros stand before the first and
/// behind the last, so that loops may run over whole vectors and look at their neighbours.
class Links {
 public:
  static constexpr std::size_t kPad = 4;

  struct Link {
    double rest = 0;  // m
    // 1/kg, the inverse masses of its two particles, held ones zero.
    double near = 0, far = 0;
    bool shares = false;  // the latter with the next link
    double end = 0;       // 1/kg, roughly what bodies at its ends add to these
  };
  Links() = default;
  Links(const Links&) = delete;
  Links& operator=(const Links&) = delete;

  /// Room for so many links.
  void reserve(std::size_t links);
  void rebuild(std::span<const Link> links, int components);

  std::size_t count() const { return count_; }
  std::size_t stride() const { return stride_; }
  int components() const { return components_; }
  /// Where component c begins in a state array.
  std::size_t begin(int c) const { return kPad + static_cast<std::size_t>(c) * stride_; }
  /// Where the last component ends.
  std::size_t end() const { return begin(components_); }
  double rest(std::size_t link) const { return rest_[link]; }
  double inverse_rest(std::size_t link) const { return inverse_rest_[link]; }

  /// Sets up the system for the tensions that keep u.u'' = -|u'|^2 with nothing but the links.
  void assemble(const double* q, const double* rate);
  /// Adds to the right side of a row.
  void add_right(std::size_t link, double value) { right_[link] += value * scale_[link]; }
  /// How easily (1/kg) a body moves that holds the first, or else the last, particle of a span, the
  /// near one of `link` or its far one. assemble() forgets it.
  void set_end(std::size_t link, bool first, double value);
  /// Solves it; the functions below use the tensions that it leaves.
  void solve();
  /// N, positive where the link pulls.
  double tension(std::size_t link) const { return scale_[link] * unknown_[link]; }
  /// What a right side of 1 in `link` alone would give, in an array of count(); its tensions are
  /// scale() times that. Spoils the right side.
  void respond(std::size_t link, double* response);
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
  /// turned by a right angle or more from its base.
  bool retract(const double* base, double* x, double* rate) const;
  /// Leaves of x what lies across `base`.
  void to_tangent(const double* base, double* x) const;

 private:
  std::size_t count_ = 0, stride_ = 0;
  int components_ = 3;
  double wave_squared_ = 0;  // rad^2/s^2, under the last tensions
  // One block, so that no two arrays lie a multiple of a page apart, where stores would hold up
  // loads. Rows and columns of the system are scaled to a diagonal of 2, near which neither its
  // minors nor their inverses overflow.
  Array arena_;
  double *rest_, *inverse_rest_, *both_, *shared_, *scale_;
  double *beside_, *weight_, *next_gain_, *last_gain_, *own_gain_;  // scaled constants of the loops
  // The system, see solve_chain(). Links of different spans are no neighbours: as if at right
  // angles, where `apart_` is what that makes of turned_.
  double *near_, *far_, *apart_, *off_, *turned_, *right_, *unknown_;  // unknowns: T / scale
  double *factored_pivot_, *factored_up_, *factored_down_;
  double* work_;  // three arrays
};

}  // namespace taut::direct
