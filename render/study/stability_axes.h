// The axes of stability maps: a property of the scene or a setting along the map, and the step, or
// another setting of a method without one, up it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "render/options/study_options.h"

namespace taut::studies {

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

}  // namespace taut::studies
