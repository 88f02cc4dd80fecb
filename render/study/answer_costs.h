// What an error costs: a method, or another program, on a case at finer and finer settings.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "render/chart/chart.h"
#include "render/chart/table.h"
#include "render/program/output.h"
#include "render/study/answer_engines.h"
#include "render/study/known_answers.h"

namespace taut::studies {

/// The errors whose cost is told, as shares of the length.
inline constexpr double kErrors[] = {0.1, 0.01, 0.001};

/// The length that errors of places are shares of: that of the longest connector, or the size of
/// the bodies, m.
double length_of(const AnswerCase& of);

/// The verdict on the best of an engine's runs, the step halved each time: until it passes, four
/// runs in a row are no better, or they take `cpu_cap` (s) together.
Verdict refined(const AnswerCase& of, const Engine& engine, double cpu_cap);
/// Likewise of a method: by its step, and by its tolerance if it has one; at its own settings
/// if it has neither.
Verdict refined(const AnswerCase& of, const options::Contender& contender,
                const std::vector<std::string>& set, double cpu_cap);

/// The order in the step: how the error falls with it between neighbouring runs, the median. None
/// where no two are between the tolerance and a tenth of the length.
std::optional<double> order_of(const AnswerCase& of, const Verdict& verdict);
/// The least CPU time (s) of a run whose error is at most `error`.
std::optional<double> cost_of(const Verdict& verdict, double error);

/// A row for each method of each case: order, costs of errors, and the least error.
chart::Table costs_table(const std::vector<Verified>& all);
/// The same of one verdict, as keys of its JSON.
void add_costs(program::Json& entry, const AnswerCase& of, const Verdict& verdict);
/// How many cases each method solves within a CPU time, a panel for each error. `styles` has one
/// for each verdict of a case.
chart::Chart costs_chart(const std::vector<Verified>& all, const std::vector<chart::Style>& styles);

}  // namespace taut::studies
