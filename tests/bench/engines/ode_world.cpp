#include "tests/bench/engines/ode_world.h"

namespace taut::engines {
namespace {

/// The library, as long as the program runs.
struct Library {
  Library() { dInitODE2(0); }
  ~Library() { dCloseODE(); }
};

}  // namespace

OdeWorld make_ode_world(const Settings& settings) {
  static const Library library;
  const OdeWorld world{dWorldCreate(), static_cast<int>(number(settings, "iterations"))};
  dWorldSetERP(world.id, number(settings, "erp"));
  dWorldSetCFM(world.id, 0);
  if (world.iterations > 0) dWorldSetQuickStepNumIterations(world.id, world.iterations);
  return world;
}

std::vector<SettingInfo> ode_settings() {
  return {step_setting(false, 20),
          {.name = "iterations",
           .meaning = "Of QuickStep; zero solves all joints exactly.",
           .unit = "1",
           .fallback = 0.0,
           .maximum = 1e6,
           .whole = true,
           .sweep = {0.0, 20.0, 200.0}},
          {.name = "erp",
           .meaning = "Share of a joint's gap that a step closes.",
           .unit = "1",
           .fallback = 0.2,
           .maximum = 1,
           .sweep = {0.2, 0.8}}};
}

}  // namespace taut::engines
