// The impulses between the ends of a span: section IV.A of the paper.
#pragma once

#include <vector>

#include "sim/methods/span_path.h"
#include "sim/motion/rotation.h"
#include "sim/run/method.h"
#include "sim/topology/span.h"

namespace taut::methods {

/// The limits between which the ends of a link may be, as parts of its rest length. A span of more
/// than one link folds, so that only the longest applies to it.
struct LinkLimits {
  double shortest = 1;
  double longest = 1;
};

class SpanImpulses {
 public:
  SpanImpulses(LinkLimits limits, bool as_printed) : limits_(limits), as_printed_(as_printed) {}

  /// Reads the bodies' mass properties; call whenever they or the world's topology change.
  void prepare(const World& world);

  /// Notes where the span has gone slack in a free flight that ended at `time` (s).
  void watch(const World& world, Span& span, double time, std::vector<Event>& events) const;

  /// Lets the span's ends interact after a free flight of `dt` (s) that ended at `time` (s). True
  /// where that moved anything. Appends what an observer would see to `events`.
  bool act(World& world, Span& span, double time, double dt, std::vector<Event>& events) const;

  /// The same for a span whose pull goes around corners.
  void watch_around(const World& world, Span& span, const SpanPath& path, double time,
                    std::vector<Event>& events) const;
  bool act_around(World& world, Span& span, const SpanPath& path, double time, double dt,
                  std::vector<Event>& events) const;
  /// What the corners do to the span.
  SpanPath::State grip(World& world, const Span& span, const SpanPath& path) const;

  const FreeRotation& rotation(std::size_t body) const { return rotations_[body]; }

 private:
  LinkLimits limits_;
  bool as_printed_;
  std::vector<FreeRotation> rotations_;  // one per body
};

}  // namespace taut::methods
