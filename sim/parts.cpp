#include "sim/parts.h"

#include <algorithm>

namespace taut {

Parts::Parts(std::span<const Connector> start) {
  for (std::size_t c = 0; c < start.size(); ++c) parts_.push_back({c, c, 0, start[c].length});
}

const Parts::Part& Parts::part(std::size_t whole, double along) const {
  const auto has = [&](const Part& part) {
    return part.whole == whole && along >= part.start && along <= part.end;
  };
  const auto found = std::ranges::find_if(parts_, has);
  return found == parts_.end() ? parts_.at(whole) : *found;
}

Parts::Place Parts::at(std::size_t whole, double along) const {
  const Part& found = part(whole, along);
  return {found.connector, along - found.start};
}

void Parts::cut(std::size_t whole, double along, std::size_t connector) {
  Part& first = parts_[static_cast<std::size_t>(&part(whole, along) - parts_.data())];
  const Part second{whole, connector, along, first.end};
  first.end = along;
  parts_.push_back(second);
}

}  // namespace taut
