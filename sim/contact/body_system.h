// How rigid bodies respond to what they touch: unilateral contact with Coulomb friction at several
// points of one body, or of several that touch each other.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "sim/contact/body_touch.h"

namespace taut::contact {

/// Bodies that touch each other, or one alone, with all the touches that they have.
class BodySystem {
 public:
  /// `mobility` of all bodies, of which those count that have touches; `share` of the impulses
  /// makes the velocities that solve() speaks of.
  void assemble(std::span<const Mat6> mobility, std::span<const BodyTouch> touches,
                double share = 1);

  /// The same of whatever moves at the touches: its velocities by what is given (1/kg), three rows
  /// and columns a touch; and the inverse mass of each touch, by which errors are measured. Links
  /// may have a part in that, so that nothing moves some touches in some directions.
  void assemble(const Eigen::MatrixXd& coupling, std::span<const double> inverse_mass);

  /// Finds the impulses (or forces) at which the touches obey the laws of touch.h; `bare` (m/s) are
  /// the velocities without. Starts at BodyTouch::given. A touch that sticks creeps with the share
  /// `creep` of the velocity that its friction would give free bodies. False: none found.
  bool solve(std::span<const Vec3> bare, std::span<BodyTouch> touches, double creep);

  /// Finds the impulses if each touch stays open, slides along `ahead` or sticks as its state says.
  void hold(std::span<const Vec3> bare, std::span<BodyTouch> touches);

  /// The derivative of one touch's velocity by another's impulse (1/kg).
  Mat3 coupling(std::size_t i, std::size_t k) const;

  /// The bodies, in the order in which touches name them.
  std::span<const std::uint32_t> bodies() const { return bodies_; }
  /// The twist that `touches` give to one of bodies().
  Vec6 twist(std::span<const BodyTouch> touches, std::size_t index) const;

  /// After solve() or hold(): how the bodies respond to further pulls.
  void couple(std::span<const BodyTouch> touches, BodyMobility& mobility);

 private:
  using Block = Eigen::Matrix<double, 3, 6>;
  /// A body at a touch: its twist makes a part of the touch's velocity. Index kNoBody: none.
  struct Side {
    std::uint32_t index = kNoBody;
    Block lever;
  };

  double held_back(std::size_t touch) const;
  std::uint32_t index_of(std::uint32_t body, std::span<const Mat6> mobility);
  Vec3 velocity(std::size_t i, std::span<const Vec3> bare) const;
  bool solve_one(std::size_t i, const Vec3& bare, BodyTouch& touch) const;
  bool slide_one(std::size_t i, const Vec3& bare, BodyTouch& touch) const;
  void linearize(std::span<const Vec3> bare, std::span<const BodyTouch> touches);
  std::vector<Vec3> solve_linear(std::span<const BodyTouch> touches) const;
  bool goes_on(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool sticks(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool polish(std::span<const Vec3> bare, std::span<BodyTouch> touches);
  bool is_solved(std::span<const Vec3> bare, std::span<const BodyTouch> touches) const;

  std::vector<std::uint32_t> bodies_;
  std::vector<Mat6> mobility_;  // per body of these
  double share_ = 1, creep_ = 0;
  bool several_ = false;  // bodies that touch each other, or what links couple
  bool linked_ = false;
  std::vector<double> inverse_mass_;        // 1/kg, per touch: of the free bodies, shared
  std::vector<std::array<Side, 2>> sides_;  // per touch
  std::vector<Mat6> blocks_;
  Eigen::MatrixXd coupling_;        // 1/kg, of the velocities by what is given, shared
  std::vector<Vec3> given_, bare_;  // N s, m/s
  std::vector<Vec3> tried_;         // N s, what polish() came to last
  // The laws, linearized: matrix_ d(given) = -slope_ d(bare), in multiples of inverse_mass_.
  Eigen::MatrixXd matrix_, slope_;
  Eigen::VectorXd error_;
};

}  // namespace taut::contact
