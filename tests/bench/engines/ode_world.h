// What both of ODE's methods have: its world, and how it steps.
#pragma once

#include <ode/ode.h>

#include <vector>

#include "sim/run/method.h"

namespace taut::engines {

struct OdeWorld {
  dWorldID id = nullptr;
  int iterations = 0;  // of QuickStep; zero: all joints are solved exactly

  bool broken = false;

  /// From `time` (s) on. Throws Diverged.
  void step(double time, double dt);
  void destroy();
};

/// Whoever has it destroys it.
OdeWorld make_ode_world(const Settings& settings);
std::vector<SettingInfo> ode_settings();

}  // namespace taut::engines
