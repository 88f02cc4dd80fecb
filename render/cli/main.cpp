// The program taut.
#include "render/cli/program.h"

int main(int argc, char** argv) {
  using namespace taut::cli;
  return run_program(
      argc, argv,
      {add_render, add_simulate, add_export, add_check, add_bench, add_chart, add_stability,
       add_compare, add_golden, add_judge, add_reach, add_claims, add_plan});
}
