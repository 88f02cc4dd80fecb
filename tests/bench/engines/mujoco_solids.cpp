#include "tests/bench/engines/mujoco_solids.h"

#include <algorithm>
#include <stdexcept>

#include "tests/bench/engines/solids.h"

namespace taut::engines {
namespace {

constexpr double kHeavy = 1e6;  // kg, and kg m^2

void write(std::ostringstream& out, const Vec3& v) {
  out << v.x() << ' ' << v.y() << ' ' << v.z();
}

void write_place(std::ostringstream& out, const Pose& at) {
  out << " pos='";
  write(out, at.position);
  const Quat& turn = at.rotation;
  out << "' quat='" << turn.w() << ' ' << turn.x() << ' ' << turn.y() << ' ' << turn.z() << "'";
}

}  // namespace

void write_solid(std::ostringstream& out, const Obstacle& obstacle, const Pose& at,
                 const std::string& contact) {
  if (obstacle.restitution > 0) throw std::invalid_argument("MuJoCo is given no restitution");
  const Shape& shape = obstacle.shape;
  Pose place = obstacle.path ? Pose{} : at;  // of the shape
  if (obstacle.path) {
    out << "<body";
    write_place(out, at);
    out << "><freejoint/><inertial pos='0 0 0' mass='" << kHeavy << "' diaginertia='" << kHeavy
        << ' ' << kHeavy << ' ' << kHeavy << "'/>";
  }
  place.rotation = with_axis_along_z(shape, place.rotation);
  constexpr const char* kTypes[] = {"plane", "sphere", "capsule", "cylinder", "box"};
  out << "<geom type='" << kTypes[static_cast<int>(shape.kind)] << "'";
  write_place(out, place);
  out << " size='";
  switch (shape.kind) {
    case Shape::Kind::plane:
      out << "0 0 1";
      break;
    case Shape::Kind::sphere:
      out << shape.radius;
      break;
    case Shape::Kind::box:
      write(out, shape.size / 2);
      break;
    default:
      out << shape.radius << ' ' << shape.length / 2;
  }
  const bool slides = obstacle.kinetic_friction == 0;
  out << "' contype='1' conaffinity='0' condim='" << (slides ? 1 : 3) << "' friction='"
      << std::max(obstacle.kinetic_friction, 1e-5) << " 0 0' " << contact << "/>";
  if (obstacle.path) out << "</body>";
}

void lead(const mjModel& model, mjData& data, int body, const FrameMotion& motion,
          const Vec3& gravity) {
  mjtNum* place = data.qpos + model.jnt_qposadr[model.body_jntadr[body]];
  const Quat& turn = motion.rotation;
  const double rotation[] = {turn.w(), turn.x(), turn.y(), turn.z()};
  std::copy_n(motion.position.data(), 3, place);
  std::copy_n(rotation, 4, place + 3);
  const int dof = model.body_dofadr[body];
  Eigen::Map<Vec3> velocity(data.qvel + dof), spin(data.qvel + dof + 3);
  Eigen::Map<Vec3> force(data.qfrc_applied + dof), moment(data.qfrc_applied + dof + 3);
  velocity = motion.velocity;
  spin = turn.conjugate() * motion.spin;  // MuJoCo has it in the body's axes
  force = kHeavy * (motion.acceleration - gravity);
  moment = kHeavy * (turn.conjugate() * motion.spin_rate);
}

void write_ball(std::ostringstream& out, double radius, const Vec3& at,
                const std::string& contact) {
  out << "<geom type='sphere' size='" << radius << "' pos='";
  write(out, at);
  out << "' contype='0' conaffinity='1' condim='1' friction='0 0 0' " << contact << "/>";
}

void write_capsule(std::ostringstream& out, const BodyCapsule& capsule,
                   const std::string& contact) {
  if (capsule.from == capsule.to) return write_ball(out, capsule.radius, capsule.from, contact);
  out << "<geom type='capsule' size='" << capsule.radius << "' fromto='";
  write(out, capsule.from);
  out << ' ';
  write(out, capsule.to);
  out << "' contype='0' conaffinity='1' condim='1' friction='0 0 0' " << contact << "/>";
}

}  // namespace taut::engines
