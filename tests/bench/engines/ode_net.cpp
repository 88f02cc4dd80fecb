// The Open Dynamics Engine: bodies that joints keep at distances.
#include <ode/ode.h>

#include "tests/bench/engines/engine.h"
#include "tests/bench/engines/ode_world.h"

namespace taut::engines {
namespace {

class OdeNet : public NetEngine {
 public:
  explicit OdeNet(const Settings& settings)
      : NetEngine(number(settings, "step")), world_(make_ode_world(settings)) {}
  ~OdeNet() override { dWorldDestroy(world_.id); }

 private:
  void build(const Points& net) override {
    dWorldSetGravity(world_.id, net.gravity().x(), net.gravity().y(), net.gravity().z());
    for (const Point& point : net.points()) {
      bodies_.push_back(point.held ? nullptr : make(point));
    }
    for (const Link& link : net.links()) {
      const bool turned = !bodies_[link.a];  // what is held is no body, and comes last
      const std::size_t a = turned ? link.b : link.a, b = turned ? link.a : link.b;
      const Vec3 &at = net.points()[a].position, &end = net.points()[b].position;
      const dJointID joint = dJointCreateDBall(world_.id, nullptr);
      dJointAttach(joint, bodies_[a], bodies_[b]);
      dJointSetDBallAnchor1(joint, at.x(), at.y(), at.z());
      dJointSetDBallAnchor2(joint, end.x(), end.y(), end.z());
    }
  }

  dBodyID make(const Point& point) {
    const dBodyID body = dBodyCreate(world_.id);
    dMass properties;
    // Nothing turns it, so that its moment of inertia is any.
    dMassSetParameters(&properties, point.mass, 0, 0, 0, point.mass, point.mass, point.mass, 0, 0,
                       0);
    dBodySetMass(body, &properties);
    dBodySetPosition(body, point.position.x(), point.position.y(), point.position.z());
    dBodySetLinearVel(body, point.velocity.x(), point.velocity.y(), point.velocity.z());
    return body;
  }

  void step(double, double dt) override { world_.step(dt); }

  void read(std::vector<Vec3>& positions) override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i]) positions[i] = Eigen::Map<const Vec3>(dBodyGetPosition(bodies_[i]));
    }
  }

  OdeWorld world_;
  std::vector<dBodyID> bodies_;  // of the points, null where they are held; the world owns them
};

}  // namespace

MethodInfo ode_net_method() {
  return {.name = "ode-net",
          .summary = "the Open Dynamics Engine: bodies that joints keep at distances",
          .settings = ode_settings(),
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<OdeNet>(settings);
          },
          .follows_joints = true};
}

}  // namespace taut::engines
