// Bullet's btSoftBody: nodes, and links that position-based dynamics keeps as long as they were.
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <memory>

#include "tests/bench/engines/engine.h"

namespace taut::engines {
namespace {

class BulletNet : public NetEngine {
 public:
  explicit BulletNet(const Settings& settings)
      : NetEngine(number(settings, "step")),
        iterations_(static_cast<int>(number(settings, "iterations"))) {}
  ~BulletNet() override {
    if (body_) world_.removeSoftBody(body_.get());
  }

 private:
  void build(const Points& net) override {
    const Vec3& g = net.gravity();
    world_.setGravity({g.x(), g.y(), g.z()});
    btSoftBodyWorldInfo& info = world_.getWorldInfo();
    info.m_gravity = world_.getGravity();
    info.air_density = 0;
    std::vector<btVector3> places;
    std::vector<btScalar> masses;
    for (const Point& point : net.points()) {
      places.push_back({point.position.x(), point.position.y(), point.position.z()});
      masses.push_back(point.held ? 0 : point.mass);
    }
    body_ = std::make_unique<btSoftBody>(&info, static_cast<int>(places.size()), places.data(),
                                         masses.data());
    for (int i = 0; i < body_->m_nodes.size(); ++i) {
      const Vec3& moves = net.points()[static_cast<std::size_t>(i)].velocity;
      body_->m_nodes[i].m_v = {moves.x(), moves.y(), moves.z()};
    }
    for (const Link& link : net.links()) {
      body_->appendLink(static_cast<int>(link.a), static_cast<int>(link.b), body_->m_materials[0]);
    }
    body_->m_materials[0]->m_kLST = 1;  // as stiff as the iterations make it
    body_->m_cfg.piterations = iterations_;
    body_->m_cfg.collisions = 0;
    body_->setActivationState(DISABLE_DEACTIVATION);
    world_.addSoftBody(body_.get());
  }

  void step(double, double dt) override {
    constexpr int kAsGiven = 0;  // one step of dt, none of Bullet's own choice
    world_.stepSimulation(dt, kAsGiven);
  }

  void read(std::vector<Vec3>& positions) override {
    for (int i = 0; i < body_->m_nodes.size(); ++i) {
      const btVector3& at = body_->m_nodes[i].m_x;
      positions[static_cast<std::size_t>(i)] = {at.x(), at.y(), at.z()};
    }
  }

  int iterations_;
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  std::unique_ptr<btSoftBody> body_;  // the world does not own it
};

}  // namespace

MethodInfo bullet_net_method() {
  return {.name = "bullet-net",
          .summary = "Bullet's btSoftBody: nodes and links by position-based dynamics",
          .settings = {step_setting({}, 20),
                       {.name = "iterations",
                        .meaning = "Passes over the links in a step.",
                        .unit = "1",
                        .fallback = 10.0,
                        .minimum = 1,
                        .maximum = 1e6,
                        .whole = true,
                        .sweep = {1.0, 4.0, 16.0, 64.0}}},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<BulletNet>(settings);
          },
          .abilities = {kPlainFeatures | kJointFeatures}};
}

}  // namespace taut::engines
