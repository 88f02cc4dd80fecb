// Bullet's btMultiBody: joint coordinates by Featherstone's algorithm; loops and contacts by
// sequential impulses.
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <map>

#include "tests/answers/engines/rigid.h"

namespace rigid {
namespace {

btVector3 bullet(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}
btQuaternion bullet(const Quat& q) {
  return {q.x(), q.y(), q.z(), q.w()};
}
Vec3 eigen(const btVector3& v) {
  return {v.x(), v.y(), v.z()};
}
Quat eigen(const btQuaternion& q) {
  return {q.w(), q.x(), q.y(), q.z()};
}

/// The contacts by the numbers of both things; those of obstacles follow those of bodies.
using Laws = std::map<std::pair<int, int>, const Contact*>;
Laws laws;  // Bullet's callbacks are global

const Contact* law_of(const btCollisionObject* a, const btCollisionObject* b) {
  const auto found = laws.find(std::minmax({a->getUserIndex(), b->getUserIndex()}));
  return found == laws.end() ? nullptr : found->second;
}

struct Filter final : btOverlapFilterCallback {
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    return law_of(static_cast<btCollisionObject*>(a->m_clientObject),
                  static_cast<btCollisionObject*>(b->m_clientObject)) != nullptr;
  }
};

class Bullet final : public Engine {
 public:
  explicit Bullet(const Model& model) : model_(model) {
    world_.setGravity(bullet(model.gravity));
    btContactSolverInfo& info = world_.getSolverInfo();
    info.m_numIterations = 1000;
    info.m_leastSquaresResidualThreshold = 1e-20;
    info.m_restitutionVelocityThreshold = 0;
    info.m_globalCfm = 0;
    info.m_erp2 = 0;  // it would push apart what overlaps, with a velocity that stays
    add_trees();
    for (const Loop& loop : model.loops) add(loop);
    set_contacts();
    for (const auto& tree : trees_) world_.addMultiBody(tree.get());
    // Its Runge-Kutta knows neither contacts nor loops, and keeps forces as they were at the start.
    const bool is_alone = model.loops.empty() && model.contacts.empty() && model.springs.empty();
    for (const auto& tree : trees_) {
      tree->useRK4Integration(is_alone);
      tree->forwardKinematics(rotations_, origins_);
      tree->updateCollisionObjectWorldTransforms(rotations_, origins_);
    }
    add_shapes();
  }
  ~Bullet() override {
    for (const auto& loop : loops_) world_.removeMultiBodyConstraint(loop.get());
    for (const auto& object : objects_) world_.removeCollisionObject(object.get());
    for (const auto& tree : trees_) world_.removeMultiBody(tree.get());
  }

  void step(double dt) override {
    for (const Spring& spring : model_.springs) {
      const Vec3 force = spring_force(spring, *this);
      push(spring.b, spring.at_b, force);
      push(spring.a, spring.at_a, -force);
    }
    constexpr int kAsGiven = 0;  // one step of dt, none of Bullet's own choice
    world_.stepSimulation(dt, kAsGiven);
    is_known_ = false;
  }

  State state(int body) override {
    if (!is_known_) read();
    return states_[static_cast<std::size_t>(body)];
  }

 private:
  struct Place {
    btMultiBody* tree;
    int link;  // -1: the base
  };

  Place place(int body) const { return places_[static_cast<std::size_t>(body)]; }

  static Vec3 point(const Model& model, int body, const Vec3& at) {
    return body < 0 ? at : model.bodies[static_cast<std::size_t>(body)].in_body(at);
  }

  /// The number of the tree of each body. The bodies of a tree are not in a row.
  std::vector<std::size_t> tree_of_bodies() const {
    std::vector<std::size_t> trees;
    std::size_t count = 0;
    for (const Body& body : model_.bodies) {
      trees.push_back(body.parent < 0 ? count++ : trees[static_cast<std::size_t>(body.parent)]);
    }
    return trees;
  }

  void add_trees() {
    const std::vector<std::size_t> trees = tree_of_bodies();
    std::vector<int> links;
    for (std::size_t i = 0; i < trees.size(); ++i) {
      if (model_.bodies[i].parent < 0) links.push_back(model_.bodies[i].parent == kFree ? -1 : 0);
      ++links[trees[i]];
    }
    std::vector<int> next;
    for (std::size_t i = 0; i < trees.size(); ++i) {
      const Body& body = model_.bodies[i];
      const bool is_free = body.parent == kFree;
      constexpr bool kCanSleep = false, kNoParentCollision = true;
      if (body.parent < 0) {
        trees_.push_back(std::make_unique<btMultiBody>(links[trees[i]], is_free ? body.mass : 0,
                                                       bullet(body.inertia), !is_free, kCanSleep));
        btMultiBody& tree = *trees_.back();
        tree.setLinearDamping(0);
        tree.setAngularDamping(0);
        tree.setMaxCoordinateVelocity(1e9);
        next.push_back(0);
      }
      btMultiBody* tree = trees_[trees[i]].get();
      places_.push_back({tree, is_free ? -1 : next[trees[i]]++});
      if (is_free) continue;
      const State parent = model_.start(body.parent);
      tree->setupSpherical(places_.back().link, body.mass, bullet(body.inertia),
                           body.parent < 0 ? -1 : place(body.parent).link,
                           bullet(body.start.rotation.conjugate() * parent.rotation),
                           bullet(point(model_, body.parent, body.joint)),
                           bullet(Vec3(-body.in_body(body.joint))), kNoParentCollision);
    }
    for (const auto& tree : trees_) tree->finalizeMultiDof();
    for (std::size_t i = 0; i < trees.size(); ++i) {
      const Body& body = model_.bodies[i];
      if (body.parent == kFree) {
        btMultiBody& tree = *places_[i].tree;
        tree.setBasePos(bullet(body.start.position));
        tree.setWorldToBaseRot(bullet(body.start.rotation.conjugate()));
        tree.setBaseVel(bullet(body.start.velocity));
        tree.setBaseOmega(bullet(body.start.spin));
        continue;
      }
      const Vec3 turn =
          body.start.rotation.conjugate() * (body.start.spin - model_.start(body.parent).spin);
      const btScalar rates[] = {turn.x(), turn.y(), turn.z()};
      places_[i].tree->setJointVelMultiDof(places_[i].link, rates);
    }
  }

  void add(const Loop& loop) {
    const int a = loop.a < 0 ? loop.b : loop.a, b = loop.a < 0 ? loop.a : loop.b;
    const btVector3 at_a = bullet(point(model_, a, loop.place)),
                    at_b = bullet(point(model_, b, loop.place));
    if (b < 0) {
      loops_.push_back(std::make_unique<btMultiBodyPoint2Point>(
          place(a).tree, place(a).link, &btTypedConstraint::getFixedBody(), at_a, at_b));
    } else {
      loops_.push_back(std::make_unique<btMultiBodyPoint2Point>(
          place(a).tree, place(a).link, place(b).tree, place(b).link, at_a, at_b));
    }
    loops_.back()->setMaxAppliedImpulse(1e9);
    world_.addMultiBodyConstraint(loops_.back().get());
  }

  static bool throws_back(int number) {
    return std::any_of(laws.begin(), laws.end(), [&](const auto& one) {
      const auto& [things, law] = one;
      return law->restitution > 0 && (things.first == number || things.second == number);
    });
  }

  void set_contacts() {
    laws.clear();
    const int bodies = static_cast<int>(model_.bodies.size());
    for (const Contact& contact : model_.contacts) {
      laws[std::minmax(contact.body, contact.other + (contact.with_obstacle ? bodies : 0))] =
          &contact;
    }
    gCalculateCombinedFrictionCallback = [](const btCollisionObject* a,
                                            const btCollisionObject* b) {
      const Contact* law = law_of(a, b);
      return law ? law->friction : 0;
    };
    gCalculateCombinedRestitutionCallback = [](const btCollisionObject* a,
                                               const btCollisionObject* b) {
      const Contact* law = law_of(a, b);
      return law ? law->restitution : 0;
    };
    broadphase_.getOverlappingPairCache()->setOverlapFilterCallback(&filter_);
  }

  void add(std::unique_ptr<btCollisionObject> object, btCollisionShape* shape, int number) {
    object->setCollisionShape(shape);
    object->setUserIndex(number);
    // It would stop what is about to touch before it does, and with that take from its rebound.
    if (throws_back(number)) object->setContactProcessingThreshold(0);
    world_.addCollisionObject(object.get());
    objects_.push_back(std::move(object));
  }

  void add_shapes() {
    for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
      auto all = std::make_unique<btCompoundShape>();
      for (const Shape& shape : model_.shapes) {
        if (shape.body == static_cast<int>(i)) add(shape, *all);
      }
      // Bullet solves loops only of bodies that have shapes; nothing touches this one.
      constexpr double kTiny = 1e-6;  // m
      if (all->getNumChildShapes() == 0) {
        if (model_.loops.empty()) continue;
        add({static_cast<int>(i), kTiny, Vec3::Zero(), Vec3::Zero()}, *all);
      }
      const Place at = places_[i];
      auto collider = std::make_unique<btMultiBodyLinkCollider>(at.tree, at.link);
      const State& start = model_.bodies[i].start;
      collider->setWorldTransform(btTransform(bullet(start.rotation), bullet(start.position)));
      if (at.link < 0) {
        at.tree->setBaseCollider(collider.get());
      } else {
        at.tree->getLink(at.link).m_collider = collider.get();
      }
      add(std::move(collider), all.get(), static_cast<int>(i));
      shapes_.push_back(std::move(all));
    }
    for (std::size_t i = 0; i < model_.obstacles.size(); ++i) {
      const Obstacle& obstacle = model_.obstacles[i];
      if (obstacle.is_plane()) {
        shapes_.push_back(std::make_unique<btStaticPlaneShape>(btVector3(0, 1, 0), 0));
      } else {
        shapes_.push_back(std::make_unique<btBoxShape>(bullet(Vec3(obstacle.size / 2))));
      }
      auto object = std::make_unique<btCollisionObject>();
      object->setWorldTransform(btTransform(bullet(obstacle.rotation), bullet(obstacle.position)));
      add(std::move(object), shapes_.back().get(), static_cast<int>(model_.bodies.size() + i));
    }
  }

  void add(const Shape& shape, btCompoundShape& all) {
    const Vec3 along = shape.to - shape.from, middle = (shape.from + shape.to) / 2;
    Quat turn = Quat::Identity();
    if (along.isZero(0)) {
      shapes_.push_back(std::make_unique<btSphereShape>(shape.radius));
    } else {
      shapes_.push_back(std::make_unique<btCapsuleShape>(shape.radius, along.norm()));
      turn = Quat::FromTwoVectors(Vec3::UnitY(), along);
    }
    all.addChildShape(btTransform(bullet(turn), bullet(middle)), shapes_.back().get());
  }

  void push(int body, const Vec3& at, const Vec3& force) {
    if (body < 0) return;
    const Vec3 moment = (state(body).rotation * at).cross(force);
    const Place one = place(body);
    if (one.link < 0) {
      one.tree->addBaseForce(bullet(force));
      one.tree->addBaseTorque(bullet(moment));
    } else {
      one.tree->addLinkForce(one.link, bullet(force));
      one.tree->addLinkTorque(one.link, bullet(moment));
    }
  }

  void read() {
    for (const auto& tree : trees_) tree->forwardKinematics(rotations_, origins_);
    states_.resize(model_.bodies.size());
    for (std::size_t i = 0; i < states_.size(); ++i) {
      const Body& body = model_.bodies[i];
      const auto& [tree, link] = places_[i];
      State& now = states_[i];
      if (link < 0) {
        now = {eigen(tree->getBasePos()), eigen(tree->getWorldToBaseRot()).conjugate(),
               eigen(tree->getBaseVel()), eigen(tree->getBaseOmega())};
      } else {
        const btTransform& at = tree->getLink(link).m_cachedWorldTransform;
        now.position = eigen(at.getOrigin());
        now.rotation = eigen(at.getRotation());
        const btScalar* rate = tree->getJointVelMultiDof(link);
        const State parent =
            body.parent < 0 ? State{} : states_[static_cast<std::size_t>(body.parent)];
        const Vec3 joint = now.place(body.in_body(body.joint));
        now.spin = parent.spin + now.rotation * Vec3(rate[0], rate[1], rate[2]);
        now.velocity = parent.velocity + parent.spin.cross(joint - parent.position) +
                       now.spin.cross(now.position - joint);
      }
      if (!now.position.allFinite()) throw std::runtime_error("Bullet: not finite");
    }
    is_known_ = true;
  }

  const Model& model_;
  Filter filter_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  // The world owns none of these.
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btCollisionObject>> objects_;
  std::vector<std::unique_ptr<btMultiBody>> trees_;
  std::vector<std::unique_ptr<btMultiBodyPoint2Point>> loops_;
  std::vector<Place> places_;  // of the bodies
  std::vector<State> states_;
  bool is_known_ = false;
  btAlignedObjectArray<btQuaternion> rotations_;
  btAlignedObjectArray<btVector3> origins_;
};

}  // namespace

std::unique_ptr<Engine> make_bullet(const Model& model) {
  return std::make_unique<Bullet>(model);
}

}  // namespace rigid
