// Ends of connectors that are joined to others, as a scene names them.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "scenes/reader/common.h"
#include "sim/world/world.h"

namespace taut::scenes {

/// The joined ends of a scene's connectors.
class JoinedEnds {
 public:
  /// Looks at the ends of all connectors; those of `world` have their lengths and particles. Throws
  /// BadScene where an end names no particle that it can be joined to.
  JoinedEnds(const Document& document, const Value* connectors, const World& world);

  /// The particle that the connector's first or last particle is joined to.
  std::optional<Joint::Particle> target(std::size_t connector, std::size_t particle) const;
  /// The connectors that have an end on this one.
  const std::vector<std::size_t>& joined_to(std::size_t connector) const {
    return joined_to_[connector];
  }
  /// True where the last particle of a connector is joined to its first.
  bool is_loop(std::size_t connector, std::size_t last) const;

  /// Joins them. Throws BadScene where connectors that have their shapes are elsewhere.
  void join(World& world) const;

 private:
  struct End {
    const Value* value;  // `from` or `to`
    Joint::Particle own, other;
  };
  void read(const Names& names, const World& world, const Value& end, Joint::Particle own);

  const Document& document_;
  std::vector<End> ends_;
  std::vector<std::vector<std::size_t>> joined_to_;                   // per connector
  std::map<std::pair<std::size_t, std::size_t>, std::size_t> index_;  // of own particles
};

}  // namespace taut::scenes
