// taut stability: where each method fails, as maps.
#include <algorithm>
#include <memory>

#include "render/base/atomic_file.h"
#include "render/chart/chart.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/stability_study.h"

namespace taut::cli {
namespace stability_command {
namespace {

constexpr options::Budgets kBudgets{.usual = 480, .quick = 20};

/// How many cells of all maps each method has of each class.
chart::Table class_table(const studies::StabilityStudy& study) {
  constexpr study::MotionClass kClasses[] = {
      study::MotionClass::accurate,  study::MotionClass::plausible, study::MotionClass::over_damped,
      study::MotionClass::stretched, study::MotionClass::failed,    study::MotionClass::over_cap};
  chart::Table table{{"cells"}, {}};
  for (const study::MotionClass one : kClasses) {
    table.columns.emplace_back(one == study::MotionClass::over_cap ? "not run"
                                                                   : study::name_of(one));
  }
  for (std::size_t c = 0; c < study.contenders.size(); ++c) {
    std::vector<std::string> row{study.contenders[c].label};
    for (const study::MotionClass one : kClasses) {
      std::ptrdiff_t count = 0;
      for (const studies::StabilityMap& map : study.maps)
        count += std::ranges::count_if(map.cells, [&](const studies::MapCell& cell) {
          return cell.contender == c && cell.classification.motion_class == one;
        });
      row.push_back(std::to_string(count));
    }
    table.add(std::move(row));
  }
  return table;
}

int run(const options::StudyOptions& options, const program::Common& common) {
  const scenes::Scene scene = options::study_scene(options);
  studies::StabilityStudy study = studies::stability_study(options, scene);
  if (options.part.is_part()) return studies::map_part(study, options, scene, common);
  chart::require_gnuplot();
  const std::filesystem::path folder = options::study_folder(options);
  program::Journal journal =
      studies::map_all(study, options, scene, folder, "stability.unfinished", common,
                       [&](const studies::StabilityMap& map) {
                         chart::write_chart(studies::stability_chart(study, map),
                                            folder / ("stability_" + map.axis.name));
                       });
  options::write_csv(studies::stability_table(study), folder / "stability");
  render::AtomicFile page(folder / "stability.html");
  page.write(studies::stability_page(study));
  page.commit();
  if (!options.part.merge) journal.finish();
  render::write_output(common.json ? studies::stability_json(study)
                                   : program::table_text(class_table(study)));
  if (!common.quiet) {
    program::note("{}/stability: .html .csv, and a .svg and .png per map\n", folder.string());
  }
  return program::kDone;
}

}  // namespace
}  // namespace stability_command

void add_stability(CLI::App& app, program::Program& program) {
  using namespace stability_command;
  program::Command command =
      program::add_command(app, program, "stability", "Map where each method fails",
                           R"(  taut stability scenes/rope_swing.toml
  taut stability scenes/rope_swing.toml --quick
  taut stability scenes/rope_swing.toml --methods springs,direct --budget 120
  taut stability scenes/rope_swing.toml --part 3/100

Interrupted maps resume when the same command is run again. Parts are separate processes, on any
machines that share the folder of results: each computes neighbouring cells, and --merge draws the
maps from them. --budget then only limits the time of one cell.)");
  const auto options = std::make_shared<options::StudyOptions>();
  options->features = options::study_features("stability");
  options::add_study_options(command, *options, kBudgets);
  program::add_part_options(command, options->part, "cells");
  command.callback([options, &program] {
    program.run = [options, &program] {
      options::choose_budget(*options, kBudgets);
      return options::for_each_study(
          *options, program.common,
          [&](const options::StudyOptions& one) { return run(one, program.common); });
    };
  });
}

}  // namespace taut::cli
