// MuJoCo: joint coordinates, the composite rigid body algorithm, one ball joint a rod.
#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "tests/bench/engines/engine.h"

namespace taut::engines {
namespace {

/// The model in MuJoCo's own language. All bodies have the world's axes at the start.
std::string xml(const Rods& rods, const std::string& integrator) {
  std::ostringstream out;
  out.precision(17);
  const auto vector = [](const Vec3& v) {
    std::ostringstream text;
    text.precision(17);
    text << v.x() << ' ' << v.y() << ' ' << v.z();
    return text.str();
  };
  const auto open = [&](const Vec3& at) {
    out << "<body pos='" << vector(at) << "'><joint type='ball'/>";
  };
  // Nothing touches and nothing is limited: what looks for that is switched off.
  out << "<mujoco><compiler inertiafromgeom='false'/><option integrator='" << integrator
      << "'><flag constraint='disable' contact='disable' limit='disable' equality='disable' "
         "frictionloss='disable' warmstart='disable' sensor='disable'/></option><worldbody>";
  Vec3 at = Vec3::Zero();
  for (const Rod& rod : rods.rods()) {
    open(at);
    out << "<inertial pos='" << vector(rod.centre * rod.along) << "' mass='" << rod.mass
        << "' diaginertia='" << vector(Vec3::Constant(rod.inertia)) << "'/>";
    at = rod.along;
  }
  if (const auto& load = rods.load()) {
    const Mat3& i = load->inertia;
    open(at);
    out << "<inertial pos='" << vector(load->centre) << "' mass='" << load->mass
        << "' fullinertia='" << vector(i.diagonal()) << ' ' << vector({i(0, 1), i(0, 2), i(1, 2)})
        << "'/></body>";
  }
  for (std::size_t i = 0; i < rods.rods().size(); ++i) out << "</body>";
  out << "</worldbody></mujoco>";
  return out.str();
}

mjModel* compile(const std::string& text) {
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  constexpr const char* kName = "rods.xml";
  mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(text.size()));
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), kName)], text.data(), text.size());
  char error[500] = "";
  mjModel* model = mj_loadXML(kName, files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (!model) throw std::runtime_error(std::string("MuJoCo: ") + error);
  return model;
}

class MuJoCo : public Engine {
 public:
  explicit MuJoCo(const Settings& settings)
      : Engine(number(settings, "step")), integrator_(text(settings, "integrator")) {}
  ~MuJoCo() override { mjcb_passive = nullptr; }

 private:
  void build(const Rods& rods) override {
    model_.reset(compile(xml(rods, integrator_)));
    data_.reset(mj_makeData(model_.get()));
    rods_ = &rods;
    // Joints turn by the difference of the spins that they join.
    Vec3 above = Vec3::Zero();
    mjtNum* rate = data_->qvel;
    const auto set = [&](const Vec3& spin) {
      for (int k = 0; k < 3; ++k) *rate++ = spin[k] - above[k];
      above = spin;
    };
    for (const Rod& rod : rods.rods()) set(rod.spin);
    if (rods.load()) set(rods.load()->spin);
    mju_user_warning = [](const char*) {};  // it would keep a log in the working directory
  }

  void step(double time, double dt) override {
    active_ = this;
    // Called at every stage of an integrator. Gravity is an option of the model, which MuJoCo hands
    // to this hook as constant.
    mjcb_passive = [](const mjModel*, mjData* data) {
      const Vec3 g = active_->gravity(data->time);
      for (int k = 0; k < 3; ++k) active_->model_->opt.gravity[k] = g[k];
    };
    data_->time = time;
    model_->opt.timestep = dt;
    mj_step(model_.get(), data_.get());
    // MuJoCo goes on from the start where it became unstable.
    for (const int trouble : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
      if (data_->warning[trouble].number == 0) continue;
      throw Diverged("mujoco", time, counters_.steps, "", 0, "not finite");
    }
  }

  void read(std::vector<Vec3>& ends, Quat& turn) override {
    mj_kinematics(model_.get(), data_.get());
    constexpr std::size_t kWorld = 1;  // body 0
    for (std::size_t i = 0; i < ends.size(); ++i) {
      const mjtNum* at = data_->xpos + 3 * (i + kWorld);
      ends[i] = Vec3(at[0], at[1], at[2]) + rotation(i + kWorld) * rods_->rods()[i].along;
    }
    if (rods_->load()) turn = rotation(ends.size() + kWorld);
  }

  Quat rotation(std::size_t body) const {
    const mjtNum* q = data_->xquat + 4 * body;
    return {q[0], q[1], q[2], q[3]};
  }

  struct Delete {
    void operator()(mjModel* model) const { mj_deleteModel(model); }
    void operator()(mjData* data) const { mj_deleteData(data); }
  };
  static inline MuJoCo* active_ = nullptr;  // the one that is stepping: hooks are global
  std::string integrator_;
  std::unique_ptr<mjModel, Delete> model_;
  std::unique_ptr<mjData, Delete> data_;
  const Rods* rods_ = nullptr;
};

}  // namespace

MethodInfo mujoco_method() {
  return {
      .name = "mujoco",
      .summary = "MuJoCo: joint coordinates, the composite rigid body algorithm",
      .settings = {step_setting(false, 20),
                   {.name = "integrator",
                    .meaning = "Semi-implicit Euler, implicit in velocity, or Runge-Kutta.",
                    .unit = "",
                    .fallback = std::string("Euler"),
                    .choices = {"Euler", "implicit", "RK4"},
                    .sweep = {std::string("Euler"), std::string("implicit"), std::string("RK4")}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<MuJoCo>(settings);
      }};
}

}  // namespace taut::engines
