// taut beside other engines: their settings in taut's own studies.
#include "render/cli/commands.h"
#include "sim/run/method.h"
#include "tests/bench/engines/engine.h"

int main(int argc, char** argv) {
  using namespace taut;
#ifdef TAUT_BULLET
  add_method(engines::bullet_method());
  add_method(engines::bullet_net_method());
#endif
#ifdef TAUT_MUJOCO
  add_method(engines::mujoco_method());
  add_method(engines::mujoco_net_method());
#endif
#ifdef TAUT_ODE
  add_method(engines::ode_method());
  add_method(engines::ode_net_method());
#endif
  constexpr program::AddCommand kCommands[] = {cli::add_work_precision, cli::add_chart};
  return program::run_program(argc, argv, kCommands);
}
