// The ties of a world's connectors, found without a look at the rest of the world.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sim/world/places.h"
#include "sim/world/state.h"

namespace taut {

/// The joints on each connector, and the connectors that each free body holds. Whoever adds,
/// removes or moves particles and holds tells it, so that each change costs what it touches.
class Ties {
 public:
  /// Room for so many connectors, and holds of free bodies.
  void reserve(const World& world, std::size_t connectors, std::size_t holds);
  /// Looks at the whole world, unless it is as the last change has left it.
  void follow(const World& world);
  /// The world is as follow() would find it.
  void followed(const World& world) { topology_ = world.topology; }

  /// As find_joint(), joined_mass() and laden() find them.
  const Joint* find_joint(const World& world, std::size_t connector, std::size_t particle) const;
  double joined_mass(const World& world, std::size_t connector, std::size_t particle) const;
  MassProperties laden(const World& world, std::size_t body) const;

  /// Takes what is joined with the particle to where that is which stands for it.
  void place_joined(World& world, std::size_t connector, std::size_t particle) const;

  /// Keeps joints at their particles, and the topology with them, where some have been added at
  /// places of a connector, or `removed` from it, as add_particles() and remove_particles() do; or
  /// where those from `first` on are now `second`.
  void particles_added(World& world, std::size_t connector, std::span<const Place> places);
  void particles_removed(World& world, std::size_t connector, std::span<const std::size_t> removed);
  /// `second` has its holds.
  void connector_divided(World& world, std::size_t connector, std::size_t first,
                         std::size_t second);

  /// A connector was added, which nothing is tied to.
  void connector_added() { ties_.push_back(kNone); }

  /// A free body holds the connector at one more place, or one less.
  void held(std::size_t connector, std::size_t body);
  void let_go(std::size_t connector, std::size_t body);

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;
  struct Tie {  // of a joint's particle
    std::uint32_t joint, particle, next;
  };
  struct Holder {
    std::uint32_t connector, next;
  };
  void each(World& world, std::size_t connector, auto change);

  std::uint64_t topology_ = 0;       // of the world that this knows
  std::vector<std::uint32_t> ties_;  // [connector] the first of its joints' particles
  std::vector<Tie> tie_;
  std::vector<std::uint32_t> holders_;  // [body] the first of its holders, connectors rising
  std::vector<Holder> holder_;
  std::uint32_t spare_ = kNone;  // the first of those that are not in use
};

}  // namespace taut
