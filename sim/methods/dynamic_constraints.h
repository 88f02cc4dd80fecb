// Dynamic constraints (Barzel and Barr 1988): forces that keep every link at its length.
#pragma once

#include "sim/run/method.h"

namespace taut::methods {

/// Per evaluation, tensions T of all links at once such that each link's excess C (m) returns to
/// zero critically damped: C'' + (2/tau) C' + C/tau^2 = 0, tau the time constant. With the system's
/// second derivative C'' = c - A T (c without tensions, A = J M^-1 J^T) that is
///   A T = c + (2/tau) C' + C/tau^2.
/// Where A is singular (a straight connector between two fixed ends, say) the forces of least norm
/// that come closest are taken.
MethodInfo dynamic_constraints_method();

}  // namespace taut::methods
