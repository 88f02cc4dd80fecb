// MuJoCo: joint coordinates, the composite rigid body algorithm, one ball joint a rod.
#include <mujoco/mujoco.h>

#include <memory>
#include <sstream>

#include "sim/motion/rotation.h"
#include "tests/bench/engines/engine.h"
#include "tests/bench/engines/mujoco_model.h"
#include "tests/bench/engines/mujoco_solids.h"

namespace taut::engines {
namespace {

/// How the model is made, beside the rods.
struct Options {
  std::string integrator, contact;
  bool springs = false;  // joints have bends as their springs and dampers
};

/// The model in MuJoCo's own language. All bodies have the world's axes at the start.
std::string xml(const Rods& rods, const std::vector<Pose>& solids, const Options& options) {
  std::ostringstream out;
  out.precision(17);
  const auto vector = [](const Vec3& v) {
    std::ostringstream text;
    text.precision(17);
    text << v.x() << ' ' << v.y() << ' ' << v.z();
    return text.str();
  };
  const auto open = [&](const Vec3& at, bool is_joined, const Rod& rod) {
    out << "<body pos='" << vector(at) << (is_joined ? "'><joint type='ball'" : "'><freejoint");
    if (is_joined && options.springs) {
      out << " stiffness='" << rod.bending_stiffness << "' damping='" << rod.bending_damping << "'";
    }
    out << "/>";
  };
  // Where nothing touches and nothing is limited, what looks for that is switched off.
  const char* touching = rods.obstacles().empty() ? "constraint='disable' contact='disable' " : "";
  out << "<mujoco><compiler inertiafromgeom='false'/><option integrator='" << options.integrator
      << "'><flag " << touching
      << "limit='disable' equality='disable' frictionloss='disable' warmstart='disable' "
         "sensor='disable'/></option><worldbody>";
  const auto write_solids = [&](bool led) {
    for (std::size_t i = 0; i < solids.size(); ++i) {
      const Obstacle& obstacle = rods.obstacles()[i];
      if ((obstacle.path != nullptr) == led) write_solid(out, obstacle, solids[i], options.contact);
    }
  };
  write_solids(false);
  const std::vector<Bead> beads = rods.beads();
  auto bead = beads.begin();
  Vec3 at = Vec3::Zero();
  for (std::size_t i = 0; i < rods.rods().size(); ++i) {
    const Rod& rod = rods.rods()[i];
    open(at, rods.hangs() || i > 0, rod);
    for (; bead != beads.end() && bead->rod == i; ++bead) {
      write_ball(out, rods.radius(), rod.centre * rod.along + bead->at, options.contact);
    }
    out << "<inertial pos='" << vector(rod.centre * rod.along) << "' mass='" << rod.mass
        << "' diaginertia='" << vector(Vec3::Constant(rod.inertia)) << "'/>";
    at = rod.along;
  }
  if (const auto& load = rods.load()) {
    const Mat3& i = load->inertia;
    open(at, true, {});
    if (load->capsule.touches()) write_capsule(out, load->capsule, options.contact);
    out << "<inertial pos='" << vector(load->centre) << "' mass='" << load->mass
        << "' fullinertia='" << vector(i.diagonal()) << ' ' << vector({i(0, 1), i(0, 2), i(1, 2)})
        << "'/></body>";
  }
  for (std::size_t i = 0; i < rods.rods().size(); ++i) out << "</body>";
  write_solids(true);
  out << "</worldbody></mujoco>";
  return out.str();
}

class MuJoCo : public RodEngine {
 public:
  explicit MuJoCo(const Settings& settings)
      : RodEngine(number(settings, "step")),
        // Contact as stiff as a step lets it be, or as it comes.
        options_{text(settings, "integrator"),
                 text(settings, "contact") == "stiff" ? kStiffContact : "",
                 text(settings, "bending") == "springs"} {}
  ~MuJoCo() override { mjcb_passive = nullptr; }

 private:
  void build(const Rods& rods) override {
    std::vector<Pose> solids;
    for (const Obstacle& obstacle : rods.obstacles()) {
      solids.push_back(rods.motion(obstacle, world(), world().time).pose());
    }
    model_ = compile_model(xml(rods, solids, options_));
    // The solver's accuracy is relative to what moves freely.
    model_->stat.meaninertia = compile_model(xml(rods, {}, options_))->stat.meaninertia;
    data_.reset(mj_makeData(model_.get()));
    rods_ = &rods;
    edges_.resize(rods.rods().size());
    spins_.resize(rods.rods().size());
    for (std::size_t i = 0; i < rods.rods().size(); ++i) {
      if (rods.rods()[i].bending_stiffness > 0) set_straight(i);
    }
    bends_ = rods.resist_bending() && !options_.springs;
    // Joints turn by the difference of the spins that they join.
    Vec3 above = Vec3::Zero();
    mjtNum* rate = data_->qvel;
    const auto set = [&](const Vec3& spin) {
      for (int k = 0; k < 3; ++k) *rate++ = spin[k] - above[k];
      above = spin;
    };
    if (!rods.hangs()) {
      for (int k = 0; k < 3; ++k) *rate++ = rods.velocity()[k];
    }
    for (const Rod& rod : rods.rods()) set(rod.spin);
    if (rods.load()) set(rods.load()->spin);
  }

  /// Lets the spring of a rod's joint rest where the rod lies in line with what is above it.
  void set_straight(std::size_t rod) {
    const Vec3 above = rod == 0 ? rods_->clamp() : rods_->rods()[rod - 1].along.normalized();
    const Quat rest = rotation_between(rods_->rods()[rod].along.normalized(), above);
    mjtNum* q = model_->qpos_spring + model_->jnt_qposadr[rod];
    q[0] = rest.w();
    for (int k = 0; k < 3; ++k) q[k + 1] = rest.vec()[k];
  }

  /// The moments in the joints; MuJoCo has them in the axes of the rod below.
  void bend() {
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      edges_[i] = rotation(i + kWorld) * rods_->rods()[i].along;
      spins_[i] = Eigen::Map<const Vec3>(data_->cvel + 6 * (i + kWorld));
    }
    rods_->bend(edges_, spins_, moments_);
    for (std::size_t i = 0; i < moments_.size(); ++i) {
      const bool is_free = i == 0 && !rods_->hangs();  // then it has three coordinates of place
      Eigen::Map<Vec3> moment(data_->qfrc_passive + model_->body_dofadr[i + kWorld] +
                              (is_free ? 3 : 0));
      moment += rotation(i + kWorld).conjugate() * moments_[i];
    }
  }

  void step(double time, double dt) override {
    active_ = this;
    // Called at every stage of an integrator. Gravity is an option of the model, which MuJoCo hands
    // to this hook as constant.
    mjcb_passive = [](const mjModel*, mjData* data) {
      const Vec3 g = active_->gravity(data->time);
      for (int k = 0; k < 3; ++k) active_->model_->opt.gravity[k] = g[k];
      if (active_->bends_) active_->bend();
    };
    data_->time = time;
    model_->opt.timestep = dt;
    int body = static_cast<int>(kWorld + rods_->rods().size() + (rods_->load() ? 1 : 0));
    for (const Obstacle& obstacle : rods_->obstacles()) {
      if (!obstacle.path) continue;
      lead(*model_, *data_, body++, rods_->motion(obstacle, world(), time), gravity(time));
    }
    mj_step(model_.get(), data_.get());
    check_finite(*data_, time, counters_.steps);
  }

  void read(std::vector<Vec3>& ends, Quat& turn) override {
    mj_kinematics(model_.get(), data_.get());
    const std::size_t rods = rods_->rods().size();
    for (std::size_t i = 0; i < rods; ++i) {
      const mjtNum* at = data_->xpos + 3 * (i + kWorld);
      if (i == 0 && !rods_->hangs()) ends[0] = Vec3(at[0], at[1], at[2]);
      ends[i + 1] = Vec3(at[0], at[1], at[2]) + rotation(i + kWorld) * rods_->rods()[i].along;
    }
    if (rods_->load()) turn = rotation(rods + kWorld);
  }

  Quat rotation(std::size_t body) const {
    const mjtNum* q = data_->xquat + 4 * body;
    return {q[0], q[1], q[2], q[3]};
  }

  static constexpr std::size_t kWorld = 1;  // body 0
  static inline MuJoCo* active_ = nullptr;  // the one that is stepping: hooks are global
  Options options_;
  MuJoCoModel model_;
  MuJoCoData data_;
  const Rods* rods_ = nullptr;
  bool bends_ = false;                         // by moments of its own
  std::vector<Vec3> edges_, spins_, moments_;  // m, rad/s, N m
};

}  // namespace

MethodInfo mujoco_method() {
  return {.name = "mujoco",
          .summary = "MuJoCo: joint coordinates, the composite rigid body algorithm",
          .settings = {step_setting({}, 20),
                       mujoco_integrator(),
                       {.name = "contact",
                        .meaning = "As soft as it comes, or as stiff as the step lets it be.",
                        .unit = "",
                        .fallback = std::string("stiff"),
                        .choices = {"soft", "stiff"},
                        .sweep = {}},
                       {.name = "bending",
                        .meaning = "By the springs and dampers of the joints, or by the moments of "
                                   "taut's own model.",
                        .unit = "",
                        .fallback = std::string("springs"),
                        .choices = {"springs", "moments"},
                        .sweep = {}}},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<MuJoCo>(settings);
          },
          .forms = {{"moments", {{"bending", std::string("moments")}}}},
          .abilities = {kPlainFeatures | kMaterialFeatures | kTouched | Feature::body_contact |
                        Feature::body_pairs}};
}

}  // namespace taut::engines
