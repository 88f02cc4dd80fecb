// The data of the method contract: the promises of theory for each method, and its exemptions.
#pragma once

#include <cmath>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "sim/run/method.h"

namespace taut::contract {

/// A setting that refines a method: it is divided by `by` again and again, and the error falls with
/// the power `order` of it.
struct Knob {
  std::string_view name;
  double coarse = 0;
  double by = 2;
  double order = 1;

  Setting value(int refined) const { return coarse / std::pow(by, refined); }
};

/// How a chain of n links that hangs at rest may move from there.
enum class Rest {
  exact,      // not at all
  springy,    // by twice the stretch under its weight, as it starts unstretched
  unfinished  // by n^2 g dt^2: one pass leaves each link the stiffness m / (2 dt^2) or more
};

struct Theory {
  std::string_view label;  // as tables write it: METHOD or METHOD:FORM
  std::string_view method;
  Settings settings;
  Knob knob;          // refines steps or tolerances
  Knob towards = {};  // refines towards the truth, where that is another one
  /// How far free flight is off, in g t dt: 1/2 for Euler steps, 0 where parabolas are exact.
  double fall = 0;
  /// The power of the step with which angular momentum changes; zero: not at all.
  double angular = 0;
  Rest rest = Rest::exact;
  bool controls_error =
      false;  // the knob is a tolerance, and quantities are kept as well as it says

  const Knob& convergence() const { return towards.name.empty() ? knob : towards; }
};

inline std::string text(const char* words) {
  return words;
}

/// One row per method and form. A knob's `order` for a tolerance is what its control promises: the
/// error follows the tolerance.
inline const std::vector<Theory>& theories() {
  const Settings rk4_at_fixed_return{{"time_constant", 0.02}};
  const Settings euler{{"integrator", text("semi-implicit-euler")}, {"time_constant", 0.02}};
  const Settings dense{{"solver", text("dense")}, {"time_constant", 0.02}};
  const Settings rk4{{"integrator", text("rk4")}};
  const Settings explicit_euler{{"integrator", text("explicit-euler")}, {"damping", 1.0}};
  // The stretch is inverse to the stiffness; the step that is left open, to its root.
  const Knob stiffness{"stiffness", 1e4, 0.1, 1}, stiffness_and_step{"stiffness", 1e4, 0.1, 0.5};
  // Softer, and it is swings that limit explicit Euler's step.
  const Knob stiffer{"stiffness", 1e5, 0.1, 0.5};
  // Errors of a fifth order in a step are held to the tolerance, and sum up to the fourth.
  const Knob by_the_fourth{"tolerance", 1e-5, 10, 4.0 / 5};
  static const std::vector<Theory> rows{
      {.label = "impulse", .method = "impulse", .settings = {}, .knob = {"step", 0.001, 2, 1}},
      {.label = "dynamic-constraints",
       .method = "dynamic-constraints",
       .settings = rk4_at_fixed_return,
       .knob = {"step", 0.002, 2, 4},
       .angular = 4},
      {.label = "dynamic-constraints:euler",
       .method = "dynamic-constraints",
       .settings = euler,
       .knob = {"step", 0.0005, 2, 1},
       .fall = 0.5},
      {.label = "dynamic-constraints:dense",
       .method = "dynamic-constraints",
       .settings = dense,
       .knob = {"step", 0.002, 2, 4},
       .angular = 4},
      {.label = "multibody",
       .method = "multibody",
       .settings = {},
       .knob = {"accuracy", 1e-5, 10, 1},
       .controls_error = true},
      {.label = "sdfast",
       .method = "sdfast",
       .settings = {},
       .knob = by_the_fourth,
       .controls_error = true},
      {.label = "sdfast:kane",
       .method = "sdfast",
       .settings = {{"formulation", text("kane")}},
       .knob = by_the_fourth,
       .controls_error = true},
      {.label = "springs",
       .method = "springs",
       .settings = {},
       .knob = {"step", 1e-4, 2, 1},
       .towards = stiffness_and_step,
       .fall = 0.5,
       .rest = Rest::springy},
      {.label = "springs:rk4",
       .method = "springs",
       .settings = rk4,
       .knob = {"step", 2e-4, 2, 4},
       .towards = stiffness,
       .angular = 4,
       .rest = Rest::springy},
      {.label = "springs:explicit-euler",
       .method = "springs",
       .settings = explicit_euler,
       .knob = {"step", 2e-5, 2, 1},
       .towards = stiffer,
       .fall = -0.5,
       .angular = 1,
       .rest = Rest::springy},
      {.label = "xpbd",
       .method = "xpbd",
       .settings = {},
       .knob = {"step", 0.0005, 2, 1},
       .fall = 0.5,
       .angular = 1,
       .rest = Rest::unfinished},
      {.label = "direct",
       .method = "direct",
       .settings = {},
       // The error estimate is of fifth order: steps go with tolerance^(1/6), errors with its 5/6.
       .knob = {"tolerance", 1e-7, 10, 5.0 / 6},
       .controls_error = true},
      {.label = "direct:step", .method = "direct", .settings = {}, .knob = {"step", 0.02, 2, 8}},
      {.label = "truth",
       .method = "truth",
       .settings = {},
       .knob = {"local_error", 1e-8, 10, 1},
       .controls_error = true},
  };
  return rows;
}

inline void PrintTo(const Theory& theory, std::ostream* out) {
  *out << theory.label;
}

/// Where a method breaks its contract: what it reaches instead, and why that is so.
struct Exemption {
  std::string_view label;
  std::string_view check;
  double reached = 0;  // within a tenth
  std::string_view unit;
  std::string_view why;
  std::string_view refusal = {};  // it says so, in these words, instead of reaching anything
};

inline const std::vector<Exemption>& exemptions() {
  static constexpr std::string_view massless =
      "the connector's inertia and weight never reach what it holds: model error, for any step";
  static constexpr std::string_view tree =
      "its models are generated, one for each length of an open chain";
  static constexpr std::string_view unforeseen =
      "nothing can be generated at a moment that nobody foresaw";
  static constexpr std::string_view pinned = "follows no chain that is pinned between its ends";
  static const std::vector<Exemption> rows{
      {"impulse", "linear momentum kept", 0.0729, "of it",
       "repositioning moves particles, and gives nothing back to the bodies"},
      {"impulse", "angular momentum kept", 0.133, "of it",
       "repositioning moves particles, and gives nothing back to the bodies"},
      {"impulse", "rigid body end", 0.0381, "m", massless},
      {"impulse", "driven end", 0.0541, "m", massless},
      {"impulse", "two free bodies", 0.0691, "m", massless},
      {"impulse", "pins and several connectors", 0.100, "m", massless},
      {"sdfast", "pins and several connectors", 0, "", tree, "follows one connector alone"},
      {"sdfast:kane", "pins and several connectors", 0, "", tree, "follows one connector alone"},
      {"sdfast", "a pin that comes and goes", 0, "", unforeseen, pinned},
      {"sdfast:kane", "a pin that comes and goes", 0, "", unforeseen, pinned},
  };
  return rows;
}

}  // namespace taut::contract
