// SD/FAST, the multibody package that the paper compares with.
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "sim/links/tension.h"
#include "sim/motion/stop.h"
#include "sim/reference/methods.h"
#include "sim/reference/sdfast/chain.h"
#include "sim/reference/sdfast/model.h"
#include "sim/run/error_estimate.h"
#include "sim/run/trajectory.h"

namespace taut::reference {
namespace {

using sdfast::Chain;
using sdfast::Formulation;
using sdfast::Joints;
using sdfast::Model;

constexpr std::string_view kSdfast = "sdfast";

class SdFast final : public Method {
 public:
  explicit SdFast(const Settings& settings)
      : tolerance_(number(settings, "tolerance")),
        formulation_(text(settings, "formulation") == "kane" ? sdfast::Formulation::kane
                                                             : sdfast::Formulation::order_n),
        always_ball_(text(settings, "joints") == "ball") {}
  ~SdFast() override {
    if (user_ == this) user_ = nullptr;
  }

  void advance(World& world, double until) override;

 private:
  void choose(const World& world);
  void set_up(const World& world);
  void load(World& world);
  void integrate(World& world, double until);
  void store(World& world, double until);
  void check(const World& world) const;
  bool planar() const { return model_->joints == sdfast::Joints::pin; }
  static void look(double time);
  [[noreturn]] void give_up(const World& world, const std::string& what) const;

  static SdFast* user_;  // of all models: whose numbers theirs are

  double tolerance_;
  sdfast::Formulation formulation_;
  bool always_ball_;
  const sdfast::Model* model_ = nullptr;
  sdfast::Chain chain_;
  Plane plane_;                               // of pins
  const World* moving_ = nullptr;             // while a model integrates
  std::uint64_t topology_ = 0, left_at_ = 0;  // hash of the world as this left it
  VelocityProjection velocity_projection_;
  int start_ = 1;
  std::vector<double> state_, rate_;
};

SdFast* SdFast::user_ = nullptr;

void SdFast::give_up(const World& world, const std::string& what) const {
  throw Diverged(std::string(kSdfast), world.time, counters_.steps,
                 world.connectors.empty() ? "" : world.connectors.front().name, 0, what);
}

/// Finds the model of the world's chain.
void SdFast::choose(const World& world) {
  require(kSdfast, world);
  try {
    chain_ = sdfast::find_chain(world);
  } catch (const std::invalid_argument& error) {
    give_up(world, error.what());
  }
  sdfast::Joints joints = chain_.held ? sdfast::Joints::ball : sdfast::Joints::free;
  const auto plane = always_ball_ ? std::nullopt : sdfast::plane_of(world, chain_);
  if (plane) {
    joints = sdfast::Joints::pin;
    plane_ = *plane;
  }
  const auto models = sdfast::models();
  const auto found = std::ranges::find_if(models, [&](const sdfast::Model& model) {
    return static_cast<std::size_t>(model.links) == chain_.links && model.joints == joints &&
           model.formulation == formulation_;
  });
  if (found == models.end()) {
    constexpr std::string_view kinds[] = {"with pins", "with ball joints",
                                          "with ball joints and a free base"};
    give_up(world, "was built without a model of " + std::to_string(chain_.links) + " links " +
                       std::string(kinds[static_cast<std::size_t>(joints)]));
  }
  model_ = &*found;
}

void SdFast::set_up(const World& world) {
  model_->clear_error();
  if (planar()) {
    sdfast::set_up_pins(*model_, world, chain_, plane_);
  } else {
    sdfast::set_up_balls(*model_, world, chain_);
  }
  model_->init();
  start_ = 1;
  user_ = this;
}

void SdFast::load(World& world) {
  velocity_projection_.stop(world);  // joint coordinates have no such velocities
  if (planar()) {
    sdfast::load_pins(world, chain_, plane_, state_);
  } else {
    sdfast::load_balls(world, chain_, state_);
  }
  rate_.assign(state_.size(), 0);
  start_ = 1;
}

void SdFast::store(World& world, double until) {
  if (planar()) {
    sdfast::store_pins(state_, chain_, plane_, world);
  } else {
    sdfast::store_balls(state_, chain_, until, world);
  }
  place_held(world, until);
}

/// At each instant that a model looks at. In the frame of a moving base, which does not turn,
/// everything falls against its acceleration.
void SdFast::look(double time) {
  check_stop();
  SdFast& user = *user_;
  ++user.counters_.solves;
  user.counters_.cycles += 3000 + 600 * static_cast<double>(user.chain_.links);
  if (!user.chain_.held || user.chain_.held->kind == Attachment::Kind::fixed) return;
  const PointMotion base = hold_motion(*user.moving_, *user.chain_.held, time);
  sdfast::drag_balls(*user.model_, *user.moving_, user.chain_, base.acceleration);
}

void SdFast::integrate(World& world, double until) {
  constexpr double kNoConstraints = 1e-10;
  double time = world.time;
  int failed = 0;
  moving_ = &world;
  sdfast::forces = &SdFast::look;
  model_->motion(&time, state_.data(), rate_.data(), until - time, kNoConstraints, tolerance_,
                 &start_, &failed);
  ++counters_.steps;
  check(world);
  const bool finite = std::ranges::all_of(state_, [](double x) { return std::isfinite(x); });
  if (failed != 0 || !finite) give_up(world, "its steps became too short");
}

void SdFast::check(const World& world) const {
  int routine = 0, number = 0;
  model_->error(&routine, &number);
  // A step tried and undone may leave quaternions far from units, which SD/FAST reports although it
  // makes them units where it uses them.
  constexpr int kFarFromUnits = 14;
  if (number == kFarFromUnits) model_->clear_error();
  if (number == 0 || number == kFarFromUnits) return;
  give_up(world, "SD/FAST's error " + std::to_string(number) + " in its routine " +
                     std::to_string(routine));
}

void SdFast::advance(World& world, double until) {
  if (!model_ || topology_ != world.topology || left_at_ != state_hash(world)) {
    choose(world);
    topology_ = world.topology;
    set_up(world);
    load(world);
  } else if (user_ != this) {
    set_up(world);
  }
  if (until > world.time) integrate(world, until);
  store(world, until);
  left_at_ = state_hash(world);
}

}  // namespace

MethodInfo sdfast_method() {
  return {
      .name = kSdfast,
      .summary =
          "single chains that nothing pins, in joint coordinates, by SD/FAST's generated code",
      .settings = {{.name = "tolerance",
                    .meaning = "Error allowed in a step, in joint coordinates and their rates. "
                               "Raising it costs less and errs more.",
                    .unit = "1",
                    .fallback = 1e-3,
                    .minimum = 1e-12,
                    .maximum = 1,
                    .sweep = {0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}},
                   {.name = "formulation",
                    .meaning = "Formulation: order-n costs in proportion to the links, kane solves "
                               "with the whole mass matrix.",
                    .unit = "",
                    .fallback = std::string("order-n"),
                    .choices = {"order-n", "kane"}},
                   {.name = "joints",
                    .meaning = "Joints of links: fewest uses pins where the chain moves in a "
                               "plane, ball only ball joints.",
                    .unit = "",
                    .fallback = std::string("fewest"),
                    .choices = {"fewest", "ball"}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<SdFast>(settings);
      },
      .missing = sdfast::models().empty() ? "not installed" : "",
      .paper_role = PaperRole::package,
      .forms = {{"kane", {{"formulation", std::string("kane")}}},
                {"ball", {{"joints", std::string("ball")}}}},
      .abilities = {kPlainFeatures},
      .companion =
          [](const MethodInfo&, const Settings&) {
            return Companion{.none = "keeps the state of one run at a time in its generated code"};
          },
      .particle_memory = 8000,
      .runs_alone = true};
}

}  // namespace taut::reference
