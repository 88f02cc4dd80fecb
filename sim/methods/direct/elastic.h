// A connector that stretches, bends or meets the air, between ends whose motion is known.
#pragma once

#include <vector>

#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/schemes/radau_step.h"

namespace taut::direct {

/// Follows one connector by RadauStep: nothing couples it with the rest of its world.
class Elastic : public Stepping {
 public:
  explicit Elastic(const StepOptions& options) : options_(options), controller_(options) {}
  Elastic(const Elastic&) = delete;

  /// Call first, and whenever the world's topology is new.
  void rebuild(const World& world, std::size_t connector);
  /// From the world's time and the connector's state there to its state at `until`. Throws
  /// Diverged.
  void advance(World& world, double until, Counters& counters);

  double first_step() const override;
  double longest_step(double time) override;
  double order() const override;
  bool lands(double left, double wish) const override;
  Attempt attempt(double time, double h, double until) override;
  void accept(double time) override;
  [[noreturn]] void give_up(double time) override;

 private:
  double allowed(double h) const;
  double left_open(double h) const;

  StepOptions options_;
  Controller controller_;
  std::size_t connector_ = 0;        // of the world
  std::vector<std::size_t> bodies_;  // driven, of the world
  World own_;                        // the connector with these bodies
  RadauStep step_;
  bool known_ = false;  // the state of the steps is that of own_
  Counters* counters_ = nullptr;
};

}  // namespace taut::direct
