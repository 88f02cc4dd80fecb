// The commands of the program taut, in the order in which --help lists them.
#pragma once

#include "render/cli/program.h"

namespace taut::cli {

void add_demo(CLI::App& app, Program& program);

inline constexpr AddCommand kCommands[] = {
    add_demo,      add_render,  add_simulate, add_export, add_check, add_bench,  add_chart,
    add_stability, add_compare, add_golden,   add_judge,  add_reach, add_claims, add_plan,
};

}  // namespace taut::cli
