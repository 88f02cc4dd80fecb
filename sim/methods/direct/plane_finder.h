// Finds the plane in which a component moves.
#pragma once

#include <optional>
#include <vector>

#include "sim/methods/direct/components.h"
#include "sim/methods/direct/plane.h"

namespace taut::direct {

/// Keeps its workspace.
class PlaneFinder {
 public:
  /// Room for components of so many links.
  void reserve(std::size_t links) { vectors_.reserve(2 * links + kOthers); }
  /// The plane in which a component moves as far as its present state and its holds at `time` tell,
  /// if System can step it there: each body hangs by one point and turns about the plane's normal.
  /// `also` is one more acceleration in that plane, or zero.
  std::optional<Plane> find(const World& world, const Component& component, double time,
                            const Vec3& also);

 private:
  static constexpr std::size_t kOthers = 16;  // vectors of holds and bodies
  std::vector<Vec3> vectors_, hints_;
};

}  // namespace taut::direct
