// One span in a plane that hangs from a hold: what most scenes move as, and the cheapest to step.
#pragma once

#include <optional>

#include "sim/methods/direct/motion.h"
#include "sim/motion/plane.h"
#include "sim/world/components.h"

namespace taut::direct {

/// The cosines and sines of n angles.
void directions(std::size_t n, const double* angle, double* cosine, double* sine);

/// A chain of links whose first end is prescribed and whose last is free, bears a point mass, or is
/// a body that hangs by one point and so is one more link (see Stick). Coordinates: the angles p_k
/// of the links, k from 1, against the plane's x axis, p_0 = 0. With link k between the points k-1
/// and k, w_k the inverse mass of point k (w_0 = 0), c_k and s_k the cosine and sine of
/// p_{k+1} - p_k, and f gravity less the first point's acceleration, the equations of System become
///
///   (w_{k-1} + w_k) T_k - w_k c_k T_{k+1} - w_{k-1} c_{k-1} T_{k-1} = l_k p_k'^2  [+ u_1 . f]
///   l_k p_k'' = w_k s_k T_{k+1} - w_{k-1} s_{k-1} T_{k-1}  [+ n_1 . f]
///
/// with the terms in brackets for k = 1, u_1 = (c_0, s_0) and n_1 across it. Only the differences
/// of the angles are needed, and there is no length or direction to restore after a step.
class PlanarChain : public Motion {
 public:
  /// True where a component that moves in a plane is such a chain.
  static bool fits(const World& world, const Component& component);
  /// Room for so many links.
  void reserve(std::size_t links);
  void rebuild(const World& world, const Component& component, const Plane& plane);

  void load(const World& world, double time, double* q, double* rate) override;
  void store(World& world, const double* q, const double* rate) override;
  void attach(const World& world) override { world_ = &world; }
  const std::optional<Vec3>& left_plane() const override { return left_plane_; }
  double length() const override { return length_; }
  double shortest() const override { return shortest_; }
  double wave_frequency() const override { return std::sqrt(wave_squared_); }

  std::size_t size() const override { return loop_ + kLanes; }
  void acceleration(double time, const double* q, const double* rate, double* out) override;
  void project(double, double*, double*) override {}
  double projection_cost() const override { return 0; }
  double work() const override;
  double displacement(const double* change) const override;
  double displacement_bound(double squares) const override { return reach_ * std::sqrt(squares); }
  double velocity_time() const override { return velocity_time_; }
  bool retract(const double* base, double* x, double* rate) const override;
  void to_tangent(const double*, double*) const override {}
  void factor(double sigma_squared) override;
  void solve_factored(double* x) const override;
  void solve_factored(double* x, double* y) const override;

 private:
  void measure(const World& world);
  void set_pull(double time);
  std::size_t particle(std::size_t k) const {
    return reversed_ ? range_.last - k : range_.first + k;
  }

  const World* world_ = nullptr;
  Plane plane_;
  std::optional<Vec3> left_plane_;
  SpanRange range_;
  bool reversed_ = false;  // from range.last to range.first
  Attachment hold_;
  Vec3 gravity_;
  std::optional<std::size_t> bar_;    // the body that is the last link
  double arm_ = 0;                    // m, of its centre of mass
  double bar_angle_ = 0;              // of its link, when loaded
  Quat rotation_ = Quat::Identity();  // its own, when loaded
  std::size_t links_ = 0, loop_ = 0;  // loops run over loop_ slots, a multiple of kLanes
  double length_ = 0, shortest_ = 0;  // m, of all links, of the shortest
  double velocity_time_ = 0;          // s
  double reach_ = 0;                  // m, of displacement_bound()
  Vec3 pull_ = Vec3::Zero();          // m/s^2, f at the last instant
  double wave_squared_ = 0;           // rad^2/s^2, at the last instant

  // Slot k belongs to link k, slot 0 to the axis; one block, as in Links. Rows and columns of the
  // system are scaled to a diagonal of 2.
  Array arena_;
  double *rest_, *scale_;                               // per link
  double *beside_, *weight_, *next_gain_, *last_gain_;  // scaled constants of the loops
  double* wave_gain_;                                   // 1/s^2 per unknown, see wave_frequency()
  double *near_, *far_, *turned_;                      // of the rows and columns, see solve_chain()
  double *cosine_, *sine_, *off_, *right_, *unknown_;  // unknowns: T / scale
  double *factored_pivot_, *factored_up_, *factored_down_;
  double *place_cosine_, *place_sine_;  // of the links themselves
  double *mass_, *inverse_;             // of the points
  double* work_;                        // three arrays
};

}  // namespace taut::direct
