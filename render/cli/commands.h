// The commands of the program taut, one per file of this folder.
#pragma once

#include "render/program/program.h"

namespace taut::cli {

void add_new(CLI::App& app, program::Program& program);
void add_demo(CLI::App& app, program::Program& program);
void add_render(CLI::App& app, program::Program& program);
void add_simulate(CLI::App& app, program::Program& program);
void add_export(CLI::App& app, program::Program& program);
void add_check(CLI::App& app, program::Program& program);
void add_bench(CLI::App& app, program::Program& program);
void add_chart(CLI::App& app, program::Program& program);
void add_stability(CLI::App& app, program::Program& program);
void add_compare(CLI::App& app, program::Program& program);
void add_golden(CLI::App& app, program::Program& program);
void add_classify(CLI::App& app, program::Program& program);
void add_work_precision(CLI::App& app, program::Program& program);
void add_claims(CLI::App& app, program::Program& program);
void add_plan(CLI::App& app, program::Program& program);
void add_choreograph(CLI::App& app, program::Program& program);
void add_report(CLI::App& app, program::Program& program);
void add_verify(CLI::App& app, program::Program& program);

/// In the order in which --help lists them.
inline constexpr program::AddCommand kCommands[] = {
    add_new,         add_demo,     add_render,         add_simulate,  add_export,
    add_check,       add_bench,    add_chart,          add_stability, add_compare,
    add_golden,      add_classify, add_work_precision, add_claims,    add_plan,
    add_choreograph, add_report,   add_verify,
};

}  // namespace taut::cli
