// What touches what in ODE: its collision spaces, and the contact joints that last a step.
#pragma once

#include <ode/ode.h>

#include <vector>

#include "sim/motion/types.h"
#include "sim/world/obstacle.h"

namespace taut::engines {

/// Balls and capsules of bodies, and the solids that they touch.
class OdeTouch {
 public:
  OdeTouch() = default;
  OdeTouch(const OdeTouch&) = delete;
  OdeTouch& operator=(const OdeTouch&) = delete;
  ~OdeTouch();

  /// `at` (m) is from the body's centre of mass.
  void add_ball(dBodyID body, double radius, const Vec3& at);
  /// With the body's axes as the world's.
  void add_capsule(dBodyID body, double radius, const Vec3& from, const Vec3& to);
  /// Kept; one that has a path is a kinematic body of the world.
  void add_solid(dWorldID world, const Obstacle& obstacle, const Pose& at);
  bool any() const { return !solids_of_.empty(); }
  /// Where it moves, its motion at the start of a step.
  void move(const Obstacle& obstacle, const FrameMotion& motion);

  /// Contact joints where anything is in a solid; those of the last step go.
  void find(dWorldID world);
  void forget() { dJointGroupEmpty(contacts_); }

 private:
  struct Solid {
    const Obstacle* obstacle = nullptr;
    dGeomID geometry = nullptr;
    dBodyID body = nullptr;  // null: it stands still
  };

  void touch(dGeomID a, dGeomID b);

  dSpaceID bodies_ = dSimpleSpaceCreate(nullptr), solids_ = dSimpleSpaceCreate(nullptr);
  dJointGroupID contacts_ = dJointGroupCreate(0);
  dWorldID world_ = nullptr;
  std::vector<Solid> solids_of_;
};

}  // namespace taut::engines
