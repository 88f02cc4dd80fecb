// The Open Dynamics Engine: every rod six coordinates, held together by ball joints.
#include <ode/ode.h>

#include <optional>

#include "tests/bench/engines/engine.h"
#include "tests/bench/engines/ode_touch.h"
#include "tests/bench/engines/ode_world.h"

namespace taut::engines {
namespace {

Vec3 eigen(const dVector3 v) {
  return {v[0], v[1], v[2]};
}

class Ode : public RodEngine {
 public:
  explicit Ode(const Settings& settings)
      : RodEngine(number(settings, "step")), world_(make_ode_world(settings)) {}
  ~Ode() override {
    touch_.reset();
    world_.destroy();
  }

 private:
  void build(const Rods& rods) override {
    Vec3 top = Vec3::Zero(), moves = rods.velocity();  // m, m/s
    for (const Rod& rod : rods.rods()) {
      const Vec3 centre = rod.centre * rod.along;
      const bool is_joined = rods.hangs() || !bodies_.empty();
      add(rod.mass, top, centre, rod.inertia * Mat3::Identity(), is_joined);
      set_in_motion(moves + rod.spin.cross(centre), rod.spin);
      lower_.push_back(rod.along - centre);
      top += rod.along;
      moves += rod.spin.cross(rod.along);
    }
    if (const auto& load = rods.load()) {
      add(load->mass, top, load->centre, load->inertia, true);
      set_in_motion(moves + load->spin.cross(load->centre), load->spin);
    }
    hangs_ = rods.hangs();
    upper_ = -rods.rods()[0].centre * rods.rods()[0].along;
    for (const Bead& bead : rods.beads()) {
      touch_->add_ball(bodies_[bead.rod], rods.radius(), bead.at);
    }
    if (const auto& load = rods.load(); load && load->capsule.touches()) {
      const BodyCapsule& capsule = load->capsule;
      touch_->add_capsule(bodies_.back(), capsule.radius, capsule.from - load->centre,
                          capsule.to - load->centre);
    }
    rods_ = &rods;
    for (std::size_t i = 0; i < rods.rods().size(); ++i) {
      if (rods.rods()[i].bending_stiffness > 0 || rods.rods()[i].bending_damping > 0) add_spring(i);
    }
    for (const Obstacle& obstacle : rods.obstacles()) {
      touch_->add_solid(world_.id, obstacle, rods.motion(obstacle, world(), world().time).pose());
    }
  }

  /// The body that was added last.
  void set_in_motion(const Vec3& velocity, const Vec3& spin) {
    dBodySetLinearVel(bodies_.back(), velocity.x(), velocity.y(), velocity.z());
    dBodySetAngularVel(bodies_.back(), spin.x(), spin.y(), spin.z());
  }

  /// A body whose centre of mass is `centre` from the joint at `top`, with the world's axes.
  void add(double mass, const Vec3& top, const Vec3& centre, const Mat3& i, bool is_joined) {
    const dBodyID above = bodies_.empty() ? nullptr : bodies_.back();
    const dBodyID body = dBodyCreate(world_.id);
    const Vec3 at = top + centre;
    dMass properties;
    dMassSetParameters(&properties, mass, 0, 0, 0, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2),
                       i(1, 2));
    dBodySetMass(body, &properties);
    dBodySetPosition(body, at.x(), at.y(), at.z());
    bodies_.push_back(body);
    if (!is_joined) return;
    const dJointID joint = dJointCreateBall(world_.id, nullptr);
    dJointAttach(joint, body, above);
    dJointSetBallAnchor(joint, top.x(), top.y(), top.z());
  }

  struct Spring {
    std::size_t rod = 0;
    dJointID motor = nullptr;
  };

  /// Of the bend between a rod and what is above it: two axes across them have stops at zero.
  void add_spring(std::size_t rod) {
    const dJointID motor = dJointCreateAMotor(world_.id, nullptr);
    dJointAttach(motor, bodies_[rod], rod > 0 ? bodies_[rod - 1] : nullptr);
    dJointSetAMotorMode(motor, dAMotorUser);
    dJointSetAMotorNumAxes(motor, 2);
    for (const int stop : {dParamLoStop, dParamHiStop, dParamLoStop2, dParamHiStop2}) {
      dJointSetAMotorParam(motor, stop, 0);
    }
    springs_.push_back({rod, motor});
  }

  Vec3 direction(std::size_t rod) const {
    const Vec3 along = rods_->rods()[rod].along.normalized();
    dVector3 now;
    dBodyVectorToWorld(bodies_[rod], along.x(), along.y(), along.z(), now);
    return eigen(now);
  }

  /// Lets a stop give way as a spring and a damper do at the end of a step of `dt` (ODE's manual,
  /// "How To Use ERP and CFM"). The moment of the spring is that of taut's own model at its angle
  /// a, 2 k tan(a/2) / cos^2(a/2), and so is that of the damper.
  void bend(const Spring& spring, double dt) {
    const Vec3 above = spring.rod > 0 ? direction(spring.rod - 1) : rods_->clamp();
    const Vec3 own = direction(spring.rod);
    const Vec3 across = above.cross(own);
    const double sine = across.norm(), angle = std::atan2(sine, above.dot(own));
    const Vec3 axis = sine > 0 ? Vec3(across / sine) : above.unitOrthogonal();
    const Vec3 other = axis.cross(above + own).normalized();
    dJointSetAMotorAxis(spring.motor, 0, 0, axis.x(), axis.y(), axis.z());
    dJointSetAMotorAxis(spring.motor, 1, 0, other.x(), other.y(), other.z());
    dJointSetAMotorAngle(spring.motor, 0, angle);
    dJointSetAMotorAngle(spring.motor, 1, 0);
    const double tangent = std::tan(angle / 2), steep = 1 + tangent * tangent;
    const double share = angle > 0 ? 2 * tangent * steep / angle : 1;
    const Rod& rod = rods_->rods()[spring.rod];
    const double pull = dt * share * rod.bending_stiffness;
    const auto set = [&](double damping, int erp, int cfm) {
      dJointSetAMotorParam(spring.motor, erp, pull / (pull + damping));
      dJointSetAMotorParam(spring.motor, cfm, 1 / (pull + damping));
    };
    set(steep * steep * rod.bending_damping, dParamStopERP, dParamStopCFM);
    set(rod.bending_damping, dParamStopERP2, dParamStopCFM2);
  }

  void step(double time, double dt) override {
    for (const Spring& spring : springs_) bend(spring, dt);
    const Vec3 g = gravity(time + dt / 2);
    dWorldSetGravity(world_.id, g.x(), g.y(), g.z());
    for (const Obstacle& obstacle : rods_->obstacles()) {
      if (obstacle.path) touch_->move(obstacle, rods_->motion(obstacle, world(), time));
    }
    if (touch_->any()) touch_->find(world_.id);
    world_.step(time, dt);
    touch_->forget();
  }

  void read(std::vector<Vec3>& ends, Quat& turn) override {
    dVector3 at;
    if (!hangs_) {
      dBodyGetRelPointPos(bodies_[0], upper_.x(), upper_.y(), upper_.z(), at);
      ends[0] = eigen(at);
    }
    for (std::size_t i = 0; i < lower_.size(); ++i) {
      dBodyGetRelPointPos(bodies_[i], lower_[i].x(), lower_[i].y(), lower_[i].z(), at);
      ends[i + 1] = eigen(at);
    }
    if (bodies_.size() > lower_.size()) {
      const dReal* q = dBodyGetQuaternion(bodies_.back());
      turn = Quat(q[0], q[1], q[2], q[3]);
    }
  }

  OdeWorld world_;
  std::vector<dBodyID> bodies_;  // the world owns them
  std::vector<Vec3> lower_;      // m, from each rod's centre of mass to its lower end
  bool hangs_ = true;
  Vec3 upper_ = Vec3::Zero();  // m, from the first rod's centre of mass to its upper end
  const Rods* rods_ = nullptr;
  std::vector<Spring> springs_;
  std::optional<OdeTouch> touch_{std::in_place};
};

}  // namespace

MethodInfo ode_method() {
  return {.name = "ode",
          .summary = "the Open Dynamics Engine: rigid bodies and ball joints",
          .settings = ode_settings(),
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<Ode>(settings);
          },
          .abilities = {kPlainFeatures | kMaterialFeatures | kTouched | Feature::body_contact |
                        Feature::body_pairs}};
}

}  // namespace taut::engines
