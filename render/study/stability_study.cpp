#include "render/study/stability_study.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>

#include "render/base/bounded.h"
#include "render/base/interrupt.h"
#include "render/program/journal.h"
#include "render/program/note.h"
#include "render/program/progress.h"
#include "render/study/study_target.h"

namespace taut::studies {
namespace {

/// CPU time shared out evenly among pieces of work: the rest of one goes to the others.
class Shares {
 public:
  Shares(double seconds, std::size_t pieces)
      : end_(render::process_seconds() + seconds), pieces_(pieces) {}
  /// The next piece's share, s.
  double next() {
    const double left = std::max(0.0, end_ - render::process_seconds());
    return left / static_cast<double>(std::max<std::size_t>(1, pieces_--));
  }

 private:
  double end_;  // s of CPU time of this process
  std::size_t pieces_;
};

/// One value of a map's axis.
struct Column {
  study::Problem problem;
  std::optional<truth::Reference> reference;
};

Column column_of(const options::StudyOptions& options, const MapAxis& axis, double value,
                 double duration, bool with_truth) {
  const scenes::Scene scene = axis.changes ? options::study_scene(options, axis.changes(value))
                                           : options::study_scene(options);
  Column column{{scene.world, study::frame_times(duration, scene.fps)}, {}};
  const Connector& rope = scene.world.connectors.front();
  if (with_truth && rope.particles() <= kMostForTruth) {
    column.reference = quick_reference(column.problem, 0.01 * rope.length, kTruthCap);
  }
  return column;
}

MapCell cell_from(std::size_t contender, double x, double y,
                  const std::vector<std::string>& cells) {
  MapCell cell{contender, x, y, {}, cells.at(5), cells.at(6) == "over"};
  cell.classification.motion_class =
      static_cast<study::MotionClass>(program::number_in(cells.at(0)));
  cell.classification.gain = program::number_in(cells.at(1));
  cell.classification.loss = program::number_in(cells.at(2));
  cell.classification.stretch = program::number_in(cells.at(3));
  cell.classification.error = program::number_in(cells.at(4));
  return cell;
}

std::vector<std::string> cells_of(const MapCell& cell) {
  const study::Classification& j = cell.classification;
  return {std::to_string(static_cast<int>(j.motion_class)),
          program::exact(j.gain),
          program::exact(j.loss),
          program::exact(j.stretch),
          program::exact(j.error),
          cell.reason,
          cell.over ? "over" : "in time"};
}

std::string key_of(const MapAxis& axis, const options::Contender& contender, double x, double y) {
  return fmt::format("{} {} {} {}", axis.name, contender.label, program::exact(x),
                     program::exact(y));
}

/// The heights of a contender's cells, from cheap to dear.
std::vector<double> heights_of(const options::Contender& contender, bool quick) {
  std::vector<double> heights = map_heights(*map_height(*contender.method), quick);
  std::ranges::reverse(heights);
  return heights;
}

MapCell cell_not_run(std::size_t index, double x, double y) {
  MapCell cell{index, x, y, {}, "not run: a cheaper one was over its CPU cap", true};
  cell.classification.motion_class = study::MotionClass::over_cap;
  return cell;
}

/// A run's place in the map, with its class.
MapCell cell_of(const MapAxis& axis, std::size_t index, const StabilityStudy& study,
                const Column& column, double x, double y, double cap) {
  const options::Contender& contender = study.contenders[index];
  MethodChoice candidate = contender.candidate;
  candidate.settings[std::string(map_height(*contender.method)->name)] = y;
  if (!axis.setting.empty()) candidate.settings[axis.setting] = x;
  const study::Run result = taut::study::run(column.problem, candidate, cap);
  const truth::Reference* reference = column.reference ? &*column.reference : nullptr;
  return {index,
          x,
          y,
          study::classify(column.problem, result, reference),
          result.reason,
          result.end == study::Run::End::over_cap};
}

/// Runs a contender over a map's cells, or takes them from the journal. Within `seconds` of CPU
/// time; a cell is not run where one that costs less was over its cap.
void fill(StabilityMap& map, std::size_t index, const StabilityStudy& study,
          const std::vector<Column>& columns, double seconds, program::Journal& journal,
          const std::function<void()>& finished) {
  const options::Contender& contender = study.contenders[index];
  const std::vector<double> heights = heights_of(contender, study.quick);
  std::vector<bool> over_before(heights.size(), false);
  const double start = render::process_seconds();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double x = map.axis.values[i];
    bool over = false;  // in this column
    for (std::size_t h = 0; h < heights.size(); ++h) {
      render::stop_if_interrupted();
      const double y = heights[h];
      const std::string key = key_of(map.axis, contender, x, y);
      over = over || (map.axis.dearer && over_before[h]);
      const double left = seconds - (render::process_seconds() - start);
      MapCell cell = cell_not_run(index, x, y);
      const auto* const cells = journal.find(key);
      if (cells && !over) {
        cell = cell_from(index, x, y, *cells);
      } else if (!cells) {
        if (!over && left > 0) {
          cell = cell_of(map.axis, index, study, columns[i], x, y, std::min(left, study.cap));
        }
        journal.add(key, cells_of(cell));
      }
      over = over_before[h] = cell.over;
      map.cells.push_back(std::move(cell));
      finished();
    }
  }
}

bool is_mapped(const options::Contender& contender, const MapAxis& axis) {
  return contender.method->missing.empty() && map_height(*contender.method) &&
         takes_part(contender, axis);
}

/// Where a cell is in the maps.
struct CellPlace {
  std::size_t axis = 0, column = 0, contender = 0, height = 0;
};

/// All cells, neighbours in a column beside each other: they share its truth.
std::vector<CellPlace> all_places(const StabilityStudy& study, const std::vector<MapAxis>& axes) {
  std::vector<CellPlace> places;
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (std::size_t i = 0; i < axes[a].values.size(); ++i) {
      for (std::size_t c = 0; c < study.contenders.size(); ++c) {
        if (!is_mapped(study.contenders[c], axes[a])) continue;
        const std::size_t heights = heights_of(study.contenders[c], study.quick).size();
        for (std::size_t h = 0; h < heights; ++h) places.push_back({a, i, c, h});
      }
    }
  }
  return places;
}

program::Pieces shared_work(const StabilityStudy& study, const std::vector<MapAxis>& axes,
                            const std::vector<CellPlace>& places) {
  program::Pieces pieces{"stability", "cells", program::Share::neighbours, {}};
  for (const CellPlace& at : places) {
    const options::Contender& contender = study.contenders[at.contender];
    pieces.keys.push_back(key_of(axes[at.axis], contender, axes[at.axis].values[at.column],
                                 heights_of(contender, study.quick)[at.height]));
  }
  return pieces;
}

}  // namespace

StabilityStudy stability_study(const options::StudyOptions& options, const scenes::Scene& scene) {
  StabilityStudy study;
  study.scene = options.scene;
  study.title = scene.title;
  study.set = options.inputs.set;
  study.quick = options.quick;
  study.scored = !options.quick;
  study.duration = options.quick ? 0.5 : 1.0;
  study.contenders = options::chosen_contenders(options);
  const std::size_t total = all_places(study, map_axes(options, scene)).size();
  // Most cells take far less than their share, so a cell may take several.
  study.cap = 8 * options.budget / static_cast<double>(std::max<std::size_t>(1, total));
  return study;
}

program::Journal map_all(StabilityStudy& study, const options::StudyOptions& options,
                         const scenes::Scene& scene, const std::filesystem::path& folder,
                         const std::string& journal_name, const program::Common& common,
                         const std::function<void(const StabilityMap&)>& mapped) {
  const bool merge = options.part.merge;
  const std::vector<MapAxis> axes = map_axes(options, scene);
  const std::vector<CellPlace> places = all_places(study, axes);
  std::size_t pieces = 0;
  for (const MapAxis& axis : axes) {
    pieces += std::size_t(std::ranges::count_if(
        study.contenders, [&](const options::Contender& one) { return is_mapped(one, axis); }));
  }
  program::Journal journal =
      merge ? program::merged_journal(shared_work(study, axes, places), folder,
                                      options::stamp_of(options))
            : program::Journal(folder / journal_name, options::stamp_of(options));
  if (!common.quiet && journal.kept() > 0 && !merge) {
    program::note("going on after {} cells of maps that were stopped\n", journal.kept());
  }
  {
    program::Progress progress(merge ? "merging" : "mapping", "cells", places.size(), common.quiet);
    Shares shares(options.budget, pieces);
    std::size_t done = 0;
    for (const MapAxis& axis : axes) {
      StabilityMap map{axis, {}, {}};
      std::vector<Column> columns;
      for (const double value : axis.values) {
        render::stop_if_interrupted();
        columns.push_back(column_of(options, axis, value, study.duration, study.scored && !merge));
        map.worlds.push_back(columns.back().problem.world);
      }
      for (std::size_t c = 0; c < study.contenders.size(); ++c) {
        if (!is_mapped(study.contenders[c], axis)) continue;
        fill(map, c, study, columns, shares.next(), journal, [&] { progress.update(++done); });
      }
      if (mapped) mapped(map);
      study.maps.push_back(std::move(map));
    }
  }
  return journal;
}

int map_part(const StabilityStudy& study, const options::StudyOptions& options,
             const scenes::Scene& scene, const program::Common& common) {
  const std::vector<MapAxis> axes = map_axes(options, scene);
  const std::vector<CellPlace> places = all_places(study, axes);
  std::optional<Column> column;
  CellPlace of_column;
  const auto work = [&](std::size_t i, const program::Journal& journal) {
    const CellPlace at = places[i];
    const MapAxis& axis = axes[at.axis];
    const options::Contender& contender = study.contenders[at.contender];
    const std::vector<double> heights = heights_of(contender, study.quick);
    const double x = axis.values[at.column], y = heights[at.height];
    // Runs that merging leaves out need not be made, as far as this part can tell.
    const auto is_over = [&](double left, double below) {
      const auto* cells = journal.find(key_of(axis, contender, left, below));
      return cells && cell_from(at.contender, left, below, *cells).over;
    };
    if ((at.height > 0 && is_over(x, heights[at.height - 1])) ||
        (axis.dearer && at.column > 0 && is_over(axis.values[at.column - 1], y))) {
      return cells_of(cell_not_run(at.contender, x, y));
    }
    if (!column || of_column.axis != at.axis || of_column.column != at.column) {
      column = column_of(options, axis, x, study.duration, study.scored);
      of_column = at;
    }
    return cells_of(cell_of(axis, at.contender, study, *column, x, y, study.cap));
  };
  return program::do_part(options.part, shared_work(study, axes, places),
                          options::study_folder(options), options::stamp_of(options), common, work);
}

}  // namespace taut::studies
