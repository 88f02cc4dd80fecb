// Bullet's btMultiBody: joint coordinates, Featherstone's algorithm, one spherical joint a rod.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>
#include <memory>

#include "tests/bench/engines/engine.h"

namespace taut::engines {
namespace {

btVector3 bullet(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
Vec3 eigen(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
Quat eigen(const btQuaternion& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}

class Bullet : public Engine {
 public:
  explicit Bullet(const Settings& settings)
      : Engine(number(settings, "step")), runge_kutta_(text(settings, "integrator") == "rk4") {}

 private:
  void build(const Rods& rods) override {
    const auto count = static_cast<int>(rods.rods().size()) + (rods.load() ? 1 : 0);
    constexpr bool kFixedBase = true, kCanSleep = false;
    body_ = std::make_unique<btMultiBody>(count, 0, btVector3(0, 0, 0), kFixedBase, kCanSleep);
    Vec3 from = Vec3::Zero();  // of the joint, from the centre of mass above
    int i = 0;
    for (const Rod& rod : rods.rods()) {
      const Vec3 centre = rod.centre * rod.along;
      body_->setupSpherical(i, rod.mass, btVector3(1, 1, 1) * rod.inertia, i - 1,
                            btQuaternion::getIdentity(), bullet(from), bullet(centre), true);
      lower_.push_back(rod.along - centre);
      from = lower_.back();
      ++i;
    }
    if (rods.load()) add(*rods.load(), i, from);
    body_->finalizeMultiDof();
    body_->setLinearDamping(0);
    body_->setAngularDamping(0);
    body_->setMaxCoordinateVelocity(1e6);
    body_->useRK4Integration(runge_kutta_);
    set_in_motion(rods);
    world_.addMultiBody(body_.get());
  }

  /// Bullet's links have the axes of their principal moments.
  void add(const Load& load, int i, const Vec3& from) {
    const Eigen::SelfAdjointEigenSolver<Mat3> principal(load.inertia);
    Mat3 axes = principal.eigenvectors();
    if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
    const Quat to_link = Quat(axes).conjugate();
    axes_ = Quat(axes);
    body_->setupSpherical(i, load.mass, bullet(principal.eigenvalues()), i - 1,
                          {to_link.x(), to_link.y(), to_link.z(), to_link.w()}, bullet(from),
                          bullet(to_link * load.centre), true);
    loaded_ = true;
  }

  /// Joints turn by the difference of the spins that they join, in the axes of the link below.
  void set_in_motion(const Rods& rods) {
    Vec3 above = Vec3::Zero();
    int i = 0;
    const auto set = [&](const Vec3& spin, const Quat& to_link) {
      const btVector3 turn = bullet(to_link * (spin - above));
      const btScalar rates[] = {turn.x(), turn.y(), turn.z()};
      body_->setJointVelMultiDof(i++, rates);
      above = spin;
    };
    for (const Rod& rod : rods.rods()) set(rod.spin, Quat::Identity());
    if (rods.load()) set(rods.load()->spin, axes_.conjugate());
  }

  void step(double time, double dt) override {
    world_.setGravity(bullet(gravity(time + dt / 2)));
    constexpr int kAsGiven = 0;  // one step of dt, none of Bullet's own choice
    world_.stepSimulation(dt, kAsGiven);
  }

  void read(std::vector<Vec3>& ends, Quat& turn) override {
    body_->forwardKinematics(rotations_, origins_);
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const btTransform& at = body_->getLink(static_cast<int>(i)).m_cachedWorldTransform;
      ends[i] = eigen(at * bullet(lower_[i]));
    }
    if (!loaded_) return;
    const btTransform& at = body_->getLink(static_cast<int>(ends.size())).m_cachedWorldTransform;
    turn = (eigen(at.getRotation()) * axes_.conjugate()).normalized();
  }

  bool runge_kutta_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::unique_ptr<btMultiBody> body_;  // the world does not own it
  std::vector<Vec3> lower_;            // m, from each rod's centre of mass to its lower end
  bool loaded_ = false;
  Quat axes_ = Quat::Identity();  // of the load's principal moments, at the start
  btAlignedObjectArray<btQuaternion> rotations_;
  btAlignedObjectArray<btVector3> origins_;
};

}  // namespace

MethodInfo bullet_method() {
  return {.name = "bullet",
          .summary = "Bullet's btMultiBody: joint coordinates by Featherstone's algorithm",
          .settings = {step_setting(false, 20),
                       {.name = "integrator",
                        .meaning = "Semi-implicit Euler or the classical Runge-Kutta method.",
                        .unit = "",
                        .fallback = std::string("euler"),
                        .choices = {"euler", "rk4"},
                        .sweep = {std::string("euler"), std::string("rk4")}}},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<Bullet>(settings);
          }};
}

}  // namespace taut::engines
