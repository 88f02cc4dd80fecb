// Obstacles in Bullet, and taut's vectors as Bullet's.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>

#include "sim/motion/types.h"
#include "sim/world/obstacle.h"

namespace taut::engines {

inline btVector3 bullet(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
inline btQuaternion bullet(const Quat& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}
inline Vec3 eigen(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
inline Quat eigen(const btQuaternion& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}

struct BulletSolid {
  std::unique_ptr<btCollisionShape> shape;
  std::unique_ptr<btCollisionObject> object;  // kinematic where the obstacle has a path
};

/// Edges are rounded by what Bullet calls the margin: by what the obstacle's are, else by as little
/// as Bullet chooses.
BulletSolid make_bullet_solid(const Obstacle& obstacle);
/// Places it for a step of `dt` (s; zero where it stands still), through which it moves so.
void place_bullet_solid(const Obstacle& obstacle, const FrameMotion& motion, double dt,
                        btCollisionObject& object);

}  // namespace taut::engines
