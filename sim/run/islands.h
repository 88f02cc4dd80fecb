// A world whose parts never meet, each advanced by itself.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/run/method.h"

namespace taut {

/// The island of each connector and, behind them, of each body: from 1 on those in which a timeline
/// does something, 0 all others together.
/// `wholes` has, for each connector of a world that has been cut, the one of the start that it is a
/// part of: they are of one island. Empty: nothing has been cut.
std::vector<std::size_t> island_numbers(const World& world, const Timeline& timeline,
                                        std::span<const std::size_t> wholes = {});

/// Advances islands, as physics engines call them: connectors and free bodies that nothing ties
/// together, neither holds nor joints nor what a timeline has to come, and that never touch. Each
/// is a world of its own with a method of its own, so that a pin or cut ends the steps of its
/// island alone, and has nothing else built anew: n events on n islands take time in proportion to
/// n, not to its square. All that the timeline leaves alone is one island.
class Islands : public Method {
 public:
  /// Null where there is one island alone, or pulleys, or where nobody knows how to make more such
  /// methods. `wholes` as above.
  static std::unique_ptr<Islands> find(const World& world, const Timeline& timeline,
                                       const Method& method,
                                       std::span<const std::size_t> wholes = {});

  void advance(World& world, double until) override;

  /// Takes the island of a connector to `until` (s), and leaves the others behind until advance().
  /// Before the next call nothing but this island may change, and what is cut off it; or what is
  /// done at `places` alone, where there are some, on this connector.
  void advance_island(World& world, double until, std::size_t connector,
                      std::span<const Parts::Place> places = {});
  /// Whether islands were left behind.
  bool left_behind() const { return left_behind_; }

  /// Calls say(own, other's) for the methods of each island, where the other has the same.
  void tell(const Islands& other, void (*say)(Method& own, const Method& others));

 private:
  struct Island {
    World world;
    std::unique_ptr<Method> method;
    std::vector<std::size_t> connectors, bodies, joints;  // indices in the whole world, rising
    bool left_behind = false;                             // parts of it, by its method
  };

  Islands() = default;
  void take(const World& whole, Island& island);
  void settle(const World& whole);
  void advance(Island& island, World& whole, double until,
               std::span<const Parts::Place> places = {});
  void add(const Counters& before, const Counters& after);

  std::vector<Island> islands_;
  std::vector<std::size_t> island_of_;  // [connector]
  std::function<std::unique_ptr<Method>()> again_;
  static constexpr std::size_t kNone = SIZE_MAX;
  std::size_t changing_ = kNone;  // the island that advance_island() was called for last
  std::uint64_t topology_ = 0;    // of the whole world, as far as the islands know it
  bool left_behind_ = false;
};

}  // namespace taut
