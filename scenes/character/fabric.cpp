#include "scenes/character/fabric.h"

#include <algorithm>
#include <array>

namespace taut::scenes {
namespace {

// Heavy cotton, doubled at the hem and the cuffs; the belt is sewn of several layers.
constexpr std::array<Fabric, 3> fabrics = {
    Fabric{"Skirt", 0.06, 0.002, 0.10, 10, "UpLeg", 0.022},
    Fabric{"Cuff", 0.04, 0.002, 0.06, 0, "ForeArm", 0.010},
    Fabric{"Tail", 0.08, 0.002, 0.04, 0, "SkirtFront", 0.026}};

}  // namespace

std::string_view without_side(std::string_view bone) {
  for (const std::string_view side : {"Left", "Right"})
    if (bone.starts_with(side)) return bone.substr(side.size());
  return bone;
}

const Fabric* fabric_of(std::string_view bone) {
  const auto found = std::ranges::find_if(
      fabrics, [&](const Fabric& fabric) { return without_side(bone).starts_with(fabric.name); });
  return found == fabrics.end() ? nullptr : &*found;
}

}  // namespace taut::scenes
