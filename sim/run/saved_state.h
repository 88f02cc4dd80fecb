// States of simulations as bytes, to go on from them later.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/world/world.h"

namespace taut {

/// A state that cannot be loaded or saved.
class BadState : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The parts of a world that a state names and does not hold: paths, winches and applied forces, in
/// the order in which a world and its timeline have them at the start.
class StateParts {
 public:
  StateParts(const World& start, const Timeline& timeline);

  /// Another one for another start or timeline.
  std::uint64_t fingerprint() const { return fingerprint_; }

  /// How many connectors there were.
  std::size_t connectors() const { return connectors_; }

  /// Things of one kind, each with a number.
  template <class Thing>
  struct List {
    std::vector<std::shared_ptr<const Thing>> all;
    std::unordered_map<const Thing*, std::uint32_t> number;
    void add(const std::shared_ptr<const Thing>& one) {
      if (!one || !number.emplace(one.get(), static_cast<std::uint32_t>(all.size())).second) return;
      all.push_back(one);
    }
  };
  const List<Path>& paths() const { return paths_; }
  const List<Winch>& winches() const { return winches_; }
  const List<AppliedForce>& forces() const { return forces_; }

 private:
  std::uint64_t fingerprint_ = 0;
  std::size_t connectors_ = 0;
  List<Path> paths_;
  List<Winch> winches_;
  List<AppliedForce> forces_;
};

/// A state of a simulation: its world, and how far its timeline has come.
struct SavedState {
  World world;
  std::uint64_t next = 0;                // the first entry of the timeline that has not happened
  std::vector<std::uint64_t> pins = {};  // numbers of the timeline's pins, 0 before they are set
  struct Cut {
    std::uint64_t whole = 0;      // the connector of the start
    double along = 0;             // m on it
    std::uint64_t connector = 0;  // the new one
  };
  std::vector<Cut> cuts = {};             // as they happened
  std::vector<Quat> links_rotation = {};  // of bodies that are simulated as links
};

/// The state as bytes. Throws BadState where a pin holds on to what the start does not have.
std::string saved(const SavedState& state, const StateParts& parts);

/// The state of those bytes; `like` has what no step changes. Throws BadState: of another world or
/// timeline, or damaged. Whatever the bytes are, what it returns is a world that methods can step.
SavedState loaded(std::string_view bytes, const StateParts& parts, const World& like);

}  // namespace taut
