// How the twists of rigid bodies respond to what pulls them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "sim/motion/types.h"

namespace taut::contact {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

inline constexpr std::uint32_t kNoBody = UINT32_MAX;  // in the place of a body's number

/// A twist is a velocity of the centre of mass and a spin; or the rates of both.
Vec3 velocity_at(const Vec6& twist, const Vec3& arm);

/// The change of a body's twist per impulse, from its inverse mass and inertia in world axes.
Mat6 mobility(double inverse_mass, const Mat3& inverse_inertia);

/// The change (m/s, or 1/kg) of a point's velocity per impulse at another point of the body.
Mat3 mobility(const Mat6& twists, const Vec3& arm, const Vec3& pulled);

/// How each of many bodies responds to a pull: by itself, or together with those that it touches.
class BodyMobility {
 public:
  /// Each by itself.
  void set_apart(std::span<const Mat6> own);
  /// These together: by rows, how the twist of one changes under what pulls at another.
  void set(std::span<const std::uint32_t> bodies, std::span<const Mat6> blocks);

  std::size_t size() const { return own_.size(); }
  /// To what pulls at the body itself.
  const Mat6& own(std::size_t body) const { return own_[body]; }
  /// Whether a pull at one may move the other.
  bool meet(std::size_t a, std::size_t b) const {
    return a == b || (place_[a].count > 0 && place_[a].first == place_[b].first);
  }
  /// How one that meets the other moves under what pulls at that.
  const Mat6& between(std::size_t moved, std::size_t pulled) const {
    if (moved == pulled) return own_[moved];
    return blocks_[place_[moved].first + place_[moved].index * place_[moved].count +
                   place_[pulled].index];
  }
  /// All that a pull at the body moves, itself included.
  std::span<const std::uint32_t> moved_with(const std::uint32_t& body) const {
    const Place& at = place_[body];
    return at.count > 0 ? std::span(&bodies_[at.listed], at.count) : std::span(&body, 1);
  }

 private:
  struct Place {  // of a body among those that it touches; count 0: it touches none
    std::size_t first = 0, index = 0, count = 0, listed = 0;
  };
  std::vector<Mat6> own_, blocks_;
  std::vector<Place> place_;
  std::vector<std::uint32_t> bodies_;  // those that touch others
};

}  // namespace taut::contact
