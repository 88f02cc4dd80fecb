#include "sim/methods/sdfast.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "sim/methods/direct/plane.h"
#include "sim/methods/sdfast/model.h"
#include "sim/trajectory.h"

namespace taut {
namespace {

using sdfast::Formulation;
using sdfast::Model;

constexpr std::string_view kName = "sdfast";

class SdFast final : public Method {
 public:
  explicit SdFast(const Settings& settings)
      : tolerance_(number(settings, "tolerance")),
        formulation_(text(settings, "formulation") == "kane" ? Formulation::kane
                                                             : Formulation::order_n) {}
  ~SdFast() override {
    if (user_ == this) user_ = nullptr;
  }

  void advance(World& world, double until) override;

 private:
  void choose(const World& world);
  void set_up(const World& world);
  void load(const World& world);
  void store(World& world) const;
  void check(const World& world) const;
  [[noreturn]] void give_up(const World& world, const std::string& what) const;

  static const SdFast* user_;  // of all models: whose numbers theirs are

  double tolerance_;
  Formulation formulation_;
  const Model* model_ = nullptr;
  direct::Plane plane_;
  std::uint64_t topology_ = 0, left_at_ = 0;  // hash of the world as this left it
  int start_ = 1;
  std::vector<double> state_, rate_;
};

const SdFast* SdFast::user_ = nullptr;

void SdFast::give_up(const World& world, const std::string& what) const {
  throw Diverged(std::string(kName), world.time, counters_.steps,
                 world.connectors.empty() ? "" : world.connectors.front().name, 0, what);
}

/// Finds the model and the plane of the world's chain.
void SdFast::choose(const World& world) {
  const auto is_chain = [&] {
    if (world.connectors.size() != 1 || !world.bodies.empty()) return false;
    const Connector& chain = world.connectors.front();
    if (chain.holds.size() != 1 || chain.model != ConnectorModel::links) return false;
    const Hold& hold = chain.holds.front();
    return hold.particle == 0 && hold.to.kind == Attachment::Kind::fixed &&
           hold.to.approach.arrival <= world.time && std::ranges::min(chain.rest) > 0;
  };
  if (!is_chain()) give_up(world, "follows one chain from a fixed point alone");
  const Connector& chain = world.connectors.front();
  std::vector<Vec3> vectors{world.gravity};
  for (std::size_t k = 0; k < chain.links(); ++k) {
    vectors.push_back(chain.position[k + 1] - chain.position[k]);
    vectors.push_back(chain.velocity[k + 1] - chain.velocity[k]);
  }
  const auto plane = direct::common_plane(vectors, {});
  if (!plane) give_up(world, "follows a chain in a plane alone");
  plane_ = *plane;
  const auto models = sdfast::models();
  const auto found = std::ranges::find_if(models, [&](const Model& model) {
    return static_cast<std::size_t>(model.links) == chain.links() &&
           model.formulation == formulation_;
  });
  if (found == models.end()) {
    give_up(world, "was built without a model of " + std::to_string(chain.links()) + " links");
  }
  model_ = &*found;
}

/// Gives the model the world's numbers. In its reference shape the chain hangs down, so that joints
/// lie above particles.
void SdFast::set_up(const World& world) {
  const Connector& chain = world.connectors.front();
  model_->clear_error();
  double gravity[3] = {world.gravity.dot(plane_.x), world.gravity.dot(plane_.y), 0};
  model_->gravity(gravity);
  for (int k = 0; k < model_->links; ++k) {
    const auto link = static_cast<std::size_t>(k);
    double arm[3] = {0, chain.rest[link], 0};
    model_->mass(k, chain.particle_mass[link + 1]);
    model_->to_joint(k, arm);
  }
  model_->init();
  start_ = 1;
  user_ = this;
}

void SdFast::load(const World& world) {
  const Connector& chain = world.connectors.front();
  const std::size_t n = chain.links();
  state_.assign(2 * n, 0);
  rate_.assign(2 * n, 0);
  double angle_before = 0, spin_before = 0;
  for (std::size_t k = 0; k < n; ++k) {
    const Vec3 along = chain.position[k + 1] - chain.position[k];
    const Vec3 moves = chain.velocity[k + 1] - chain.velocity[k];
    const double x = along.dot(plane_.x), y = along.dot(plane_.y);
    const double angle = std::atan2(x, -y);  // from down, towards x
    const double spin = (x * moves.dot(plane_.y) - y * moves.dot(plane_.x)) / (x * x + y * y);
    state_[k] = angle - std::exchange(angle_before, angle);
    state_[n + k] = spin - std::exchange(spin_before, spin);
  }
  start_ = 1;
}

void SdFast::store(World& world) const {
  Connector& chain = world.connectors.front();
  const std::size_t n = chain.links();
  double angle = 0, spin = 0;
  for (std::size_t k = 0; k < n; ++k) {
    angle += state_[k];
    spin += state_[n + k];
    const double s = std::sin(angle), c = std::cos(angle);
    chain.position[k + 1] = chain.position[k] + chain.rest[k] * (s * plane_.x - c * plane_.y);
    chain.velocity[k + 1] =
        chain.velocity[k] + chain.rest[k] * spin * (c * plane_.x + s * plane_.y);
  }
}

void SdFast::check(const World& world) const {
  int routine = 0, number = 0;
  model_->error(&routine, &number);
  if (number == 0) return;
  give_up(world, "SD/FAST's error " + std::to_string(number) + " in its routine " +
                     std::to_string(routine));
}

void SdFast::advance(World& world, double until) {
  if (!model_ || topology_ != world.topology) {
    choose(world);
    topology_ = world.topology;
    left_at_ = 0;
    user_ = nullptr;
  }
  if (user_ != this) set_up(world);
  if (left_at_ != state_hash(world)) load(world);
  double time = world.time;
  int failed = 0;
  if (until > time) {
    constexpr double kNoConstraints = 1e-10;
    model_->motion(&time, state_.data(), rate_.data(), until - time, kNoConstraints, tolerance_,
                   &start_, &failed);
    ++counters_.steps;
  }
  check(world);
  const bool finite = std::ranges::all_of(state_, [](double x) { return std::isfinite(x); });
  if (failed != 0 || !finite) give_up(world, "its steps became too short");
  store(world);
  place_held(world, until);
  left_at_ = state_hash(world);
}

}  // namespace

MethodInfo sdfast_method() {
  return {.name = kName,
          .summary = "planar chains in joint angles, by SD/FAST's generated code",
          .settings = {{.name = "tolerance",
                        .meaning = "Error allowed in a step, in radians and rad/s; less is dearer.",
                        .unit = "1",
                        .fallback = 1e-3,
                        .minimum = 1e-12,
                        .maximum = 1,
                        .sweep = {0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}},
                       {.name = "formulation",
                        .meaning = "Order(N), whose cost grows with the links, or Kane's.",
                        .unit = "",
                        .fallback = std::string("order-n"),
                        .choices = {"order-n", "kane"}}},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<SdFast>(settings);
          },
          .missing = sdfast::models().empty() ? "not installed" : "",
          .forms = {{"kane", {{"formulation", std::string("kane")}}}}};
}

}  // namespace taut
