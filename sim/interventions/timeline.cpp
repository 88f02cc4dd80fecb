#include "sim/interventions/timeline.h"

#include <algorithm>
#include <sstream>

#include "sim/world/parts.h"

namespace taut {
std::vector<TimedCut> in_order_of_time(std::vector<TimedCut> cuts) {
  std::ranges::stable_sort(cuts, {}, &TimedCut::time);
  return cuts;
}

World divided(World world, const Timeline& timeline) {
  Parts parts(world.connectors);
  Interventions interventions;
  for (const TimedCut& cut : in_order_of_time(timeline.cuts)) {
    const auto [part, along] = parts.at(cut.connector, cut.along);
    if (interventions.cut(world, part, along).outcome == Outcome::done) {
      parts.cut(cut.connector, cut.along, world.connectors.size() - 1);
    }
  }
  return world;
}

BadIntervention::BadIntervention(Flaw found, double at, const std::string& source)
    : std::runtime_error([&] {
        std::ostringstream line;
        if (!source.empty()) line << source << ": ";
        line << (found.cut ? "cut " : "pin ") << found.index + 1 << ", at " << at
             << " s: " << found.what;
        return line.str();
      }()),
      flaw(std::move(found)),
      time(at) {}

}  // namespace taut
