// Runge-Kutta-Fehlberg 7(8) with error control, by Boost, as the truth steps with it.
#pragma once

#include <algorithm>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <vector>

namespace taut::reference {

namespace odeint = boost::numeric::odeint;

using State = std::vector<double>;

/// Far beyond what is stable errors overflow, and what is not a number compares as no error at all.
inline bool is_finite(const State& state) {
  return std::ranges::all_of(state, [](double x) { return std::isfinite(x); });
}

// Workspaces follow the state's size, which interventions change.
using Explicit = odeint::runge_kutta_fehlberg78<
    State, double, State, double, odeint::algebra_dispatcher<State>::algebra_type,
    odeint::operations_dispatcher<State>::operations_type, odeint::always_resizer>;
using Stepper = odeint::controlled_runge_kutta<Explicit>;

}  // namespace taut::reference
