// The components of a world, each with the integrator that follows it.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <vector>

#include "sim/links/tension.h"
#include "sim/methods/direct/integrator.h"
#include "sim/run/method.h"

namespace taut::direct {

/// Integrators stay with their components for as long as these move alike, whatever is done to
/// others.
class FollowedParts {
 public:
  explicit FollowedParts(const StepOptions& options) : options_(options) {}

  /// Divides the world anew; loads nothing. Connectors that stretch, bend or meet the air are left
  /// to others.
  void rebuild(const World& world);
  /// Loads all of them.
  void load(World& world);

  /// Finds the components that have these places, where something is about to be done. False where
  /// that may change others, too, or none can be told from another afterwards.
  bool mark(const World& world, std::span<const Parts::Place> places);
  /// Divides the connectors of these places again once it is done. Components without such a place
  /// go on from their own time, the others begin anew.
  void renew(World& world);

  std::span<const std::unique_ptr<Integrator>> all() const {
    return {integrators_.data(), followed_};
  }
  /// The integrators that mark() has found, as indices of all().
  std::span<const std::size_t> near() const { return near_; }
  /// All integrators made: more than are followed.
  std::span<const std::unique_ptr<Integrator>> made() const { return integrators_; }

 private:
  static constexpr std::size_t kNone = std::size_t(-1);
  /// A span between two holds: the pins there, or zero for an end of its connector.
  struct Piece {
    SpanRange span;
    std::uint64_t begin = 0, end = 0;
  };

  void align();
  void make_room(const World& world, std::size_t parts);
  void know(const World& world);
  std::size_t& entry(const Piece& piece);
  std::size_t find(const Piece& piece);
  void enter(std::size_t part);
  void drop(std::size_t part);
  void follow(World& world, std::size_t part, const Piece& piece);

  StepOptions options_;
  Division division_;
  std::vector<std::unique_ptr<Integrator>> integrators_;  // the followed ones first
  std::size_t followed_ = 0;
  std::vector<std::size_t> links_, links_before_;  // of each part that is followed
  bool changes_ = false;                           // interventions may come, for which room is kept

  // The knowledge of mark() and renew() of the parts that are followed.
  bool known_ = false, distinct_ = false;  // all have been looked at; each has one span at most
  std::deque<Piece> pieces_;               // of each part
  std::vector<std::size_t> begins_, ends_, whole_;  // [pin] and [connector] the part there
  std::vector<std::size_t> count_;                  // [connector] of its parts
  std::vector<std::size_t> near_, touched_;         // parts, connectors
  std::vector<Piece> fresh_;
  VelocityProjection velocity_projection_;
};

}  // namespace taut::direct
