// Stability maps: their axes, the runs behind them, tables, charts and a page.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "render/options/study_options.h"
#include "render/program/command.h"
#include "render/program/part.h"
#include "sim/study/stability.h"

namespace taut::studies {

// The axes of stability maps: a property of the scene or a setting along the map, and the step, or
// another setting of a method without one, up it.

struct MapAxis {
  std::string name;   // "mass_ratio"; in file names
  std::string label;  // with the unit
  bool log = true;
  std::vector<double> values;  // rising
  /// The changes to the scene by a value; null: none.
  std::function<std::vector<scenes::SceneChange>(double)> changes;
  /// The setting that is the value, of those methods that have it; empty: none.
  std::string setting;
  /// Every value costs at least as much as the one before.
  bool dearer = false;
};

/// The axes that the scene has: mass ratio where it carries a load, start angle and driven speed
/// where it hangs from one fixed point, the stiffnesses of its material where it has one. Every
/// other value where the options ask for a quick answer.
std::vector<MapAxis> map_axes(const options::StudyOptions& options, const scenes::Scene& scene);

/// True where the map of `axis` shows the contender.
bool takes_part(const options::Contender& contender, const MapAxis& axis);

/// The setting that maps show upwards: the step or, where sweeps leave that alone, the first number
/// that they go through. Null where there is none.
const SettingInfo* map_height(const MethodInfo& method);
/// The values of map_height(), rising.
std::vector<double> map_heights(const SettingInfo& setting, bool quick);

// The results of `taut stability` as a table, charts and a page.

/// Particles beyond which the truth costs more than the map, so that cells are not told accurate
/// from plausible; and the CPU time (s) that each of its two solvers may take.
inline constexpr std::size_t kMostForTruth = 64;
inline constexpr double kTruthCap = 2;

struct MapCell {
  std::size_t contender = 0;  // index
  double x = 0, y = 0;        // values of the map's axis and of the height
  study::Classification classification;
  std::string reason;  // of an end before the end
  bool over = false;   // it ran over its CPU cap, or was not run since a cheaper one did
};

/// Classes of all contenders along one axis.
struct StabilityMap {
  MapAxis axis;
  std::vector<World> worlds;  // one per value, for the theory's line
  std::vector<MapCell> cells;
};

struct StabilityStudy {
  std::string scene, title;
  std::vector<std::string> set;  // of --set
  double duration = 0;           // s, of each run
  double cap = 0;                // s of CPU time, the most that a cell may take
  bool scored = true;            // there was a truth to tell accurate from plausible
  bool quick = false;
  std::vector<options::Contender> contenders;
  std::vector<StabilityMap> maps;
};

chart::Table stability_table(const StabilityStudy& study);
chart::Chart stability_chart(const StabilityStudy& study, const StabilityMap& map);
/// The result of all maps, in a sentence.
std::string stability_finding(const StabilityStudy& study);
/// The study's section of a page: its maps.
std::string stability_section(const StabilityStudy& study);
/// One HTML page that needs no other file.
std::string stability_page(const StabilityStudy& study);
std::string stability_json(const StabilityStudy& study);

/// The subject of a study of the options, without cells.
StabilityStudy stability_study(const options::StudyOptions& options, const scenes::Scene& scene);

/// Fills the maps within the options' budget, or from all parts where they say so, and calls
/// `mapped` for each that is complete. Cells that were done are in `journal` of the folder; returns
/// it, to be finished once results are written.
program::Journal map_all(StabilityStudy& study, const options::StudyOptions& options,
                         const scenes::Scene& scene, const std::filesystem::path& folder,
                         const std::string& journal, const program::Common& common,
                         const std::function<void(const StabilityMap&)>& mapped);

/// The cells of the options' part.
int map_part(const StabilityStudy& study, const options::StudyOptions& options,
             const scenes::Scene& scene, const program::Common& common);

}  // namespace taut::studies
