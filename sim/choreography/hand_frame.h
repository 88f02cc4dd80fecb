// Where a hand is that leads a connector's end, and how it turns.
#pragma once

#include <cmath>
#include <memory>
#include <optional>

#include "sim/choreography/flat_chain.h"

namespace taut::choreography {

/// A path carries the end at a lever from its origin. The lever points away from a pivot that
/// rests, as a stick in a hand turns about the elbow; with the pivot infinitely far it keeps its
/// direction.
class HandFrame {
 public:
  /// Of the connector that the body hangs by, at the pose of its driver's last key; the pivot is
  /// `pivot` (m) behind the end.
  HandFrame(const World& world, std::size_t body, double pivot);

  /// The path's origin, from the series of the end that it leads.
  TaylorSeries origin(const TaylorSeries& end) const;
  /// The path's rotation; without spin about the lever.
  Quat rotation(const Vec3& end) const;

  /// The place that the lever points away from (m); nothing where there is none.
  std::optional<Vec3> pivot() const {
    return turns() ? std::optional<Vec3>(rest_ - pivot_ * along_) : std::nullopt;
  }
  /// Where the end is at rest (m).
  const Vec3& rest() const { return rest_; }

 private:
  bool turns() const { return lever_ > 0 && std::isfinite(pivot_); }

  Vec3 rest_, along_;  // m; of the lever at rest, a unit vector
  Quat rest_rotation_;
  double lever_ = 0, pivot_ = 0;  // m
};

/// The path that drives the connector of that body.
std::shared_ptr<const Path> hand_path(const World& world, std::size_t body);

}  // namespace taut::choreography
