// A general multibody package with joint coordinates: Simbody, the open successor of SD/FAST.
#include <optional>

#include "sim/links/tension.h"
#include "sim/reference/methods.h"
#include "sim/reference/simbody_model.h"
#include "sim/run/error_estimate.h"
#include "sim/run/trajectory.h"

namespace taut::reference {
namespace {

constexpr std::string_view kMultibody = "multibody";

class Multibody final : public Method {
 public:
  explicit Multibody(const Settings& settings)
      : accuracy_(number(settings, "accuracy")), integrator_(text(settings, "integrator")) {}

  void advance(World& world, double until) override;

 private:
  void count();

  double accuracy_;
  std::string integrator_;
  std::optional<SimbodyModel> model_;
  VelocityProjection velocity_projection_;
  std::uint64_t topology_ = 0;
  std::uint64_t left_at_ = 0;  // hash of the world as this left it
  Counters before_;            // of models that are no more
  double cycles_ = 0;          // of a realization
};

void Multibody::advance(World& world, double until) {
  if (!model_ || topology_ != world.topology) require(kMultibody, world);
  try {
    if (!model_ || topology_ != world.topology || left_at_ != state_hash(world)) {
      before_ = counters_;
      topology_ = world.topology;
      velocity_projection_.stop(world);  // joint coordinates have no such velocities
      model_.emplace(world, integrator_, accuracy_);
      cycles_ = 42000;
      for (const Connector& connector : world.connectors) {
        cycles_ += 4350 * static_cast<double>(connector.links());
      }
    }
    model_->advance(world, until);
    count();
  } catch (const std::runtime_error& error) {
    if (model_) count();
    const double time = model_ ? model_->time() : world.time;
    throw Diverged(std::string(kMultibody), time, counters_.steps,
                   world.connectors.empty() ? "" : world.connectors.front().name, 0, error.what());
  }
  left_at_ = state_hash(world);
}

/// Of a realization the cycles are those of Simbody's order(N) passes, with quaternions and 6 x 6
/// matrices at every link, as they were measured.
void Multibody::count() {
  const auto tally = [](int number) { return static_cast<std::uint64_t>(number); };
  counters_.steps = before_.steps + tally(model_->steps());
  counters_.solves = before_.solves + tally(model_->realizations());
  counters_.cycles = before_.cycles + cycles_ * model_->realizations();
  counters_.rejected = before_.rejected + tally(model_->attempts() - model_->steps());
}

}  // namespace

MethodInfo multibody_method() {
  return {
      .name = kMultibody,
      .summary = "joint coordinates with error control, by Simbody",
      .settings = {{.name = "accuracy",
                    .meaning =
                        "Relative error allowed in a step. Raising it costs less and errs more.",
                    .unit = "1",
                    .fallback = 1e-3,
                    .minimum = 1e-12,
                    .maximum = 0.5,
                    .sweep = {0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9}},
                   {.name = "integrator",
                    .meaning = "Integrator of a step: Runge-Kutta-Merson of fourth order, "
                               "Runge-Kutta of third order, or Verlet of second order.",
                    .unit = "",
                    .fallback = std::string("merson"),
                    .choices = {"merson", "runge-kutta-3", "verlet"},
                    .sweep = {std::string("merson"), std::string("runge-kutta-3")}}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Multibody>(settings);
      },
      .paper_role = PaperRole::package_of_today,
      .abilities = {kPlainFeatures},
      .companion =
          [](const MethodInfo& multibody, const Settings& settings) {
            return with_tolerance_raised(multibody, settings, "accuracy");
          },
      .particle_memory = 8000,
      .runs_alone = true};
}

}  // namespace taut::reference
