// Worlds whose connectors are joined: trees, loops and nets; winches, pulleys, and what stretches,
// bends or meets the air and holds free bodies.
#pragma once

#include <array>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/links/tension.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/schemes/dop853.h"
#include "sim/run/method.h"

namespace taut::direct {

/// Follows a world as a whole by DOP853 on the places of its points, under the tensions of all
/// links at once (JoinedTension), with projection onto the links after each step. Explicit: steps
/// are never longer than what the waves under the tensions, and of what stretches and bends, allow.
/// They may go beyond the time that is asked for, whose state is interpolated then.
class Joined : public Stepping {
 public:
  explicit Joined(const StepOptions& options) : options_(options), controller_(options) {}
  Joined(const Joined&) = delete;

  /// Whether the waves of materials are so fast that implicit steps cost less: explicit ones, a
  /// tenth as dear, have to follow each wave, and most motions need a thousand of them a second.
  bool is_stiff(const World& world);
  /// Throws Diverged, also where there is contact or massless spans. Then the world is as it was.
  void advance(World& world, double until);
  const Counters& counters() const { return counters_; }

  double first_step() const override;
  double longest_step(double time) override;
  double order() const override;
  bool lands(double left, double wish) const override;
  Attempt attempt(double time, double h, double until) override;
  void accept(double time) override;
  [[noreturn]] void give_up(double time) override;

 private:
  using State = std::vector<double>;

  void rebuild(const World& world);
  void find_slope(double time, const State& state, State& slope);
  void find_material_waves();
  double wave_frequency();
  double allowed_error(double h) const;
  double try_step(double time, double h);
  double size(const State& error) const;
  bool project(double time, State& state);
  void prepare_states_within();
  void find_state_within(double time, State& state);
  double distance_to_change(double time, State& state);

  StepOptions options_;
  Controller controller_;
  Counters counters_;
  const World* world_ = nullptr;  // in advance()
  bool built_ = false;
  std::uint64_t topology_ = 0;
  Mechanism mechanism_;
  TensionSystem system_;
  Projection projection_;
  PulleyFriction friction_;
  std::vector<double> easy_;  // 1/kg, of each point, those of bodies included
  State state_, before_;      // where the last step ended, and began
  State shown_, loaded_, next_, scratch_, error_, right_, tension_;
  std::array<State, kAllStages> slope_;  // of the stages
  bool within_known_ = false;            // states within that step
  double length_ = 0, shortest_ = 0;     // m: the scale of the world, and its shortest link
  double material_waves_ = 0;            // rad/s
  /// A free body on which no connector hangs: its error is that of a point `arm` (m) away from its
  /// centre, the radius of gyration.
  struct Lone {
    std::size_t body = 0;
    double arm = 0;
  };
  std::vector<Lone> lone_;
  double carried_ = 0;  // particles that nothing prescribes, and lone bodies
  bool driven_ = false;
  double to_change_ = kNever, next_to_change_ = kNever;  // see PulleyFriction, of state_ and next_
};

}  // namespace taut::direct
