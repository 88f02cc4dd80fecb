// Points by which motions are compared, whatever chain of particles stands for the connector.
#pragma once

#include <memory>
#include <vector>

#include "sim/run/trajectory.h"
#include "sim/world/world.h"

namespace taut::study {

/// The material points of one world: every particle of its connectors, and of each body the ends of
/// the box with its mass and inertia (for a stick, the ends of the stick).
class SamplePoints {
 public:
  /// `start`: the state at the beginning, from which lengths along the connectors are taken.
  SamplePoints(const World& world, const Snapshot& start);

  /// Where the sample points of `of` are in a state of this world (m). Connectors and bodies must
  /// be those of `of`; a connector may have another number of particles, between which its links
  /// are straight. Where winches and pulleys change a connector's length, a point keeps its share
  /// of that, by which material flows past it.
  std::vector<Vec3> places(const SamplePoints& of, const Snapshot& state) const;

 private:
  /// A connector whose length changes.
  struct Running {
    std::shared_ptr<const Winch> winch;
    std::vector<std::size_t> enters, leaves;  // pulleys, by which rope comes and goes
  };
  /// The shares of the length at which a connector's particles are in a state of either world.
  std::vector<double> along(std::size_t connector, const Snapshot& state) const;

  std::vector<std::vector<double>> along_;  // [connector][particle], share of the length at first
  std::vector<Running> running_;            // [connector], without a winch where it keeps that
  std::vector<std::vector<Vec3>> ends_;     // [body], m, body frame
};

}  // namespace taut::study
