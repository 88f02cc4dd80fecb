// The components of a world, each with the integrator that follows it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sim/links/projection.h"
#include "sim/methods/direct/integrator.h"
#include "sim/run/method.h"

namespace taut::direct {

/// Integrators stay with their components for as long as these move alike, whatever is done to
/// others.
class FollowedParts {
 public:
  explicit FollowedParts(const StepOptions& options) : options_(options) {}

  /// Divides the world anew; loads nothing.
  void rebuild(const World& world);
  /// Loads all of them.
  void load(World& world);

  /// Marks the components that have these places, where something is about to be done. False where
  /// that may change others, too, or none can be told from another afterwards.
  bool mark(const World& world, std::span<const Parts::Place> places);
  /// Divides again once it is done. Components that were not marked go on from their own time, the
  /// others begin anew.
  void renew(World& world);

  std::span<const std::unique_ptr<Integrator>> all() const {
    return {integrators_.data(), followed_};
  }
  /// All have room for more, as interventions may come.
  bool changes() const { return changes_; }
  /// Those that mark() has found, and bodies that hold the same connectors.
  bool is_near(std::size_t part) const { return marks_[part] != Mark::none; }
  /// More than are followed.
  std::span<const std::unique_ptr<Integrator>> made() const { return integrators_; }

 private:
  /// The pins at either end of its one span, or where there are none its connector or its body.
  using Key = std::array<std::uint64_t, 3>;
  struct Known {
    Key key;
    std::size_t part = 0;
  };
  enum class Mark : char { none, beside, changed };

  void align(std::span<const Component> parts);
  void make_room(const World& world, std::span<const Component> parts);
  void know(const World& world, std::span<const Component> parts);
  void begin(World& world, Integrator& part);

  StepOptions options_;
  Division division_;
  std::vector<std::unique_ptr<Integrator>> integrators_, arranged_;  // the followed ones first
  std::size_t followed_ = 0;
  std::vector<std::size_t> links_;     // of the parts that are followed
  bool changes_ = false;               // interventions may come, for which room is kept
  std::vector<Known> known_, before_;  // by key
  bool distinct_ = false;              // all keys are, and no part has several spans
  std::vector<Mark> marks_;            // of the parts that are followed
  VelocityProjection velocity_projection_;
};

}  // namespace taut::direct
