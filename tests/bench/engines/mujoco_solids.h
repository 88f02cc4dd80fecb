// Obstacles in MuJoCo's language, and those that move.
#pragma once

#include <mujoco/mujoco.h>

#include <sstream>
#include <string>

#include "sim/motion/types.h"
#include "sim/world/body.h"
#include "sim/world/obstacle.h"

namespace taut::engines {

/// Writes the obstacle at its place. One that has a path is a body of its own, free and so heavy
/// that nothing it meets moves it: MuJoCo's bodies that are led ("mocap") stand still to a contact.
/// `contact` holds MuJoCo's parameters of contacts. Throws std::invalid_argument where it has
/// restitution, which MuJoCo has not.
void write_solid(std::ostringstream& out, const Obstacle& obstacle, const Pose& at,
                 const std::string& contact);
/// Leads the free body that has the number through a step that starts with that motion, where it
/// feels `gravity` (m/s^2).
void lead(const mjModel& model, mjData& data, int body, const FrameMotion& motion,
          const Vec3& gravity);

/// What touches solids and nothing else: a ball at a place in its body, or a capsule.
void write_ball(std::ostringstream& out, double radius, const Vec3& at, const std::string& contact);
void write_capsule(std::ostringstream& out, const BodyCapsule& capsule, const std::string& contact);

}  // namespace taut::engines
