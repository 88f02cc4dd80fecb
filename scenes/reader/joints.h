// Ends of connectors that are joined, pass pulleys or belong to a winch.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/format/document.h"
#include "scenes/reader/common.h"
#include "scenes/reader/motions.h"
#include "scenes/scene/scene.h"
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

// Ropes that pass pulleys, as a scene names them.

/// Each rope that passes pulleys is a row of connectors, one for each span; the first is the one
/// that the file names. All throw BadScene.
class Routes {
 public:
  /// Reads the pulleys.
  Routes(const Document& document, Motions& motions, const World& world);

  /// Divides a rope: `first` has what all its spans have and the rope's first end, `last` the same
  /// and the last end. Leaves the first span in `first`.
  void divide(const Value& value, const World& world, std::size_t index, Connector& first,
              Connector last);
  bool passes(std::size_t index) const { return ropes_.contains(index); }

  /// Gives a rope's spans their lengths and shapes, between the places that its ends have already.
  /// All but the first stay here until add().
  void lay(const World& world, std::size_t index, Connector& first, std::optional<Vec3> from,
           std::optional<Vec3> to);
  Connector& last(std::size_t index) { return ropes_.at(index).behind.back(); }

  /// Adds a rope's other spans, which have their shapes, behind all connectors, and its pulleys.
  void add(std::size_t index, World& world);
  /// Once all ropes are added: whether each pulley is passed.
  void check_passed() const;

 private:
  struct Eye {
    const Value* value;
    Attachment to;
    const Value* passed = nullptr;                 // the name in the rope's list
    std::shared_ptr<const Path> driven = nullptr;  // what it passes, where that is given
  };
  struct Rope {
    const Value* value = nullptr;
    std::vector<std::size_t> eyes;
    std::vector<Connector> behind;  // the first span
    std::array<std::shared_ptr<const Path>, 2> winches;
    double density = 0;  // kg/m
  };
  std::vector<Vec3> between(const Rope& rope, const Connector& span, const Vec3& from,
                            const Vec3& to, const World& world) const;
  void check(const World& world, const Rope& rope, const Connector& span) const;

  const Document& document_;
  Names names_;
  std::vector<Eye> eyes_;
  std::map<std::size_t, Rope> ropes_;
};

/// How many connectors one that the file names becomes, by its pulleys.
std::size_t span_count(const Value& connector);

// Connectors joined end to end, which hang as one between the two places at its ends.

/// A connector of a line; against it where it runs from its last particle to its first.
struct InLine {
  std::size_t connector = 0;
  bool against = false;
};
using Line = std::vector<InLine>;

/// All lines of two connectors and more that say nothing of their start: ends of neighbours are
/// joined to each other, and to nothing else.
std::vector<Line> lines_of(const Value& connectors, const World& world, const JoinedEnds& joined);

/// Of all its connectors together, m.
double length_of(const Line& line, const World& world);

/// Lays all connectors of a line at rest between two places. Throws std::invalid_argument where
/// there is no equilibrium.
void hang_line(World& world, const Line& line, const Vec3& from, const Vec3& to);

// Winches of a scene.

/// Lengths (m) over time from keys of `key`, or of a speed (m/s); zero and at rest at the start.
std::shared_ptr<const Path> read_length_keys(const Document& document, const Value& list,
                                             std::string_view key);
/// Fails at `key` where winches whose lengths are all known take in more than the links have.
void check_least(const Document& document, const Value& key, const Winch& winch);
/// The paths of the winches at the first end of `first` and the last of `last`, once those have
/// their holds; null where there is none.
std::array<std::shared_ptr<const Path>, 2> read_winches(const Document& document,
                                                        const Value& value, const World& world,
                                                        const Connector& first,
                                                        const Connector& last);
/// The winches at a connector's ends, once it has its holds. Throws BadScene.
void read_winches(const Document& document, const Value& value, const World& world,
                  Connector& connector);

}  // namespace taut::scenes
