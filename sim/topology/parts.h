// Where the connectors that a world had at its start are, once some of them are cut.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "sim/world/connector.h"

namespace taut {

/// Each connector of the start is one part or, where it was cut, several in a row. Places are m of
/// its length at the start, from its first particle.
class Parts {
 public:
  explicit Parts(std::span<const Connector> start);

  struct Place {
    std::size_t connector = 0;  // of those that there are now
    double along = 0;           // m on it
  };
  Place at(std::size_t whole, double along) const;

  /// Notes that `connector` is new, and has all of what followed the place until the next cut.
  void cut(std::size_t whole, double along, std::size_t connector);

  struct Part {
    std::size_t whole = 0, connector = 0;
    double start = 0, end = 0;  // m on the whole
  };
  /// In the order in which they came to be: the connectors of the start first.
  const std::vector<Part>& all() const { return parts_; }
  /// The parts' indices as they follow each other, connector by connector of the start.
  std::vector<std::size_t> in_a_row() const;

 private:
  std::size_t part(std::size_t whole, double along) const;

  std::vector<Part> parts_;
  std::vector<std::multimap<double, std::size_t>> of_;  // [whole] its parts by where they start
};

}  // namespace taut
