// Simbody: joint coordinates, exact constraints for loops, Runge-Kutta-Merson with error control.
#include <Simbody.h>

#include <cmath>

#include "tests/answers/engines/rigid.h"

namespace rigid {
namespace {

SimTK::Vec3 simbody(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

SimTK::Rotation simbody(const Quat& q) {
  return SimTK::Rotation(SimTK::Quaternion(q.w(), q.x(), q.y(), q.z()));
}

Vec3 eigen(const SimTK::Vec3& v) {
  return {v[0], v[1], v[2]};
}

class Simbody final : public Engine {
 public:
  explicit Simbody(const Model& model) : integrator_(system_) {
    if (!model.contacts.empty()) throw CannotExpress("contact: Simbody's is elastic");
    if (model.gravity.norm() > 0) {
      SimTK::Force::UniformGravity(forces_, matter_, simbody(model.gravity));
    }
    for (const Body& body : model.bodies) add(model, body);
    for (const Loop& loop : model.loops) {
      SimTK::Constraint::Ball(mobilized(loop.a), simbody(point(model, loop.a, loop.place)),
                              mobilized(loop.b), simbody(point(model, loop.b, loop.place)));
    }
    for (const Spring& spring : model.springs) {
      const auto &a = mobilized(spring.a), &b = mobilized(spring.b);
      const SimTK::Vec3 at_a = simbody(spring.at_a), at_b = simbody(spring.at_b);
      SimTK::Force::TwoPointLinearSpring(forces_, a, at_a, b, at_b, spring.stiffness,
                                         spring.length);
      SimTK::Force::TwoPointLinearDamper(forces_, a, at_a, b, at_b, spring.damping);
    }
    SimTK::State start = system_.realizeTopology();
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = model.bodies[i];
      const Quat to_body = body.start.rotation.conjugate();
      if (body.parent == kFree) {
        bodies_[i].setQToFitTransform(
            start, SimTK::Transform(simbody(body.start.rotation), simbody(body.start.position)));
        bodies_[i].setUToFitVelocity(
            start, SimTK::SpatialVec(simbody(body.start.spin), simbody(body.start.velocity)));
      } else {
        const Vec3 turn = body.start.spin - model.start(body.parent).spin;
        bodies_[i].setUToFitAngularVelocity(start, simbody(Vec3(to_body * turn)));
      }
    }
    integrator_.setAccuracy(kAccuracy);
    integrator_.setConstraintTolerance(kAccuracy);
    integrator_.setAllowInterpolation(false);
    integrator_.setMaximumStepSize(model.step);
    integrator_.initialize(start);
  }

  void step(double dt) override {
    time_ += dt;
    while (integrator_.getTime() < time_) integrator_.stepTo(time_);
  }

  State state(int body) override {
    const SimTK::State& now = integrator_.getState();
    system_.realize(now, SimTK::Stage::Velocity);
    const auto& one = bodies_[static_cast<std::size_t>(body)];
    const SimTK::Quaternion q = one.getBodyRotation(now).convertRotationToQuaternion();
    return {eigen(one.getBodyOriginLocation(now)), Quat(q[0], q[1], q[2], q[3]),
            eigen(one.getBodyOriginVelocity(now)), eigen(one.getBodyAngularVelocity(now))};
  }

 private:
  static constexpr double kAccuracy = 1e-10;

  SimTK::MobilizedBody& mobilized(int body) {
    if (body < 0) return matter_.updGround();
    return bodies_[static_cast<std::size_t>(body)];
  }

  static Vec3 point(const Model& model, int body, const Vec3& place) {
    return body < 0 ? place : model.bodies[static_cast<std::size_t>(body)].in_body(place);
  }

  void add(const Model& model, const Body& body) {
    const SimTK::Body::Rigid rigid(SimTK::MassProperties(
        body.mass, SimTK::Vec3(0),
        SimTK::Inertia(body.inertia.x(), body.inertia.y(), body.inertia.z())));
    if (body.parent == kFree) {
      bodies_.push_back(SimTK::MobilizedBody::Free(matter_.updGround(), rigid));
      return;
    }
    const Quat from_parent = model.start(body.parent).rotation.conjugate() * body.start.rotation;
    bodies_.push_back(SimTK::MobilizedBody::Ball(
        mobilized(body.parent),
        SimTK::Transform(simbody(from_parent), simbody(point(model, body.parent, body.joint))),
        rigid, SimTK::Transform(simbody(body.in_body(body.joint)))));
  }

  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  SimTK::RungeKuttaMersonIntegrator integrator_;
  std::vector<SimTK::MobilizedBody> bodies_;
  double time_ = 0;
};

}  // namespace

std::unique_ptr<Engine> make_simbody(const Model& model) {
  return std::make_unique<Simbody>(model);
}

}  // namespace rigid
