// Rigid bodies in trees of ball joints, for engines that people use. taut_rigid reads a model from
// its standard input, runs it by an engine, and prints the value of each row, a line each, and
// "cpu_s,SECONDS". Lines of the model, in SI units; a body is its number from 0, -1 is the world:
//
//   step DT                                    longest time step
//   gravity X Y Z
//   body MASS INERTIA*3 POSITION*3 ROTATION*4 VELOCITY*3 SPIN*3 PARENT JOINT*3
//                                              origin: centre of mass; axes: the principal ones; a
//                                              ball joint at the place JOINT holds it to PARENT, an
//                                              earlier body or the world; -2: it is free
//   loop A B PLACE*3                           a ball joint that closes a loop
//   spring A POINT*3 B POINT*3 LENGTH STIFFNESS DAMPING   points in the bodies' axes
//   shape BODY RADIUS FROM*3 TO*3              a capsule, or a ball if FROM is TO; in the body's
//   axes obstacle SIZE*3 POSITION*3 ROTATION*4      a box; of size 0, the plane across its y axis
//   contact BODY body|obstacle OTHER FRICTION RESTITUTION
//   row TIME place|velocity BODY POINT*3 AXIS
//   row TIME spin BODY AXIS | turn BODY COMPONENT | momentum AXIS | tension SPRING
//   row TIME energy | kinetic_energy | elastic_energy
//
// This file is C++17: Simbody's headers are no C++20.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace rigid {

using Vec3 = Eigen::Vector3d;
using Quat = Eigen::Quaterniond;

inline constexpr int kWorld = -1, kFree = -2;  // instead of a body

struct State {
  Vec3 position = Vec3::Zero();  // m, of the centre of mass
  Quat rotation = Quat::Identity();
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  // m/s and rad/s, in the world's axes

  Vec3 place(const Vec3& point) const { return position + rotation * point; }
  Vec3 velocity_of(const Vec3& point) const { return velocity + spin.cross(rotation * point); }
};

struct Body {
  double mass;   // kg
  Vec3 inertia;  // kg m^2
  State start;
  int parent;
  Vec3 joint;  // m, in the world
  Vec3 in_body(const Vec3& place) const {
    return start.rotation.conjugate() * (place - start.position);
  }
};

struct Loop {
  int a, b;
  Vec3 place;  // m, in the world
};

struct Spring {
  int a, b;
  Vec3 at_a, at_b;
  double length, stiffness, damping;  // m, N/m, N s/m
};

struct Shape {
  int body;
  double radius;  // m
  Vec3 from, to;
};

struct Obstacle {
  Vec3 size, position;  // m
  Quat rotation;
  bool is_plane() const { return size.isZero(0); }
};

struct Contact {
  int body, other;
  bool with_obstacle;
  double friction, restitution;
};

struct Row {
  double time;
  std::string what;
  int body = kWorld, index = 0;  // an axis, a component or a spring
  Vec3 point = Vec3::Zero();
};

struct Model {
  double step = 0;
  Vec3 gravity = Vec3::Zero();
  std::vector<Body> bodies;
  std::vector<Loop> loops;
  std::vector<Spring> springs;
  std::vector<Shape> shapes;
  std::vector<Obstacle> obstacles;
  std::vector<Contact> contacts;
  std::vector<Row> rows;

  State start(int body) const { return body == kWorld ? State{} : bodies[std::size_t(body)].start; }
};

/// An engine with nothing for a feature of the model throws this.
struct CannotExpress : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class Engine {
 public:
  virtual ~Engine() = default;
  /// Throws std::runtime_error where the engine gives up.
  virtual void step(double dt) = 0;
  virtual State state(int body) = 0;

  State state_of(int body) { return body == kWorld ? State{} : state(body); }
};

/// The force of a spring on its end b; `extension` (m) and `tension` (N) may be asked for.
Vec3 spring_force(const Spring& spring, Engine& engine, double* extension = nullptr,
                  double* tension = nullptr);

std::unique_ptr<Engine> make_bullet(const Model& model);
std::unique_ptr<Engine> make_mujoco(const Model& model);
std::unique_ptr<Engine> make_ode(const Model& model);
std::unique_ptr<Engine> make_simbody(const Model& model);

}  // namespace rigid
