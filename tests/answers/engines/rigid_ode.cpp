// The Open Dynamics Engine: bodies in Cartesian coordinates, joints by dWorldStep, which solves
// them exactly.
#include <ode/ode.h>

#include <cstdarg>
#include <cstdio>

#include "tests/answers/engines/rigid.h"

namespace rigid {
namespace {

Vec3 vector(const dReal* v) {
  return {v[0], v[1], v[2]};
}

class Ode final : public Engine {
 public:
  explicit Ode(const Model& model) : model_(model) {
    dInitODE2(0);
    // It would end the program where something is not finite.
    dSetDebugHandler([](int, const char* message, va_list values) {
      char text[200] = "";
      std::vsnprintf(text, sizeof text, message, values);
      throw std::runtime_error(text);
    });
    dSetMessageHandler([](int, const char*, va_list) {});
    world_ = dWorldCreate();
    dWorldSetGravity(world_, model.gravity.x(), model.gravity.y(), model.gravity.z());
    dWorldSetCFM(world_, 0);
    touching_ = dJointGroupCreate(0);
    for (const Body& body : model.bodies) add(body);
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      const Body& body = model.bodies[i];
      if (body.parent != kFree) join(static_cast<int>(i), body.parent, body.joint);
    }
    for (const Loop& loop : model.loops) join(loop.a, loop.b, loop.place);
    shapes_.resize(model.bodies.size());
    for (const Shape& shape : model.shapes) add(shape);
    for (const Obstacle& obstacle : model.obstacles) add(obstacle);
  }

  void step(double dt) override {
    for (const Spring& spring : model_.springs) {
      const Vec3 force = spring_force(spring, *this);
      push(spring.b, spring.at_b, force);
      push(spring.a, spring.at_a, -force);
    }
    dJointGroupEmpty(touching_);
    for (const Contact& contact : model_.contacts) {
      for (const dGeomID one : shapes_[static_cast<std::size_t>(contact.body)]) {
        const auto other = static_cast<std::size_t>(contact.other);
        if (contact.with_obstacle) {
          touch(contact, one, obstacles_[other]);
        } else {
          for (const dGeomID theirs : shapes_[other]) touch(contact, one, theirs);
        }
      }
    }
    dWorldStep(world_, dt);
  }

  State state(int body) override {
    const dBodyID one = body_of(body);
    const dReal* q = dBodyGetQuaternion(one);
    return {vector(dBodyGetPosition(one)), Quat(q[0], q[1], q[2], q[3]),
            vector(dBodyGetLinearVel(one)), vector(dBodyGetAngularVel(one))};
  }

 private:
  dBodyID body_of(int body) const {
    return body < 0 ? nullptr : bodies_[static_cast<std::size_t>(body)];
  }

  void add(const Body& body) {
    const dBodyID made = dBodyCreate(world_);
    dMass mass;
    dMassSetParameters(&mass, body.mass, 0, 0, 0, body.inertia.x(), body.inertia.y(),
                       body.inertia.z(), 0, 0, 0);
    dBodySetMass(made, &mass);
    const State& start = body.start;
    const dQuaternion turn{start.rotation.w(), start.rotation.x(), start.rotation.y(),
                           start.rotation.z()};
    dBodySetQuaternion(made, turn);
    dBodySetPosition(made, start.position.x(), start.position.y(), start.position.z());
    dBodySetLinearVel(made, start.velocity.x(), start.velocity.y(), start.velocity.z());
    dBodySetAngularVel(made, start.spin.x(), start.spin.y(), start.spin.z());
    dBodySetFiniteRotationMode(made, 1);
    bodies_.push_back(made);
  }

  void join(int a, int b, const Vec3& place) {
    const dJointID joint = dJointCreateBall(world_, nullptr);
    dJointAttach(joint, body_of(a), body_of(b));
    dJointSetBallAnchor(joint, place.x(), place.y(), place.z());
  }

  void add(const Shape& shape) {
    const Vec3 along = shape.to - shape.from, middle = (shape.from + shape.to) / 2;
    const bool is_ball = along.isZero(0);
    const dGeomID made = is_ball ? dCreateSphere(nullptr, shape.radius)
                                 : dCreateCapsule(nullptr, shape.radius, along.norm());
    dGeomSetBody(made, body_of(shape.body));
    dGeomSetOffsetPosition(made, middle.x(), middle.y(), middle.z());
    if (!is_ball) {
      const Quat turn = Quat::FromTwoVectors(Vec3::UnitZ(), along);
      const dQuaternion q{turn.w(), turn.x(), turn.y(), turn.z()};
      dGeomSetOffsetQuaternion(made, q);
    }
    shapes_[static_cast<std::size_t>(shape.body)].push_back(made);
  }

  void add(const Obstacle& obstacle) {
    const Vec3& at = obstacle.position;
    if (obstacle.is_plane()) {
      const Vec3 up = obstacle.rotation * Vec3::UnitY();
      obstacles_.push_back(dCreatePlane(nullptr, up.x(), up.y(), up.z(), up.dot(at)));
      return;
    }
    const dGeomID box =
        dCreateBox(nullptr, obstacle.size.x(), obstacle.size.y(), obstacle.size.z());
    const Quat& turn = obstacle.rotation;
    const dQuaternion q{turn.w(), turn.x(), turn.y(), turn.z()};
    dGeomSetPosition(box, at.x(), at.y(), at.z());
    dGeomSetQuaternion(box, q);
    obstacles_.push_back(box);
  }

  void push(int body, const Vec3& point, const Vec3& force) {
    if (body == kWorld) return;
    const Vec3 at = state(body).place(point);
    dBodyAddForceAtPos(body_of(body), force.x(), force.y(), force.z(), at.x(), at.y(), at.z());
  }

  Vec3 velocity(dGeomID geom, const Vec3& place) const {
    const dBodyID body = dGeomGetBody(geom);
    if (!body) return Vec3::Zero();
    dVector3 v;
    dBodyGetPointVel(body, place.x(), place.y(), place.z(), v);
    return vector(v);
  }

  void touch(const Contact& contact, dGeomID one, dGeomID other) {
    constexpr int kMost = 8;
    dContact found[kMost];
    const int count = dCollide(one, other, kMost, &found[0].geom, sizeof(dContact));
    for (int i = 0; i < count; ++i) {
      const dContactGeom& geom = found[i].geom;
      found[i].surface = {};
      found[i].surface.mode = dContactApprox1 | dContactBounce;
      found[i].surface.mu = contact.friction;
      found[i].surface.bounce = contact.restitution;
      const Vec3 place = vector(geom.pos), normal = vector(geom.normal);
      Vec3 slip = velocity(geom.g1, place) - velocity(geom.g2, place);
      slip -= slip.dot(normal) * normal;
      if (slip.norm() >
          0) {  // ODE's friction is a pyramid: with an edge along the slip it is Coulomb's
        slip.normalize();
        found[i].surface.mode |= dContactFDir1;
        for (int k = 0; k < 3; ++k) found[i].fdir1[k] = slip[k];
      }
      const dJointID joint = dJointCreateContact(world_, touching_, &found[i]);
      dJointAttach(joint, dGeomGetBody(geom.g1), dGeomGetBody(geom.g2));
    }
  }

  const Model& model_;
  dWorldID world_;
  dJointGroupID touching_;
  std::vector<dBodyID> bodies_;
  std::vector<std::vector<dGeomID>> shapes_;  // of each body
  std::vector<dGeomID> obstacles_;
};

}  // namespace

std::unique_ptr<Engine> make_ode(const Model& model) {
  return std::make_unique<Ode>(model);
}

}  // namespace rigid
