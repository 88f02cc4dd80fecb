// MuJoCo: joint coordinates and soft constraints, made as stiff as the step lets them be.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "tests/answers/engines/rigid.h"

namespace rigid {
namespace {

constexpr const char* kStiff = "solref='1e-9 1' solimp='0.9999 0.9999 1e-6'";

/// The damping ratio z of a spring and damper that can only push and throws back with a share of
/// the speed: the share is exp(-z/sqrt(1 - z^2) (pi - 2 asin z)).
double damping_ratio(double restitution) {
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double z = (low + high) / 2;
    const double share = std::exp(-z / std::sqrt(1 - z * z) * (M_PI - 2 * std::asin(z)));
    (share > restitution ? low : high) = z;
  }
  return (low + high) / 2;
}

/// MuJoCo has no restitution: it is made of a spring and a damper. Their frequency grows with the
/// root of the number of steps, so that a contact lasts ever shorter and for ever more steps.
std::string contact_law(const Contact& contact, double step) {
  std::ostringstream out;
  if (contact.restitution <= 0) {
    out << kStiff;
  } else {
    constexpr double kTime = 0.05;  // s
    const double frequency = 1 / std::sqrt(kTime * step),
                 ratio = damping_ratio(contact.restitution);
    out << "solref='" << -frequency * frequency << ' ' << -2 * ratio * frequency
        << "' solimp='0.9999 0.9999 1e-6'";
  }
  const bool slides = contact.friction == 0;
  out << " condim='" << (slides ? 1 : 3) << "' friction='" << contact.friction << ' '
      << contact.friction << " 0 0 0'";
  return out.str();
}

class MuJoCo final : public Engine {
 public:
  explicit MuJoCo(const Model& model) {
    mju_user_warning = [](const char*) {};  // it would keep a log in the working directory
    load(xml(model));
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      const Body& body = model.bodies[i];
      ids_.push_back(mj_name2id(model_, mjOBJ_BODY, std::to_string(i).c_str()));
      mjtNum* rate = data_->qvel + model_->body_dofadr[ids_.back()];
      Vec3 spin = body.start.spin;
      if (body.parent == kFree) {
        for (int k = 0; k < 3; ++k) *rate++ = body.start.velocity[k];
      } else {
        spin -= model.start(body.parent).spin;
      }
      spin = body.start.rotation.conjugate() * spin;  // in the body's axes
      for (int k = 0; k < 3; ++k) rate[k] = spin[k];
    }
  }
  ~MuJoCo() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }

  void step(double dt) override {
    model_->opt.timestep = dt;
    mj_step(model_, data_);
    is_known_ = false;
    // MuJoCo goes on from the start where it became unstable.
    for (const int trouble : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
      if (data_->warning[trouble].number > 0) throw std::runtime_error("MuJoCo: unstable");
    }
  }

  State state(int body) override {
    if (!is_known_) {
      mj_kinematics(model_, data_);
      mj_comPos(model_, data_);
      mj_comVel(model_, data_);
      is_known_ = true;
    }
    const int id = ids_[static_cast<std::size_t>(body)];
    const mjtNum *x = data_->xpos + 3 * id, *q = data_->xquat + 4 * id;
    mjtNum v[6];
    mj_objectVelocity(model_, data_, mjOBJ_XBODY, id, v, 0);
    return {Vec3(x[0], x[1], x[2]), Quat(q[0], q[1], q[2], q[3]), Vec3(v[3], v[4], v[5]),
            Vec3(v[0], v[1], v[2])};
  }

 private:
  static std::string text(const Vec3& v) {
    std::ostringstream out;
    out.precision(17);
    out << v.x() << ' ' << v.y() << ' ' << v.z();
    return out.str();
  }
  static std::string text(const Quat& q) {
    std::ostringstream out;
    out.precision(17);
    out << q.w() << ' ' << q.x() << ' ' << q.y() << ' ' << q.z();
    return out.str();
  }

  static std::string site(const std::string& name, const Vec3& at) {
    return "<site name='" + name + "' pos='" + text(at) + "'/>";
  }

  static void write_sites(std::ostream& out, const Model& model, int body) {
    for (std::size_t k = 0; k < model.springs.size(); ++k) {
      const Spring& spring = model.springs[k];
      const std::string name = std::to_string(k);
      if (spring.a == body) out << site("a" + name, spring.at_a);
      if (spring.b == body) out << site("b" + name, spring.at_b);
    }
  }

  /// A body and what hangs from it.
  static void write(std::ostream& out, const Model& model, int number) {
    const Body& body = model.bodies[static_cast<std::size_t>(number)];
    const State parent = body.parent < 0 ? State{} : model.start(body.parent);
    const Quat to_parent = parent.rotation.conjugate();
    out << "<body name='" << number << "' pos='"
        << text(Vec3(to_parent * (body.start.position - parent.position))) << "' quat='"
        << text(to_parent * body.start.rotation) << "'>";
    if (body.parent == kFree) {
      out << "<freejoint/>";
    } else {
      out << "<joint type='ball' pos='" << text(body.in_body(body.joint)) << "'/>";
    }
    out << "<inertial pos='0 0 0' mass='" << body.mass << "' diaginertia='" << text(body.inertia)
        << "'/>";
    for (std::size_t i = 0; i < model.shapes.size(); ++i) {
      const Shape& shape = model.shapes[i];
      if (shape.body != number) continue;
      out << "<geom name='s" << i << "' contype='0' conaffinity='0' size='" << shape.radius << "' ";
      if (shape.from == shape.to) {
        out << "type='sphere' pos='" << text(shape.from) << "'/>";
      } else {
        out << "type='capsule' fromto='" << text(shape.from) << ' ' << text(shape.to) << "'/>";
      }
    }
    write_sites(out, model, number);
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      if (model.bodies[i].parent == number) write(out, model, static_cast<int>(i));
    }
    out << "</body>";
  }

  static void write_pairs(std::ostream& out, const Model& model) {
    for (const Contact& contact : model.contacts) {
      for (std::size_t i = 0; i < model.shapes.size(); ++i) {
        if (model.shapes[i].body != contact.body) continue;
        const auto pair = [&](const std::string& other) {
          out << "<pair geom1='s" << i << "' geom2='" << other << "' "
              << contact_law(contact, model.step) << "/>";
        };
        if (contact.with_obstacle) {
          pair("o" + std::to_string(contact.other));
          continue;
        }
        for (std::size_t k = 0; k < model.shapes.size(); ++k) {
          if (model.shapes[k].body == contact.other) pair("s" + std::to_string(k));
        }
      }
    }
  }

  static std::string xml(const Model& model) {
    std::ostringstream out;
    out.precision(17);
    const char* integrator = model.contacts.empty() ? "RK4" : "Euler";
    out << "<mujoco><compiler inertiafromgeom='false' boundmass='0' boundinertia='0' "
           "balanceinertia='false'/><size nconmax='1000' njmax='3000'/><option integrator='"
        << integrator << "' timestep='" << model.step << "' gravity='" << text(model.gravity)
        << "' cone='elliptic' impratio='10' tolerance='1e-14' iterations='200'/><worldbody>";
    for (std::size_t i = 0; i < model.obstacles.size(); ++i) {
      const Obstacle& obstacle = model.obstacles[i];
      out << "<geom name='o" << i << "' contype='0' conaffinity='0' pos='"
          << text(obstacle.position);
      if (obstacle.is_plane()) {
        out << "' type='plane' size='0 0 1' zaxis='"
            << text(Vec3(obstacle.rotation * Vec3::UnitY())) << "'/>";
      } else {
        out << "' type='box' size='" << text(Vec3(obstacle.size / 2)) << "' quat='"
            << text(obstacle.rotation) << "'/>";
      }
    }
    write_sites(out, model, kWorld);
    for (std::size_t i = 0; i < model.bodies.size(); ++i) {
      if (model.bodies[i].parent < 0) write(out, model, static_cast<int>(i));
    }
    out << "</worldbody><contact>";
    write_pairs(out, model);
    out << "</contact><equality>";
    for (const Loop& loop : model.loops) {
      const bool swaps = loop.a < 0;
      const int one = swaps ? loop.b : loop.a, other = swaps ? loop.a : loop.b;
      out << "<connect body1='" << one << "' ";
      if (other >= 0) out << "body2='" << other << "' ";
      const Body& body = model.bodies[static_cast<std::size_t>(one)];
      out << "anchor='" << text(body.in_body(loop.place)) << "' " << kStiff << "/>";
    }
    out << "</equality><tendon>";
    for (std::size_t k = 0; k < model.springs.size(); ++k) {
      const Spring& spring = model.springs[k];
      out << "<spatial stiffness='" << spring.stiffness << "' damping='" << spring.damping
          << "' springlength='" << spring.length << "'><site site='a" << k << "'/><site site='b"
          << k << "'/></spatial>";
    }
    out << "</tendon></mujoco>";
    return out.str();
  }

  void load(const std::string& xml) {
    const auto files = std::make_unique<mjVFS>();
    mj_defaultVFS(files.get());
    constexpr const char* kName = "model.xml";
    mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()));
    std::memcpy(files->filedata[mj_findFileVFS(files.get(), kName)], xml.data(), xml.size());
    char error[500] = "";
    model_ = mj_loadXML(kName, files.get(), error, sizeof error);
    mj_deleteVFS(files.get());
    if (!model_) throw std::invalid_argument(std::string("MuJoCo: ") + error);
    data_ = mj_makeData(model_);
  }

  std::vector<int> ids_;  // of the model's bodies: MuJoCo sorts them another way
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  bool is_known_ = false;  // the state after the last step
};

}  // namespace

std::unique_ptr<Engine> make_mujoco(const Model& model) {
  return std::make_unique<MuJoCo>(model);
}

}  // namespace rigid
