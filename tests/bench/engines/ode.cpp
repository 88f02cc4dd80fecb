// The Open Dynamics Engine: every rod six coordinates, held together by ball joints.
#include <ode/ode.h>

#include <vector>

#include "tests/bench/engines/engine.h"

namespace taut::engines {
namespace {

Vec3 eigen(const dVector3 v) {
  return {v[0], v[1], v[2]};
}

/// The library, as long as the program runs.
struct Library {
  Library() { dInitODE2(0); }
  ~Library() { dCloseODE(); }
};

class Ode : public Engine {
 public:
  explicit Ode(const Settings& settings)
      : Engine(number(settings, "step")),
        iterations_(static_cast<int>(number(settings, "iterations"))) {
    static const Library library;
    world_ = dWorldCreate();
    dWorldSetERP(world_, number(settings, "erp"));
    dWorldSetCFM(world_, 0);
    if (iterations_ > 0) dWorldSetQuickStepNumIterations(world_, iterations_);
  }
  ~Ode() override { dWorldDestroy(world_); }

 private:
  void build(const Rods& rods) override {
    Vec3 top = Vec3::Zero(), moves = Vec3::Zero();  // m, m/s
    for (const Rod& rod : rods.rods()) {
      const Vec3 centre = rod.centre * rod.along;
      add(rod.mass, top, centre, rod.inertia * Mat3::Identity());
      set_in_motion(moves + rod.spin.cross(centre), rod.spin);
      lower_.push_back(rod.along - centre);
      top += rod.along;
      moves += rod.spin.cross(rod.along);
    }
    if (const auto& load = rods.load()) {
      add(load->mass, top, load->centre, load->inertia);
      set_in_motion(moves + load->spin.cross(load->centre), load->spin);
    }
  }

  /// The body that was added last.
  void set_in_motion(const Vec3& velocity, const Vec3& spin) {
    dBodySetLinearVel(bodies_.back(), velocity.x(), velocity.y(), velocity.z());
    dBodySetAngularVel(bodies_.back(), spin.x(), spin.y(), spin.z());
  }

  /// A body whose centre of mass is `centre` from the joint at `top`, with the world's axes.
  void add(double mass, const Vec3& top, const Vec3& centre, const Mat3& i) {
    const dBodyID above = bodies_.empty() ? nullptr : bodies_.back();
    const dBodyID body = dBodyCreate(world_);
    const Vec3 at = top + centre;
    dMass properties;
    dMassSetParameters(&properties, mass, 0, 0, 0, i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2),
                       i(1, 2));
    dBodySetMass(body, &properties);
    dBodySetPosition(body, at.x(), at.y(), at.z());
    const dJointID joint = dJointCreateBall(world_, nullptr);
    dJointAttach(joint, body, above);
    dJointSetBallAnchor(joint, top.x(), top.y(), top.z());
    bodies_.push_back(body);
  }

  void step(double time, double dt) override {
    const Vec3 g = gravity(time + dt / 2);
    dWorldSetGravity(world_, g.x(), g.y(), g.z());
    if (iterations_ > 0) {
      dWorldQuickStep(world_, dt);
    } else {
      dWorldStep(world_, dt);
    }
  }

  void read(std::vector<Vec3>& ends, Quat& turn) override {
    for (std::size_t i = 0; i < ends.size(); ++i) {
      dVector3 at;
      dBodyGetRelPointPos(bodies_[i], lower_[i].x(), lower_[i].y(), lower_[i].z(), at);
      ends[i] = eigen(at);
    }
    if (bodies_.size() > ends.size()) {
      const dReal* q = dBodyGetQuaternion(bodies_.back());
      turn = Quat(q[0], q[1], q[2], q[3]);
    }
  }

  int iterations_;
  dWorldID world_;
  std::vector<dBodyID> bodies_;  // the world owns them
  std::vector<Vec3> lower_;      // m, from each rod's centre of mass to its lower end
};

}  // namespace

MethodInfo ode_method() {
  return {.name = "ode",
          .summary = "the Open Dynamics Engine: rigid bodies and ball joints",
          .settings = {step_setting(false, 20),
                       {.name = "iterations",
                        .meaning = "Of QuickStep; zero solves all joints exactly.",
                        .unit = "1",
                        .fallback = 0.0,
                        .maximum = 1e6,
                        .whole = true,
                        .sweep = {0.0, 20.0, 200.0}},
                       {.name = "erp",
                        .meaning = "Share of a joint's gap that a step closes.",
                        .unit = "1",
                        .fallback = 0.2,
                        .maximum = 1,
                        .sweep = {0.2, 0.8}}},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<Ode>(settings);
          }};
}

}  // namespace taut::engines
