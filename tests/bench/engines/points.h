// Connectors that are joined as engines can have them: point masses and the links between them.
#pragma once

#include <vector>

#include "sim/world/world.h"

namespace taut::engines {

/// A particle, or the particles that a joint makes one.
struct Point {
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero();  // m, m/s, at the start
  double mass = 0;                                        // kg
  bool held = false;                                      // where it is
  double radius = 0;                                      // m, of the ball that touches obstacles
};

/// Between two points of which one at least moves; as long as it is at the start or, a string, at
/// most that long.
struct Link {
  std::size_t a = 0, b = 0;
  double length = 0;  // m
  bool pulls = false;
};

/// The connectors of a world, some of whose points are fixed, and the obstacles that all others
/// touch, which stand still.
class Points {
 public:
  /// Throws std::invalid_argument with the reason where the world has more than this.
  explicit Points(const World& world);

  const std::vector<Point>& points() const { return points_; }
  const std::vector<Link>& links() const { return links_; }
  const std::vector<Obstacle>& obstacles() const { return obstacles_; }
  const Vec3& gravity() const { return gravity_; }  // m/s^2
  /// Puts the world at `time`: `positions` (m) are those of all points.
  void place(const std::vector<Vec3>& positions, double time, World& world) const;

 private:
  std::vector<Point> points_;
  std::vector<Link> links_;
  std::vector<Obstacle> obstacles_;
  std::vector<std::size_t> point_of_;  // of the particles, connector by connector
  Vec3 gravity_ = Vec3::Zero();
};

}  // namespace taut::engines
