// The elements of materials (bend, twist, stretched link, link in moving air): energies, forces and
// their derivatives.
#pragma once

#include <cstdint>

#include "sim/motion/types.h"

namespace taut::material {

/// The bend between two edges (m) in a row, in the discrete curvature of Bergou and others,
/// Discrete elastic rods, SIGGRAPH 2008: with t0, t1 the edges' directions and a the angle between
/// them, C = 2 tan(a/2) and the energy is stiffness C^2 / 2. `stiffness` (N m) is EI over the
/// length of rope that bends there. Where it is bent at rest, by `rest` as a vector along t0 x t1,
/// the energy is stiffness |C - rest|^2 / 2, C a vector as well.
class Bend {
 public:
  Bend(const Vec3& e0, const Vec3& e1, const Vec3& rest = Vec3::Zero());

  double energy(double stiffness) const;  // J
  /// The derivatives of that energy by the two edges, N.
  void slope(double stiffness, Vec3& by_e0, Vec3& by_e1) const;
  /// The derivatives by the edges' rates (m/s) of half the power of damping, damping |C'|^2 / 2, C
  /// as a vector along t1 - t0 and its rate past a frame that turns with t0 + t1 but not about it.
  /// `damping` in N m s.
  void resistance(double damping, const Vec3& e0_rate, const Vec3& e1_rate, Vec3& by_e0,
                  Vec3& by_e1) const;
  /// The second derivatives of the energy.
  struct Stiffness {
    Mat3 e0_e0, e0_e1, e1_e1;  // N/m
  };
  Stiffness stiffness(double stiffness) const;
  /// The second derivatives of that half power by the edges' rates, N s/m.
  Stiffness damping(double damping) const;

 private:
  void add_rest(double stiffness, Stiffness& found) const;
  /// The derivatives of that rate by the edges' rates.
  void rate_slope(Mat3& by_e0, Mat3& by_e1) const;
  Vec3 turn0() const;  // t1 - c t0, c the cosine of a
  Vec3 turn1() const;  // t0 - c t1
  /// rest . C, and its derivatives by t0 and t1 as if these were any vectors.
  struct Along {
    double value = 0;
    Vec3 by_t0, by_t1;
  };
  Along along_rest() const;

  double inverse0_, inverse1_;  // 1/m
  Vec3 t0_, t1_;
  double straight_;  // |t0 + t1|^2 / 4, the square of cos(a/2)
  Vec3 apart_;       // t1 - t0
  double cosine_;
  Vec3 rest_;
  bool curved_;
};

/// Drag on a link along `edge` that moves past the air at `speed` (m/s):
///   -1/2 density length diameter (across |v_n| v_n + along |v_t| v_t), N,
/// v_n the speed across the edge and v_t along it; `density_area` (kg/m) is the first three factors
/// without the half.
Vec3 drag_force(const Vec3& edge, const Vec3& speed, double density_area, double across,
                double along);
/// The negative derivative of drag_force() by the speed, N s/m.
Mat3 drag_slope(const Vec3& edge, const Vec3& speed, double density_area, double across,
                double along);

/// A connector that is clamped at both ends, or a closed loop, and resists twist. Waves of twist
/// run away from what moves the rod so fast that the moment is the same everywhere (Bergou and
/// others, Discrete elastic rods, SIGGRAPH 2008, section 7.2): only the twist of the whole counts,
/// and its energy is stiffness twist^2 / 2.
struct TwistElement {
  std::uint32_t connector = 0, first = 0, links = 0;  // `first`: its first particle's point
  bool closed = false;                                // a loop, without clamps
  std::uint32_t from = 0, to = 0;                     // indices of the clamps
  double stiffness = 0;                               // N m: one over the sum of length / GJ
  double damping = 0;                                 // N m s
  double rest = 0;                                    // rad
  double most = 0;                                    // rad: how far its ends are turned at most
  double start = 0;  // rad: how far they were, carried along, where it was not twisted
  double since = 0;  // rad: what has come to that by the last state that was followed
};

/// By what a frame turns about its direction that is carried from an edge (m) to the next, as these
/// change: how much of the twist between two frames is less. The angle itself depends on what it is
/// measured from, its derivatives do not.
class Carry {
 public:
  Carry(const Vec3& e0, const Vec3& e1);

  /// t0 x t1 / (1 + t0 . t1), t0 and t1 the directions: divided by the length of an edge, the
  /// derivative of the twist by that edge, rad/m.
  const Vec3& slope() const { return slope_; }
  /// The second derivatives of the twist, rad/m^2, those by one edge less an antisymmetric part: it
  /// cancels against that of the carry on the edge's other side.
  Bend::Stiffness second() const;

 private:
  double inverse0_, inverse1_;  // 1/m
  Vec3 t0_, t1_;
  double share_;  // 1 / (1 + t0 . t1)
  Vec3 slope_;
};

}  // namespace taut::material
