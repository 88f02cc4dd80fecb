// Massless spans as strings of one link, for steps that know no spans.
#pragma once

#include <cstddef>
#include <vector>

#include "sim/topology/span.h"
#include "sim/world/hanging.h"
#include "sim/world/world.h"

namespace taut::direct {

/// A copy of a world in which each massless span is a connector of its own: a string of one link
/// between the same ends, with the same restitution. The first span of a connector has the
/// connector's index, the others follow behind all. Ends that nothing holds and that have no mass
/// get a millionth of what the lightest particle or body has.
class SpansAsStrings {
 public:
  /// Call first, and whenever the topology is new.
  void rebuild(const World& world);
  /// Takes the state of the world that the copy was made of, and gives it the copy's.
  void read(const World& world);
  void write(World& world);
  World& world() { return strings_; }
  struct Place {
    Span span;
    std::size_t string = 0;  // index of a connector of world()
  };
  const std::vector<Place>& places() const { return places_; }

 private:
  std::vector<Place> places_;
  World strings_;
  HangingChain hanging_;
};

}  // namespace taut::direct
