// Rigid bodies: mass properties from shapes, and the state of a body.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>

#include "sim/motion/path.h"
#include "sim/motion/types.h"

namespace taut {

/// Mass (kg), centre of mass (m) and inertia about that centre (kg m^2), in the body's own frame.
struct MassProperties {
  double mass = 0;
  Vec3 centre = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
};

/// A solid cylinder centred on the body's origin, its axis along y.
MassProperties solid_cylinder(double mass, double length, double diameter);
/// A solid ball centred on the body's origin.
MassProperties solid_sphere(double mass, double diameter);
/// A solid box centred on the body's origin, `size` along x, y, z.
MassProperties solid_box(double mass, const Vec3& size);
/// `body` with a point mass (kg) joined to it at `point` (m, body frame).
MassProperties with_point_mass(const MassProperties& body, double mass, const Vec3& point);

/// The middles of the faces of the box that has the body's mass and inertia (m, body frame); for a
/// stick, its ends are among them.
std::array<Vec3, 6> box_ends(const MassProperties& body);

enum class BodyModel {
  rigid,
  link,  // one more link of the connector that it hangs by, see BodiesAsLinks
};

/// The part of a free body that touches obstacles, and other bodies where a BodyPair says so: all
/// within `radius` (m) of a line between two points (m, body frame), which may coincide.
struct BodyCapsule {
  double radius = -1;  // negative: it touches nothing
  Vec3 from = Vec3::Zero(), to = Vec3::Zero();
  std::uint64_t category = 0;  // bits, of which an obstacle may ignore some

  bool touches() const { return radius >= 0; }
};

/// A rigid body. Driven bodies follow `path` (the body's `grip` point stays at the path's position,
/// its axes along the path's); free bodies move by their state.
struct Body {
  std::string name;
  BodyModel model = BodyModel::rigid;
  MassProperties mass_properties;    // with the particles that the body carries
  MassProperties bare;               // without them; set by finish(), changed by hand since
  std::shared_ptr<const Path> path;  // null: a free body
  Vec3 grip = Vec3::Zero();          // m, body frame; the point that the path carries
  BodyCapsule capsule;               // of no account where the body is driven

  // State of a free body; a driven body's is refreshed from its path by place_held().
  Vec3 position = Vec3::Zero();  // of the centre of mass, m
  Quat rotation = Quat::Identity();
  Vec3 velocity = Vec3::Zero();  // of the centre of mass, m/s
  Vec3 spin = Vec3::Zero();      // world axes, rad/s

  bool driven() const { return path != nullptr; }
  /// The body's own frame (origin where its shape says, not its centre of mass).
  Pose frame() const { return {position - rotation * mass_properties.centre, rotation}; }
  /// Position of a point given in the body's frame (m).
  Vec3 point(const Vec3& local) const {
    return position + rotation * (local - mass_properties.centre);
  }
  /// Velocity of a point given in the body's frame (m/s).
  Vec3 point_velocity(const Vec3& local) const {
    return velocity + spin.cross(rotation * (local - mass_properties.centre));
  }
  /// Inertia about the centre of mass in the world's axes (kg m^2).
  Mat3 world_inertia() const {
    const Mat3 r = rotation.toRotationMatrix();
    return r * mass_properties.inertia * r.transpose();
  }
};

/// Two free bodies whose capsules touch each other; others pass through.
struct BodyPair {
  std::size_t a = 0, b = 0;                          // of World::bodies
  double static_friction = 0, kinetic_friction = 0;  // Coulomb's coefficients
  double restitution = 0;                            // Newton's coefficient, 0 to 1
};

/// A connector whose beads touch the capsule of a free body; others pass through.
struct BeadPair {
  std::size_t connector = 0, body = 0;               // of World
  double static_friction = 0, kinetic_friction = 0;  // Coulomb's coefficients
  double restitution = 0;                            // Newton's coefficient, 0 to 1
};

/// Changes a body's mass properties; its frame and the velocities of its points stay.
void reweigh(Body& body, const MassProperties& properties);

/// The motion that a driven body's path gives its frame at `time`.
FrameMotion driven_frame(const Body& body, double time);

}  // namespace taut
