// Options that bench, chart, stability and compare share: methods, time, and the folder of results.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "render/chart/chart.h"
#include "render/chart/table.h"
#include "render/options/scene_options.h"
#include "render/program/command.h"
#include "render/program/part.h"
#include "scenes/scene/scene.h"
#include "sim/run/method.h"

namespace taut::options {

/// The features that a study command follows, by its name; those of every study for other names.
Features study_features(std::string_view command);

struct StudyOptions {
  SceneOptions inputs;
  std::string scene;                   // of the inputs, the one that is studied now
  std::string out;                     // empty: by the scene's path, see results_folder()
  std::vector<std::string> methods;    // METHOD or METHOD:FORM; empty: all
  std::optional<double> asked_budget;  // --budget
  double budget = 0;                   // s of CPU time
  bool quick = false;
  double reference_step = 0;  // s: scores are against `direct` at that step; zero: the truth
  program::PartOptions part;  // of chart and stability
  Features features = study_features({});  // that the study follows
};

/// What a study may take unless --budget tells, s of CPU time.
struct Budgets {
  double usual = 0, quick = 0;
};

/// SCENE..., --set, --out, --methods, --budget and --quick.
void add_study_options(program::Command& command, StudyOptions& options, const Budgets& budgets);

/// Sets the budget, once options are parsed: the one asked for, or that of `budgets`.
void choose_budget(StudyOptions& options, const Budgets& budgets);

/// A row of a comparison: a method, or a form of it.
struct Contender {
  std::string label;  // "dynamic-constraints:dense"
  const MethodInfo* method = nullptr;
  MethodChoice candidate;  // at its defaults, with what the form sets
  chart::Style style;      // the same in every chart
};

/// The contenders that the options name, in the order of the list of methods; those that this build
/// lacks too. Throws Misuse.
std::vector<Contender> chosen_contenders(const StudyOptions& options);

/// The contenders that follow `world`. Throws Misuse where one asked for does not, or none does.
std::vector<Contender> contenders_on(const StudyOptions& options, const World& world);

/// The index of the paper's method of that role, or of a form of it; the contenders' number where
/// it is absent.
std::size_t place_of(const std::vector<Contender>& contenders, PaperRole role,
                     std::string_view form = {});

/// The contender's name in legends: the label and, where this build lacks it, why.
std::string legend_name(const Contender& contender);

/// Every setting of a contender's sweep (only the ends and middle of numbers where `quick`), with
/// what its form sets put over it.
std::vector<MethodChoice> candidates_of(const Contender& contender, bool quick);

/// Calls `study` with the options of each of the scenes in turn, see for_each_scene().
int for_each_study(const StudyOptions& options, const program::Common& common,
                   const std::function<int(const StudyOptions& one)>& study);

/// The folder that results go to.
std::filesystem::path study_folder(const StudyOptions& options);

/// The scene, without its stage unless asked for. Throws Misuse where it has no connector, or a
/// feature that the study does not follow.
scenes::Scene study_scene(const StudyOptions& options,
                          const std::vector<scenes::SceneChange>& changes = {},
                          bool with_stage = false);
/// The scene with another number of particles in its first connector.
scenes::Scene study_scene(const StudyOptions& options, std::size_t particles);

/// Of everything that decides a study's results: program, scene file, methods, budget.
std::uint64_t stamp_of(const StudyOptions& options);

/// The key of a value of the scene's first connector: connectors.NAME.`key`.
std::string connector_key(const scenes::Scene& scene, const std::string& key);

/// The processor, the compiler and the build, in a line.
std::string machine();

/// A number with three significant digits.
std::string rounded(double value);
/// A share in percent, so: 0.0001%.
std::string percent(double share);

/// Writes BASE.csv; says so on standard error.
void write_csv(const chart::Table& table, const std::filesystem::path& base);

}  // namespace taut::options
