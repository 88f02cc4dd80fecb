// How a rigid body answers to what it touches: unilateral contact with Coulomb friction at several
// points of one body.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "sim/contact/capsule.h"
#include "sim/contact/touch.h"
#include "sim/world/body.h"

namespace taut::contact {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

/// A place at which a body touches an obstacle. What the touch gives are impulses (N s), and
/// Touch::pushed and Touch::rubbed are not used.
struct BodyTouch {
  std::uint32_t body = 0, obstacle = 0;
  Spot spot = Spot::from;
  Vec3 arm = Vec3::Zero();  // m, from the centre of mass to where it touches, world axes
  Touch touch;
  /// The way in which it slides already, whatever moves it; zero: it may stick.
  Vec3 ahead = Vec3::Zero();
  Vec3 given = Vec3::Zero();  // N s, found by solve()
};

/// A twist is a velocity of the centre of mass and a spin; or the rates of both.
Vec3 velocity_at(const Vec6& twist, const Vec3& arm);

/// What a body's twist changes by under an impulse, its inverse mass and inertia in world axes.
Mat6 mobility(double inverse_mass, const Mat3& inverse_inertia);

/// How (m/s, or 1/kg) a point of a body that answers so moves under what pulls at another.
Mat3 mobility(const Mat6& answer, const Vec3& arm, const Vec3& pulled);

/// A body with the touches that it has.
class BodySystem {
 public:
  /// `share` of the impulses makes the velocities that solve() speaks of.
  void assemble(const Mat6& mobility, std::span<const BodyTouch> touches, double share = 1);

  /// What the touches give so that they and their velocities obey the laws of touch.h, where
  /// `bare` (m/s) are the velocities without; begins at BodyTouch::given. What sticks creeps with
  /// that share of what its friction would make of the free body. False: nothing was found.
  bool solve(std::span<const Vec3> bare, std::span<BodyTouch> touches, double creep);

  /// What the touches give if each stays open, slides along `ahead` or sticks as its state says.
  void hold(std::span<const Vec3> bare, std::span<BodyTouch> touches);

  /// How the velocity of one touch changes with what another gives (1/kg).
  Mat3 coupling(std::size_t i, std::size_t k) const;

  /// The twist that `touches` give.
  Vec6 twist(std::span<const BodyTouch> touches) const;

  /// After either: the mobility of the body under further pulls.
  Mat6 answer(std::span<const BodyTouch> touches);

 private:
  using Block = Eigen::Matrix<double, 3, 6>;

  Vec3 velocity(std::size_t i, std::span<const Vec3> bare) const;
  bool solve_one(std::size_t i, const Vec3& bare, BodyTouch& touch) const;
  bool slide_one(std::size_t i, const Vec3& bare, BodyTouch& touch) const;
  void linearize(std::span<const Vec3> bare, std::span<const BodyTouch> touches);
  std::vector<Vec3> solve_linear(std::span<const BodyTouch> touches) const;
  bool sticks(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool polish(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool is_solved(std::span<const Vec3> bare, std::span<const BodyTouch> touches) const;

  Mat6 mobility_ = Mat6::Zero();
  double share_ = 1, ease_ = 1, creep_ = 0;  // ease_: 1/kg, of the free body, shared
  std::vector<Block> lever_;                 // of a twist to the velocity of a touch
  Eigen::MatrixXd coupling_;                 // 1/kg, of the velocities by what is given, shared
  std::vector<Vec3> given_, bare_;           // N s, m/s
  // The laws, linearized: matrix_ d(given) = -slope_ d(bare), in multiples of ease_.
  Eigen::MatrixXd matrix_, slope_;
  Eigen::VectorXd error_;
};

}  // namespace taut::contact
