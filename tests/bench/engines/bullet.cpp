// Bullet's btMultiBody: joint coordinates, Featherstone's algorithm, one spherical joint a rod.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include <Eigen/Eigenvalues>
#include <memory>
#include <span>

#include "sim/motion/rotation.h"
#include "tests/bench/engines/bullet_solid.h"
#include "tests/bench/engines/engine.h"

namespace taut::engines {
namespace {

class Bullet : public RodEngine {
 public:
  explicit Bullet(const Settings& settings)
      : RodEngine(number(settings, "step")), runge_kutta_(text(settings, "integrator") == "rk4") {
    world_.getSolverInfo().m_numIterations = static_cast<int>(number(settings, "iterations"));
  }
  ~Bullet() override {
    for (const auto& object : objects_) world_.removeCollisionObject(object.get());
    for (const BulletSolid& solid : solids_) world_.removeCollisionObject(solid.object.get());
  }

 private:
  void build(const Rods& rods) override {
    hangs_ = rods.hangs();
    first_ = hangs_ ? 0 : 1;  // rod that is a link; the one before, if any, is the base
    const auto links = static_cast<int>(rods.rods().size()) - first_ + (rods.load() ? 1 : 0);
    const Rod& top = rods.rods()[0];
    constexpr bool kCanSleep = false;
    body_ = hangs_ ? std::make_unique<btMultiBody>(links, 0, btVector3(0, 0, 0), true, kCanSleep)
                   : std::make_unique<btMultiBody>(
                         links, top.mass, btVector3(1, 1, 1) * top.inertia, false, kCanSleep);
    Vec3 from = Vec3::Zero();  // of the joint, from the centre of mass above
    int i = -first_;
    for (const Rod& rod : rods.rods()) {
      const Vec3 centre = rod.centre * rod.along;
      if (i >= 0) {
        body_->setupSpherical(i, rod.mass, btVector3(1, 1, 1) * rod.inertia, i - 1,
                              btQuaternion::getIdentity(), bullet(from), bullet(centre), true);
      }
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
    bends_ = rods.resist_bending();
    edges_.resize(rods.rods().size());
    spins_.resize(rods.rods().size());
    turns_.resize(rods.rods().size());
    world_.addMultiBody(body_.get());
    upper_ = -top.centre * top.along;
    for (const Bead& bead : rods.beads()) add(bead, rods.radius());
    rods_ = &rods;
    if (rods.load() && rods.load()->capsule.touches()) add(rods.load()->capsule, i);
    for (const Obstacle& obstacle : rods.obstacles()) {
      solids_.push_back(make_bullet_solid(obstacle));
      place_bullet_solid(obstacle, rods.motion(obstacle, world(), world().time), 0,
                         *solids_.back().object);
      world_.addCollisionObject(solids_.back().object.get(), kSolids, kBeads);
    }
    body_->forwardKinematics(rotations_, origins_);
    body_->updateCollisionObjectWorldTransforms(rotations_, origins_);
  }

  // Friction and restitution of a pair are the products of both things' own: here they are 1.
  static constexpr int kSolids = 1, kBeads = 2;

  void open_compound(int link) {
    shapes_.push_back(std::make_unique<btCompoundShape>());
    auto collider = std::make_unique<btMultiBodyLinkCollider>(body_.get(), link);
    collider->setCollisionShape(shapes_.back().get());
    collider->setFriction(1);
    collider->setRestitution(1);
    if (link < 0) {
      body_->setBaseCollider(collider.get());
    } else {
      body_->getLink(link).m_collider = collider.get();
    }
    world_.addCollisionObject(collider.get(), kBeads, kSolids);
    objects_.push_back(std::move(collider));
    compound_ = static_cast<btCompoundShape*>(shapes_.back().get());
    last_link_ = link;
  }

  /// A rod's beads are one shape: the first free rod has two.
  void add(const Bead& bead, double radius) {
    const int link = static_cast<int>(bead.rod) - first_;
    if (link != last_link_) open_compound(link);
    shapes_.push_back(std::make_unique<btSphereShape>(radius));
    compound_->addChildShape(btTransform(btQuaternion::getIdentity(), bullet(bead.at)),
                             shapes_.back().get());
  }

  /// The load's, whose link is the last.
  void add(const BodyCapsule& capsule, int link) {
    const Vec3 along = capsule.to - capsule.from;
    const Vec3 middle = (capsule.from + capsule.to) / 2 - rods_->load()->centre;
    const Vec3 axis = along.isZero(0) ? Vec3::UnitY() : Vec3(along.normalized());
    const Quat turn = axes_.conjugate() * rotation_between(Vec3::UnitY(), axis);
    open_compound(link);
    shapes_.push_back(std::make_unique<btCapsuleShape>(capsule.radius, along.norm()));
    compound_->addChildShape(btTransform(bullet(turn), bullet(axes_.conjugate() * middle)),
                             shapes_.back().get());
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
    const Rod& top = rods.rods()[0];
    Vec3 above = Vec3::Zero();
    if (!hangs_) {
      const Vec3 centre = top.centre * top.along;
      body_->setBasePos(bullet(centre));
      body_->setBaseVel(bullet(rods.velocity() + top.spin.cross(centre)));
      body_->setBaseOmega(bullet(top.spin));
      above = top.spin;
    }
    int i = 0;
    const auto set = [&](const Vec3& spin, const Quat& to_link) {
      const btVector3 turn = bullet(to_link * (spin - above));
      const btScalar rates[] = {turn.x(), turn.y(), turn.z()};
      body_->setJointVelMultiDof(i++, rates);
      above = spin;
    };
    for (const Rod& rod : std::span(rods.rods()).subspan(static_cast<std::size_t>(first_))) {
      set(rod.spin, Quat::Identity());
    }
    if (rods.load()) set(rods.load()->spin, axes_.conjugate());
  }

  /// The moments in the joints, for Bullet's have no springs; in the axes of the rod below.
  void bend() {
    Quat turn = Quat::Identity();
    Vec3 spin = Vec3::Zero();
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      const int link = static_cast<int>(i) - first_;
      if (link < 0) {
        turn = eigen(body_->getWorldToBaseRot()).conjugate();
        spin = eigen(body_->getBaseOmega());
      } else {
        turn = turn * eigen(body_->getParentToLocalRot(link)).conjugate();
        const btScalar* rate = body_->getJointVelMultiDof(link);
        spin += turn * Vec3(rate[0], rate[1], rate[2]);
      }
      turns_[i] = turn;
      edges_[i] = turn * rods_->rods()[i].along;
      spins_[i] = spin;
    }
    rods_->bend(edges_, spins_, moments_);
    for (std::size_t i = 0; i < moments_.size(); ++i) {
      const int link = static_cast<int>(i) - first_;
      if (link < 0) {
        body_->addBaseTorque(bullet(moments_[i]));
      } else {
        const Vec3 moment = turns_[i].conjugate() * moments_[i];
        body_->addJointTorqueMultiDof(link, moment.data());
      }
    }
  }

  void step(double time, double dt) override {
    if (bends_) bend();
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const Obstacle& obstacle = rods_->obstacles()[i];
      if (!obstacle.path) continue;
      place_bullet_solid(obstacle, rods_->motion(obstacle, world(), time), dt, *solids_[i].object);
    }
    world_.setGravity(bullet(gravity(time + dt / 2)));
    constexpr int kAsGiven = 0;  // one step of dt, none of Bullet's own choice
    world_.stepSimulation(dt, kAsGiven);
  }

  void read(std::vector<Vec3>& ends, Quat& turn) override {
    body_->forwardKinematics(rotations_, origins_);
    const btTransform base(body_->getWorldToBaseRot().inverse(), body_->getBasePos());
    if (!hangs_) ends[0] = eigen(base * bullet(upper_));
    for (std::size_t i = 0; i < lower_.size(); ++i) {
      const int link = static_cast<int>(i) - first_;
      const btTransform& at = link < 0 ? base : body_->getLink(link).m_cachedWorldTransform;
      ends[i + 1] = eigen(at * bullet(lower_[i]));
    }
    if (!loaded_) return;
    const int load = static_cast<int>(lower_.size()) - first_;
    const btTransform& at = body_->getLink(load).m_cachedWorldTransform;
    turn = (eigen(at.getRotation()) * axes_.conjugate()).normalized();
  }

  bool runge_kutta_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  // The world owns none of these.
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> objects_;
  std::vector<BulletSolid> solids_;  // of the rods' obstacles
  std::unique_ptr<btMultiBody> body_;
  const Rods* rods_ = nullptr;
  bool bends_ = false;
  std::vector<Vec3> edges_, spins_, moments_;  // m, rad/s, N m
  std::vector<Quat> turns_;                    // of the rods since the start
  btCompoundShape* compound_ = nullptr;        // the last rod's beads
  int first_ = 0, last_link_ = -2;
  bool hangs_ = true;
  Vec3 upper_ = Vec3::Zero();  // m, from the first rod's centre of mass to its upper end
  std::vector<Vec3> lower_;    // m, from each rod's centre of mass to its lower end
  bool loaded_ = false;
  Quat axes_ = Quat::Identity();  // of the load's principal moments, at the start
  btAlignedObjectArray<btQuaternion> rotations_;
  btAlignedObjectArray<btVector3> origins_;
};

}  // namespace

MethodInfo bullet_method() {
  return {.name = "bullet",
          .summary = "Bullet's btMultiBody: joint coordinates by Featherstone's algorithm",
          .settings = {step_setting({}, 20),
                       {.name = "integrator",
                        .meaning = "Semi-implicit Euler or the classical Runge-Kutta method.",
                        .unit = "",
                        .fallback = std::string("euler"),
                        .choices = {"euler", "rk4"},
                        .sweep = {std::string("euler"), std::string("rk4")}},
                       {.name = "iterations",
                        .meaning = "Of the solver of contacts.",
                        .unit = "1",
                        .fallback = 50.0,
                        .maximum = 1e6,
                        .whole = true,
                        .sweep = {}}},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<Bullet>(settings);
          },
          .abilities = {kPlainFeatures | kMaterialFeatures | kTouched | Feature::body_contact |
                        Feature::body_pairs}};
}

}  // namespace taut::engines
