#include "tests/bench/engines/bullet_solid.h"

namespace taut::engines {
namespace {

std::unique_ptr<btCollisionShape> make_shape(const Shape& shape) {
  switch (shape.kind) {
    case Shape::Kind::plane:
      return std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 0);
    case Shape::Kind::sphere:
      return std::make_unique<btSphereShape>(shape.radius);
    case Shape::Kind::capsule:
      return std::make_unique<btCapsuleShape>(shape.radius, shape.length);
    case Shape::Kind::cylinder:
      return std::make_unique<btCylinderShape>(
          btVector3(shape.radius, shape.length / 2, shape.radius));
    case Shape::Kind::box:
      return std::make_unique<btBoxShape>(bullet(shape.size / 2));
  }
  return nullptr;
}

}  // namespace

BulletSolid make_bullet_solid(const Obstacle& obstacle) {
  BulletSolid solid;
  solid.shape = make_shape(obstacle.shape);
  if (obstacle.shape.rounding > 0) solid.shape->setMargin(obstacle.shape.rounding);
  if (obstacle.path) {
    constexpr double kNoMass = 0;
    solid.object = std::make_unique<btRigidBody>(kNoMass, nullptr, solid.shape.get());
    solid.object->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    solid.object->setActivationState(DISABLE_DEACTIVATION);
  } else {
    solid.object = std::make_unique<btCollisionObject>();
    solid.object->setCollisionShape(solid.shape.get());
  }
  // Bullet's friction and restitution of a pair are the products of both things' own: beads have 1.
  solid.object->setFriction(obstacle.kinetic_friction);
  solid.object->setRestitution(obstacle.restitution);
  return solid;
}

void place_bullet_solid(const Obstacle& obstacle, const FrameMotion& motion, double dt,
                        btCollisionObject& object) {
  object.setWorldTransform(btTransform(bullet(motion.rotation), bullet(motion.position)));
  if (!obstacle.path) return;
  // Bullet takes the velocity of what is kinematic from where it was a step ago.
  const double rate = motion.spin.norm();
  Quat before = motion.rotation;
  if (rate > 0) before = Eigen::AngleAxisd(-dt * rate, motion.spin / rate) * before;
  object.setInterpolationWorldTransform(
      btTransform(bullet(before), bullet(motion.position - dt * motion.velocity)));
}

}  // namespace taut::engines
