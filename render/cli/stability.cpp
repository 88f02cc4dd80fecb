// taut stability: where each method fails, as maps.
#include <algorithm>
#include <memory>

#include "render/atomic_file.h"
#include "render/chart/gnuplot.h"
#include "render/program/command.h"
#include "render/program/note.h"
#include "render/program/terminal.h"
#include "render/study/stability_study.h"

namespace taut::cli {
namespace {

/// How many cells of all maps each method has of each class.
Table class_table(const StabilityStudy& study) {
  constexpr MotionClass kClasses[] = {MotionClass::accurate,    MotionClass::plausible,
                                      MotionClass::over_damped, MotionClass::stretched,
                                      MotionClass::failed,      MotionClass::over_cap};
  Table table{{"cells"}, {}};
  for (const MotionClass one : kClasses) table.columns.emplace_back(name_of(one));
  for (std::size_t c = 0; c < study.contenders.size(); ++c) {
    std::vector<std::string> row{study.contenders[c].label};
    for (const MotionClass one : kClasses) {
      std::ptrdiff_t count = 0;
      for (const StabilityMap& map : study.maps)
        count += std::ranges::count_if(map.cells, [&](const MapCell& cell) {
          return cell.contender == c && cell.classification.motion_class == one;
        });
      row.push_back(std::to_string(count));
    }
    table.add(std::move(row));
  }
  return table;
}

int run(const StudyOptions& options, const Common& common) {
  const Scene scene = study_scene(options);
  StabilityStudy study = stability_study(options, scene);
  if (options.part.is_part()) return map_part(study, options, scene, common);
  require_gnuplot();
  const std::filesystem::path folder = study_folder(options);
  Journal journal = map_all(
      study, options, scene, folder, "stability.unfinished", common, [&](const StabilityMap& map) {
        write_chart(stability_chart(study, map), folder / ("stability_" + map.axis.name));
      });
  write_csv(stability_table(study), folder / "stability");
  AtomicFile page(folder / "stability.html");
  page.write(stability_page(study));
  page.commit();
  if (!options.part.merge) journal.finish();
  write_output(common.json ? stability_json(study) : table_text(class_table(study)));
  if (!common.quiet) {
    note("{}/stability: .html .csv, and a .svg and .png per map\n", folder.string());
  }
  return kDone;
}

}  // namespace

void add_stability(CLI::App& app, Program& program) {
  Command command = add_command(app, program, "stability", "Where each method fails, as maps",
                                R"(  taut stability scenes/rope_swing.toml
  taut stability scenes/rope_swing.toml --quick
  taut stability scenes/rope_swing.toml --methods springs,direct --budget 120
  taut stability scenes/rope_swing.toml --part 3/100

Maps that are stopped go on where they were when the same command is given again. Parts are
processes of their own, on any machines that share the folder of results: each takes neighbouring
cells, and --merge draws the maps from them. --budget then only sets how long one cell may take.)");
  const auto options = std::make_shared<StudyOptions>();
  add_study_options(command, *options, 480);
  add_part_options(command, options->part, "cells");
  command.callback([options, &program] {
    program.run = [options, &program] {
      if (options->quick) options->budget = std::min(options->budget, 20.0);
      return for_each_study(*options, program.common,
                            [&](const StudyOptions& one) { return run(one, program.common); });
    };
  });
}

}  // namespace taut::cli
