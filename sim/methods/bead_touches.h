// What beads touch in a step of `impulse`, and what the surfaces let them do.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/contact/touch.h"
#include "sim/world/world.h"

namespace taut::methods {

/// A bead that may touch something in a step: after its flight it is inside of an obstacle, or no
/// farther outside than it goes in a step.
struct TouchingBead {
  /// To what its connector does there (SpanPath).
  enum class Role {
    free,  // nothing: the surface's friction is the bead's own matter
    held,  // it is stuck to the surface, and divides the connector as a pin does
    led,   // it goes where its connector slides, which has had its friction
  };
  static constexpr std::size_t kMost = 3;  // surfaces at a bead

  std::size_t connector = 0, particle = 0;
  Role role = Role::free;
  std::size_t inside = 0, count = 0;  // touches: those first that the flight ended inside of
  std::array<contact::Touch, kMost> touch;
  std::array<std::size_t, kMost> obstacle{};
  /// m, from the surfaces, zero inside: after the flight, and before it had they moved by then.
  std::array<double, kMost> apart{}, apart_before{};
  Vec3 started = Vec3::Zero();  // m, before the flight
  /// Where repositioning finds it, m and m/s.
  Vec3 place = Vec3::Zero(), velocity = Vec3::Zero();
};

/// Contact at the end of a step: what is inside of an obstacle is placed on its surface. Of first
/// order in the step; what passes an obstacle within a step is not stopped.
class BeadTouches {
 public:
  /// Call when the topology is new.
  void prepare(const World& world);

  bool any() const { return !obstacles_.empty(); }
  std::vector<TouchingBead>& beads() { return beads_; }
  const TouchingBead* find(std::size_t connector, std::size_t particle) const {
    if (!any()) return nullptr;
    const std::uint32_t index = index_[first_[connector] + particle];
    return index == kNone ? nullptr : &beads_[index];
  }

  /// After a flight of `dt` (s) that ended at `time` (s): finds the beads, and gives those inside
  /// what the surfaces do to a ball by itself.
  void land(World& world, double time, double dt);
  /// The same for what has pulled the bead since, in the same step. True where that changes it.
  bool press(World& world, TouchingBead& bead, double dt) const;
  /// Sticks the bead to its first surface, which carries it from where it was before the flight.
  void hold(World& world, TouchingBead& bead, double dt) const;
  /// Notes where repositioning begins.
  void begin_repositioning(const World& world, double dt);
  /// Where the surfaces let links take a bead that these would place at `wanted` (m).
  static Vec3 allowed(const TouchingBead& bead, const Vec3& wanted, double dt);
  /// After repositioning from where the connectors' particles had `flown`, with the velocities from
  /// positions: no bead stays inside, and no depth makes a speed.
  void finish(World& world, const std::vector<std::vector<Vec3>>& flown, double dt) const;

 private:
  static constexpr std::uint32_t kNone = UINT32_MAX;

  contact::Touch meet(std::size_t obstacle, const Vec3& at, const Vec3& normal) const;
  void keep_out(Connector& connector, std::size_t index, std::size_t particle, const Vec3& flown,
                double dt) const;
  void place_out(const TouchingBead& bead, double radius, Vec3& at) const;

  std::vector<Obstacle> obstacles_;
  std::vector<FrameMotion> frames_;  // of these, at the step's end
  std::vector<TouchingBead> beads_;
  std::vector<std::size_t> first_;    // per connector, its first particle in index_
  std::vector<std::uint32_t> index_;  // per particle: in beads_
  std::vector<char> touches_;         // per particle: nothing holds it
};

}  // namespace taut::methods
