#include "tests/bench/engines/ode_touch.h"

#include <algorithm>

#include "sim/motion/rotation.h"
#include "tests/bench/engines/solids.h"

namespace taut::engines {
namespace {

/// Centred on its frame's origin, with the axis along z.
dGeomID make_geometry(dSpaceID space, const Shape& shape) {
  switch (shape.kind) {
    case Shape::Kind::sphere:
      return dCreateSphere(space, shape.radius);
    case Shape::Kind::box:
      return dCreateBox(space, shape.size.x(), shape.size.y(), shape.size.z());
    case Shape::Kind::capsule:
      return dCreateCapsule(space, shape.radius, shape.length);
    case Shape::Kind::cylinder:
      return dCreateCylinder(space, shape.radius, shape.length);
    case Shape::Kind::plane:
      return dCreatePlane(space, 0, 1, 0, 0);
  }
  return nullptr;
}

void place(const Shape& shape, dGeomID geometry, const Pose& at) {
  if (shape.kind == Shape::Kind::plane) {
    const Vec3 up = at.rotation * Vec3::UnitY();
    dGeomPlaneSetParams(geometry, up.x(), up.y(), up.z(), up.dot(at.position));
    return;
  }
  const Quat turn = with_axis_along_z(shape, at.rotation);
  const dQuaternion q{turn.w(), turn.x(), turn.y(), turn.z()};
  dGeomSetQuaternion(geometry, q);
  dGeomSetPosition(geometry, at.position.x(), at.position.y(), at.position.z());
}

}  // namespace

OdeTouch::~OdeTouch() {
  for (const dSpaceID space : {bodies_, solids_}) dSpaceDestroy(space);  // with what is in them
  dJointGroupDestroy(contacts_);
}

void OdeTouch::add_ball(dBodyID body, double radius, const Vec3& at) {
  const dGeomID ball = dCreateSphere(bodies_, radius);
  dGeomSetBody(ball, body);
  dGeomSetOffsetPosition(ball, at.x(), at.y(), at.z());
}

void OdeTouch::add_capsule(dBodyID body, double radius, const Vec3& from, const Vec3& to) {
  const Vec3 along = to - from, middle = (from + to) / 2;
  if (along.isZero(0)) return add_ball(body, radius, middle);
  const dGeomID capsule = dCreateCapsule(bodies_, radius, along.norm());
  dGeomSetBody(capsule, body);
  const Quat turn = rotation_between(Vec3::UnitZ(), along.normalized());
  const dQuaternion q{turn.w(), turn.x(), turn.y(), turn.z()};
  dGeomSetOffsetPosition(capsule, middle.x(), middle.y(), middle.z());
  dGeomSetOffsetQuaternion(capsule, q);
}

void OdeTouch::add_solid(dWorldID world, const Obstacle& obstacle, const Pose& at) {
  Solid solid{&obstacle, make_geometry(solids_, obstacle.shape), nullptr};
  dGeomSetData(solid.geometry, const_cast<Obstacle*>(&obstacle));
  place(obstacle.shape, solid.geometry, at);
  if (obstacle.path && obstacle.shape.kind != Shape::Kind::plane) {
    solid.body = dBodyCreate(world);
    dBodySetKinematic(solid.body);
    dGeomSetBody(solid.geometry, solid.body);
  }
  solids_of_.push_back(solid);
}

void OdeTouch::move(const Obstacle& obstacle, const FrameMotion& motion) {
  const Solid& solid = *std::ranges::find(solids_of_, &obstacle, &Solid::obstacle);
  place(obstacle.shape, solid.geometry, motion.pose());
  if (!solid.body) return;
  dBodySetLinearVel(solid.body, motion.velocity.x(), motion.velocity.y(), motion.velocity.z());
  dBodySetAngularVel(solid.body, motion.spin.x(), motion.spin.y(), motion.spin.z());
}

void OdeTouch::find(dWorldID world) {
  forget();
  world_ = world;
  const auto near = [](void* own, dGeomID a, dGeomID b) {
    static_cast<OdeTouch*>(own)->touch(a, b);
  };
  dSpaceCollide2(reinterpret_cast<dGeomID>(bodies_), reinterpret_cast<dGeomID>(solids_), this,
                 near);
}

void OdeTouch::touch(dGeomID a, dGeomID b) {
  constexpr int kMost = 4;
  dContact found[kMost];
  const int count = dCollide(a, b, kMost, &found[0].geom, sizeof(dContact));
  const bool is_first = dGeomGetSpace(a) == solids_;
  const auto& with = *static_cast<const Obstacle*>(dGeomGetData(is_first ? a : b));
  for (int i = 0; i < count; ++i) {
    found[i].surface = {};
    found[i].surface.mode = dContactApprox1 | dContactBounce;
    found[i].surface.mu = with.kinetic_friction;
    found[i].surface.bounce = with.restitution;
    const dJointID joint = dJointCreateContact(world_, contacts_, &found[i]);
    dJointAttach(joint, dGeomGetBody(found[i].geom.g1), dGeomGetBody(found[i].geom.g2));
  }
}

}  // namespace taut::engines
