// The integrator of worlds in which features stand together: implicit steps under error control.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/implicit_step.h"
#include "sim/methods/direct/spans_as_strings.h"
#include "sim/run/method.h"
#include "sim/world/world.h"

namespace taut::direct {

/// Each step is taken once and again in two halves. The difference tells the error of the halves;
/// a third of it corrects them, where contacts and strings stay as they are. The times that are
/// asked for end no step: a state within the last step is made by a shorter one from its start.
class Implicit : public Stepping {
 public:
  explicit Implicit(const StepOptions& options) : options_(options), controller_(options) {}
  Implicit(const Implicit&) = delete;

  /// Advances the whole world, and adds the events until then. Throws Diverged.
  void advance(World& world, double until, std::vector<Event>& events);
  /// Since this was made.
  const Counters& counters() const { return counters_; }

  double first_step() const override;
  double longest_step(double time) override;
  double order() const override { return order_; }
  bool lands(double left, double wish) const override;
  Attempt attempt(double time, double h, double until) override;
  void accept(double time) override;
  [[noreturn]] void give_up(double time) override;

 private:
  void advance_strings(World& world, double until);
  void rebuild(const World& world);
  void note_events();
  Attempt try_step(double h);
  const StepState& at(double time);
  double arrival_ahead();
  double allowed_error(double h) const;
  double allowed_change() const;
  double size(const StepState& one, const StepState& other, double time) const;

  StepOptions options_;
  Controller controller_;
  Counters counters_;
  const World* world_ = nullptr;  // in advance()
  bool built_ = false;
  std::uint64_t topology_ = 0;
  SpansAsStrings spans_;
  std::uint64_t spans_topology_ = 0;  // of the world with spans
  ImplicitStep step_;
  StepState from_, now_;  // where the last step began, and ended: at or beyond the shown time
  StepState middle_, end_, whole_, within_;
  std::vector<double> rate_;  // of the last step that ended without an impact, as StepState has it
  std::vector<double> shown_, loaded_;  // the state that advance() left in the world; found there
  double length_ = 1, shortest_ = 1, touching_ = 0;
  double order_ = 0;           // of the last estimate
  double friction_ = 1;        // share of it, in the present step
  bool runs_through_ = false;  // the last step tried lets rope run through a pulley
  std::vector<Event> events_;  // not told yet: after the time that was asked for
  double jam_ = 0;             // s: steps no longer than that go with less friction if they have to
};

}  // namespace taut::direct
