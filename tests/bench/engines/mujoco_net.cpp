// MuJoCo: particles that slide along three axes each, and tendons that keep their lengths, as its
// own grids are made.
#include <sstream>

#include "tests/bench/engines/engine.h"
#include "tests/bench/engines/mujoco_model.h"
#include "tests/bench/engines/mujoco_solids.h"

namespace taut::engines {
namespace {

std::string net_xml(const Points& net, const std::string& integrator) {
  std::ostringstream out, tendons, lengths;
  out.precision(17);
  tendons.precision(17);
  const Vec3& g = net.gravity();
  out << "<mujoco><compiler inertiafromgeom='false'/><option integrator='" << integrator
      << "' gravity='" << g.x() << ' ' << g.y() << ' ' << g.z() << "'><flag "
      << (net.obstacles().empty() ? "contact='disable' " : "")
      << "frictionloss='disable' sensor='disable'/></option><worldbody>";
  for (const Obstacle& obstacle : net.obstacles()) {
    write_solid(out, obstacle, obstacle.place, kStiffContact);
  }
  for (std::size_t i = 0; i < net.points().size(); ++i) {
    const Point& point = net.points()[i];
    const Vec3& at = point.position;
    out << "<body pos='" << at.x() << ' ' << at.y() << ' ' << at.z() << "'>";
    if (!point.held) {
      for (const char* axis : {"1 0 0", "0 1 0", "0 0 1"}) {
        out << "<joint type='slide' axis='" << axis << "'/>";
      }
      out << "<inertial pos='0 0 0' mass='" << point.mass << "' diaginertia='1 1 1'/>";
      if (!net.obstacles().empty()) write_ball(out, point.radius, Vec3::Zero(), kStiffContact);
    }
    out << "<site name='" << i << "'/></body>";
  }
  for (std::size_t i = 0; i < net.links().size(); ++i) {
    const Link& link = net.links()[i];
    tendons << "<spatial name='" << i << "'";
    if (link.pulls) tendons << " limited='true' range='0 " << link.length << "' " << kStiffLimit;
    tendons << "><site site='" << link.a << "'/><site site='" << link.b << "'/></spatial>";
    if (!link.pulls) lengths << "<tendon tendon1='" << i << "' " << kStiffContact << "/>";
  }
  out << "</worldbody><tendon>" << tendons.str() << "</tendon><equality>" << lengths.str()
      << "</equality></mujoco>";
  return out.str();
}

class MuJoCoNet : public NetEngine {
 public:
  explicit MuJoCoNet(const Settings& settings)
      : NetEngine(number(settings, "step")), integrator_(text(settings, "integrator")) {}

 private:
  void build(const Points& net) override {
    model_ = compile_model(net_xml(net, integrator_));
    data_.reset(mj_makeData(model_.get()));
    for (std::size_t i = 0; i < net.points().size(); ++i) {
      if (net.points()[i].held) continue;
      Eigen::Map<Vec3>(data_->qvel + 3 * moving_.size()) = net.points()[i].velocity;
      moving_.push_back(i);
      start_.push_back(net.points()[i].position);
    }
  }

  void step(double time, double dt) override {
    model_->opt.timestep = dt;
    mj_step(model_.get(), data_.get());
    check_finite(*data_, time, counters_.steps);
  }

  void read(std::vector<Vec3>& positions) override {
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      positions[moving_[i]] = start_[i] + Eigen::Map<const Vec3>(data_->qpos + 3 * i);
    }
  }

  std::string integrator_;
  MuJoCoModel model_;
  MuJoCoData data_;
  std::vector<std::size_t> moving_;  // the points that have three coordinates each, in a row
  std::vector<Vec3> start_;          // m, of these
};

}  // namespace

MethodInfo mujoco_net_method() {
  return {.name = "mujoco-net",
          .summary = "MuJoCo: particles, and tendons that keep their lengths",
          .settings = {step_setting({}, 20), mujoco_integrator()},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<MuJoCoNet>(settings);
          },
          .abilities = {kPlainFeatures | kJointFeatures | kTouched | Feature::strings}};
}

}  // namespace taut::engines
