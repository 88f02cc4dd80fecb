#include "tests/answers/engines/rigid.h"

#include <cmath>
#include <cstdio>
#include <ctime>
#include <iostream>
#include <limits>
#include <sstream>

namespace rigid {

Vec3 spring_force(const Spring& spring, Engine& engine, double* extension, double* tension) {
  const State a = engine.state_of(spring.a), b = engine.state_of(spring.b);
  const Vec3 along = b.place(spring.at_b) - a.place(spring.at_a);
  const double length = along.norm();
  const Vec3 to_b = along / length;
  const double rate = to_b.dot(b.velocity_of(spring.at_b) - a.velocity_of(spring.at_a));
  const double pull = spring.stiffness * (length - spring.length) + spring.damping * rate;
  if (extension) *extension = length - spring.length;
  if (tension) *tension = pull;
  return -pull * to_b;
}

namespace {

struct Reader {
  std::istringstream words;

  double number() {
    std::string word;
    words >> word;
    return std::stod(word);
  }
  int whole() { return static_cast<int>(number()); }
  Vec3 vector() {
    Vec3 v;
    for (double& x : v) x = number();
    return v;
  }
  Quat quaternion() {
    const double w = number();
    const Vec3 v = vector();
    return Quat(w, v.x(), v.y(), v.z()).normalized();
  }
};

Row read_row(Reader& in) {
  Row row{in.number(), {}};
  in.words >> row.what;
  if (row.what == "place" || row.what == "velocity") {
    row.body = in.whole();
    row.point = in.vector();
  } else if (row.what == "spin" || row.what == "turn") {
    row.body = in.whole();
  }
  if (row.what.find("energy") == std::string::npos) row.index = in.whole();
  return row;
}

Body read_body(Reader& in) {
  Body body{};
  body.mass = in.number();
  body.inertia = in.vector();
  body.start.position = in.vector();
  body.start.rotation = in.quaternion();
  body.start.velocity = in.vector();
  body.start.spin = in.vector();
  body.parent = in.whole();
  body.joint = in.vector();
  return body;
}

Model read_model(std::istream& from) {
  Model model;
  for (std::string line; std::getline(from, line);) {
    Reader in{std::istringstream(line)};
    std::string kind;
    in.words >> kind;
    if (kind == "step") {
      model.step = in.number();
    } else if (kind == "gravity") {
      model.gravity = in.vector();
    } else if (kind == "body") {
      model.bodies.push_back(read_body(in));
    } else if (kind == "loop") {
      const int a = in.whole(), b = in.whole();
      model.loops.push_back({a, b, in.vector()});
    } else if (kind == "spring") {
      Spring spring{};
      spring.a = in.whole();
      spring.at_a = in.vector();
      spring.b = in.whole();
      spring.at_b = in.vector();
      spring.length = in.number();
      spring.stiffness = in.number();
      spring.damping = in.number();
      model.springs.push_back(spring);
    } else if (kind == "shape") {
      Shape shape{in.whole(), in.number(), {}, {}};
      shape.from = in.vector();
      shape.to = in.vector();
      model.shapes.push_back(shape);
    } else if (kind == "obstacle") {
      Obstacle obstacle{in.vector(), in.vector(), {}};
      obstacle.rotation = in.quaternion();
      model.obstacles.push_back(obstacle);
    } else if (kind == "contact") {
      Contact contact{in.whole(), 0, false, 0, 0};
      std::string with;
      in.words >> with;
      contact.with_obstacle = with == "obstacle";
      contact.other = in.whole();
      contact.friction = in.number();
      contact.restitution = in.number();
      model.contacts.push_back(contact);
    } else if (kind == "row") {
      model.rows.push_back(read_row(in));
    } else {
      throw std::invalid_argument(kind);
    }
  }
  return model;
}

double energy(const Model& model, Engine& engine, bool kinetic, bool potential, bool elastic) {
  double sum = 0;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    const State now = engine.state(static_cast<int>(i));
    const Vec3 spin = now.rotation.conjugate() * now.spin;
    if (kinetic) {
      sum += body.mass / 2 * now.velocity.squaredNorm() +
             body.inertia.dot(spin.cwiseProduct(spin)) / 2;
    }
    if (potential) sum -= body.mass * model.gravity.dot(now.position);
  }
  for (const Spring& spring : model.springs) {
    double extension = 0;
    spring_force(spring, engine, &extension);
    if (elastic) sum += spring.stiffness / 2 * extension * extension;
  }
  return sum;
}

double value(const Model& model, Engine& engine, const Row& row, const std::vector<Quat>& turns) {
  const State now = engine.state_of(row.body);
  if (row.what == "place") return now.place(row.point)[row.index];
  if (row.what == "velocity") return now.velocity_of(row.point)[row.index];
  if (row.what == "spin") return now.spin[row.index];
  if (row.what == "turn") {
    const Quat& turn = turns[static_cast<std::size_t>(row.body)];
    return row.index == 0 ? turn.w() : turn.vec()[row.index - 1];
  }
  if (row.what == "tension") {
    double tension = 0;
    spring_force(model.springs[static_cast<std::size_t>(row.index)], engine, nullptr, &tension);
    return tension;
  }
  if (row.what == "momentum") {
    double sum = 0;
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      sum += model.bodies[i].mass * engine.state(static_cast<int>(i)).velocity[row.index];
    }
    return sum;
  }
  if (row.what == "kinetic_energy") return energy(model, engine, true, false, false);
  if (row.what == "elastic_energy") return energy(model, engine, false, false, true);
  return energy(model, engine, true, true, true);
}

/// Quaternions q and -q are one rotation. Rows want the one that follows from the start without a
/// jump.
class Turns {
 public:
  explicit Turns(const Model& model) {
    for (const Body& body : model.bodies) turns.push_back(body.start.rotation);
    for (const Row& row : model.rows) wanted_ |= row.what == "turn";
  }
  void follow(Engine& engine) {
    if (!wanted_) return;
    for (std::size_t i = 0; i < turns.size(); ++i) {
      Quat now = engine.state(static_cast<int>(i)).rotation;
      if (now.dot(turns[i]) < 0) now.coeffs() = -now.coeffs();
      turns[i] = now;
    }
  }
  std::vector<Quat> turns;

 private:
  bool wanted_ = false;
};

double cpu_time() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void run(const Model& model, Engine& engine) {
  Turns turns(model);
  double now = 0, cpu = 0;
  bool has_failed = false;
  for (const Row& row : model.rows) {
    const double begun = cpu_time(), left = row.time - now;
    if (left > 0 && !has_failed) {
      constexpr double kRounding = 1e-9;  // of a step
      const double count = std::max(1.0, std::ceil(left / model.step - kRounding));
      try {
        for (double i = 0; i < count; ++i) {
          engine.step(left / count);
          turns.follow(engine);
        }
      } catch (const std::runtime_error& error) {
        std::cerr << error.what() << '\n';
        has_failed = true;
      }
      now = row.time;
    }
    cpu += cpu_time() - begun;
    const double told = has_failed ? std::numeric_limits<double>::quiet_NaN()
                                   : value(model, engine, row, turns.turns);
    if (std::isfinite(told)) {
      std::printf("%.17g\n", told);
    } else {
      std::printf("nan\n");
    }
  }
  std::printf("cpu_s,%.6g\n", cpu);
}

struct Known {
  const char *name, *package;
  std::unique_ptr<Engine> (*make)(const Model&);
};

#ifndef RIGID_BULLET
constexpr auto make_bullet = nullptr;
#endif
#ifndef RIGID_MUJOCO
constexpr auto make_mujoco = nullptr;
#endif
#ifndef RIGID_ODE
constexpr auto make_ode = nullptr;
#endif
#ifndef RIGID_SIMBODY
constexpr auto make_simbody = nullptr;
#endif

constexpr Known kKnown[] = {{"bullet", "libbullet-dev", make_bullet},
                            {"mujoco", "libmujoco-dev", make_mujoco},
                            {"ode", "libode-dev", make_ode},
                            {"simbody", "libsimbody-dev", make_simbody}};

int main(const std::string& name) {
  for (const Known& known : kKnown) {
    if (name != known.name) continue;
    if (!known.make) {
      std::cerr << "taut_rigid: built without " << name << ": install " << known.package
                << " and build it again\n";
      return 1;
    }
    try {
      const Model model = read_model(std::cin);
      run(model, *known.make(model));
      return 0;
    } catch (const CannotExpress& reason) {
      std::cout << "cannot express: " << reason.what() << '\n';
      return 0;
    } catch (const std::exception& error) {
      std::cerr << "taut_rigid: " << error.what() << '\n';
      return 1;
    }
  }
  std::cerr << "usage: taut_rigid bullet|mujoco|ode|simbody < MODEL\n";
  return 2;
}

}  // namespace
}  // namespace rigid

int main(int argc, char** argv) {
  return rigid::main(argc == 2 ? argv[1] : "");
}
