#include "tests/bench/engines/ode_world.h"

#include <cstdarg>
#include <cstdio>
#include <stdexcept>

namespace taut::engines {
namespace {

/// The library, as long as the program runs.
struct Library {
  Library() {
    dInitODE2(0);
    // It would end the program where something is not finite, and tell of every system that it
    // solves badly.
    dSetDebugHandler([](int, const char* message, va_list values) {
      any_broken = true;
      char text[200] = "";
      std::vsnprintf(text, sizeof text, message, values);
      throw std::runtime_error(text);
    });
    dSetMessageHandler([](int, const char*, va_list) {});
  }
  ~Library() {
    if (!any_broken) dCloseODE();
  }
  static inline bool any_broken = false;  // a world was left in the middle of a step
};

}  // namespace

void OdeWorld::step(double time, double dt) {
  broken = true;
  try {
    if (iterations > 0) {
      dWorldQuickStep(id, dt);
    } else {
      dWorldStep(id, dt);
    }
  } catch (const std::runtime_error& error) {
    throw Diverged("ode", time, 0, "", 0, error.what());
  }
  broken = false;
}

void OdeWorld::destroy() {
  // One that was left in the middle of a step cannot be destroyed.
  if (!broken) dWorldDestroy(id);
}

OdeWorld make_ode_world(const Settings& settings) {
  static const Library library;
  OdeWorld world{dWorldCreate(), static_cast<int>(number(settings, "iterations"))};
  dWorldSetERP(world.id, number(settings, "erp"));
  dWorldSetCFM(world.id, 0);
  if (world.iterations > 0) dWorldSetQuickStepNumIterations(world.id, world.iterations);
  return world;
}

std::vector<SettingInfo> ode_settings() {
  return {step_setting({}, 20),
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
