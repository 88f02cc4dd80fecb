#include "sim/world/parts.h"

#include <algorithm>

namespace taut {

Parts::Parts(std::span<const Connector> start) {
  for (std::size_t c = 0; c < start.size(); ++c) {
    parts_.push_back({c, c, 0, start[c].length});
    of_.push_back({c});
  }
}

/// Where two parts meet it is the older one.
std::size_t Parts::part(std::size_t whole, double along) const {
  const std::vector<std::size_t>& row = of_.at(whole);
  const auto after = std::ranges::upper_bound(row, along, {},
                                              [&](std::size_t part) { return parts_[part].start; });
  if (after == row.begin()) return whole;
  const auto found = std::prev(after);
  if (along > parts_[*found].end) return whole;
  const bool shared = found != row.begin() && parts_[*std::prev(found)].end == along;
  return shared ? std::min(*found, *std::prev(found)) : *found;
}

Parts::Place Parts::at(std::size_t whole, double along) const {
  const Part& found = parts_[part(whole, along)];
  return {found.connector, along - found.start};
}

void Parts::cut(std::size_t whole, double along, std::size_t connector) {
  const std::size_t first = part(whole, along);
  std::vector<std::size_t>& row = of_.at(whole);
  row.insert(std::ranges::find(row, first) + 1, parts_.size());
  parts_.push_back({whole, connector, along, parts_[first].end});
  parts_[first].end = along;
}

}  // namespace taut
