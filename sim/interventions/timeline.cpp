#include "sim/interventions/timeline.h"

#include <algorithm>
#include <sstream>

#include "sim/motion/printable.h"
#include "sim/topology/parts.h"

namespace taut {
std::vector<TimedCut> in_order_of_time(std::vector<TimedCut> cuts) {
  std::ranges::stable_sort(cuts, {}, &TimedCut::time);
  return cuts;
}

World divided(World world, const Timeline& timeline) {
  Parts parts(world.connectors);
  Interventions interventions;
  const std::vector<TimedCut> cuts = in_order_of_time(timeline.cuts);
  std::vector<double> along;
  for (std::size_t i = 0; i < cuts.size();) {
    const std::size_t part = parts.at(cuts[i].connector, cuts[i].along).connector;
    std::size_t end = i;
    along.clear();
    for (; end < cuts.size() && cuts[end].connector == cuts[i].connector; ++end) {
      const Parts::Place place = parts.at(cuts[end].connector, cuts[end].along);
      if (place.connector != part) break;
      along.push_back(place.along);
    }
    std::size_t made = world.connectors.size();
    if (interventions.cut(world, part, along)) {
      for (; i < end; ++i) parts.cut(cuts[i].connector, cuts[i].along, made++);
      continue;
    }
    for (; i < end; ++i) {
      const auto [connector, place] = parts.at(cuts[i].connector, cuts[i].along);
      const Divided divided = interventions.cut(world, connector, place);
      if (divided.outcome == Outcome::done) {
        parts.cut(cuts[i].connector, cuts[i].along, divided.connector);
      }
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
        return printable(line.str());
      }()),
      flaw(std::move(found)),
      time(at) {}

}  // namespace taut
