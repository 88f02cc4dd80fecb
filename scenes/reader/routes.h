// Ropes that pass pulleys, as a scene names them.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "scenes/reader/common.h"
#include "scenes/reader/motions.h"
#include "sim/world/world.h"

namespace taut::scenes {

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

}  // namespace taut::scenes
