// The results of `taut stability` as a table, charts and a page.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "render/study/stability_axes.h"
#include "sim/study/stability.h"

namespace taut::studies {

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

}  // namespace taut::studies
