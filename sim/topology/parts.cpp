#include "sim/topology/parts.h"

#include <algorithm>
#include <iterator>

namespace taut {

Parts::Parts(std::span<const Connector> start) {
  for (std::size_t c = 0; c < start.size(); ++c) {
    parts_.push_back({c, c, 0, start[c].length});
    of_.push_back({{0, c}});
  }
}

/// Where two parts meet it is the older one.
std::size_t Parts::part(std::size_t whole, double along) const {
  const auto& row = of_.at(whole);
  const auto after = row.upper_bound(along);
  if (after == row.begin()) return whole;
  const auto found = std::prev(after);
  if (along > parts_[found->second].end) return whole;
  const bool shared = found != row.begin() && parts_[std::prev(found)->second].end == along;
  return shared ? std::min(found->second, std::prev(found)->second) : found->second;
}

Parts::Place Parts::at(std::size_t whole, double along) const {
  const Part& found = parts_[part(whole, along)];
  return {found.connector, along - found.start};
}

void Parts::cut(std::size_t whole, double along, std::size_t connector) {
  const std::size_t first = part(whole, along);
  of_.at(whole).emplace(along, parts_.size());
  parts_.push_back({whole, connector, along, parts_[first].end});
  parts_[first].end = along;
}

std::vector<std::size_t> Parts::in_a_row() const {
  std::vector<std::size_t> order;
  order.reserve(parts_.size());
  for (const auto& row : of_) {
    for (const auto& [start, part] : row) order.push_back(part);
  }
  return order;
}

}  // namespace taut
