// The Open Dynamics Engine: bodies that joints keep at distances.
#include <ode/ode.h>

#include <optional>

#include "tests/bench/engines/engine.h"
#include "tests/bench/engines/ode_touch.h"
#include "tests/bench/engines/ode_world.h"

namespace taut::engines {
namespace {

class OdeNet : public NetEngine {
 public:
  explicit OdeNet(const Settings& settings)
      : NetEngine(number(settings, "step")), world_(make_ode_world(settings)) {}
  ~OdeNet() override {
    touch_.reset();
    dJointGroupDestroy(pulls_);
    world_.destroy();
  }

 private:
  void build(const Points& net) override {
    dWorldSetGravity(world_.id, net.gravity().x(), net.gravity().y(), net.gravity().z());
    for (const Point& point : net.points()) {
      bodies_.push_back(point.held ? nullptr : make(point));
    }
    for (const Link& link : net.links()) {
      if (link.pulls) {
        strings_.push_back(link);
        continue;
      }
      const bool turned = !bodies_[link.a];  // what is held is no body, and comes last
      const std::size_t a = turned ? link.b : link.a, b = turned ? link.a : link.b;
      const Vec3 &at = net.points()[a].position, &end = net.points()[b].position;
      const dJointID joint = dJointCreateDBall(world_.id, nullptr);
      dJointAttach(joint, bodies_[a], bodies_[b]);
      dJointSetDBallAnchor1(joint, at.x(), at.y(), at.z());
      dJointSetDBallAnchor2(joint, end.x(), end.y(), end.z());
    }
    for (const Point& point : net.points()) held_.push_back(point.position);
    if (net.obstacles().empty()) return;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i]) touch_->add_ball(bodies_[i], net.points()[i].radius, Vec3::Zero());
    }
    for (const Obstacle& obstacle : net.obstacles()) {
      touch_->add_solid(world_.id, obstacle, obstacle.place);
    }
  }

  Vec3 place(std::size_t point) const {
    if (!bodies_[point]) return held_[point];
    return Eigen::Map<const Vec3>(dBodyGetPosition(bodies_[point]));
  }

  /// A string that is at its length: a contact joint without friction, for that is ODE's own joint
  /// which acts one way. Its normal points to the other end, so that it pushes the ends together.
  void pull(const Link& link) {
    const Vec3 a = place(link.a), b = place(link.b);
    const double length = (b - a).norm();
    if (length < link.length) return;
    const bool turned = !bodies_[link.a];
    const Vec3 towards = (turned ? a - b : b - a) / length, at = turned ? b : a;
    dContact contact{};
    for (int k = 0; k < 3; ++k) {
      contact.geom.pos[k] = at[k];
      contact.geom.normal[k] = towards[k];
    }
    contact.geom.depth = length - link.length;
    const dJointID joint = dJointCreateContact(world_.id, pulls_, &contact);
    dJointAttach(joint, bodies_[turned ? link.b : link.a], bodies_[turned ? link.a : link.b]);
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

  void step(double time, double dt) override {
    for (const Link& link : strings_) pull(link);
    if (touch_->any()) touch_->find(world_.id);
    world_.step(time, dt);
    touch_->forget();
    dJointGroupEmpty(pulls_);
  }

  void read(std::vector<Vec3>& positions) override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i]) positions[i] = Eigen::Map<const Vec3>(dBodyGetPosition(bodies_[i]));
    }
  }

  OdeWorld world_;
  std::vector<dBodyID> bodies_;  // of the points, null where they are held; the world owns them
  std::vector<Vec3> held_;       // m, of all points at the start
  std::vector<Link> strings_;
  std::optional<OdeTouch> touch_{std::in_place};
  dJointGroupID pulls_ = dJointGroupCreate(0);
};

}  // namespace

MethodInfo ode_net_method() {
  return {.name = "ode-net",
          .summary = "the Open Dynamics Engine: bodies that joints keep at distances",
          .settings = ode_settings(),
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<OdeNet>(settings);
          },
          .abilities = {kPlainFeatures | kJointFeatures | kTouched | Feature::strings}};
}

}  // namespace taut::engines
