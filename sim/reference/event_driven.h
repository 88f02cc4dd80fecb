// The truth among obstacles and of strings: smooth motion from event to event.
#pragma once

#include <memory>

#include "sim/run/method.h"

namespace taut::reference {

/// Runge-Kutta-Fehlberg 7(8) on ContactMotion, `local_error` in a step (m, m/s). Where a step
/// passes an event it is taken again, to end there. For worlds with obstacles or strings.
std::unique_ptr<Method> make_event_driven(double local_error);

}  // namespace taut::reference
