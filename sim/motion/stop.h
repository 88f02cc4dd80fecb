// Ending long work from outside.
#pragma once

namespace taut {

/// Returns where work may continue; throws, whatever it likes, to end it. May be called by several
/// threads at once.
using StopCheck = void (*)();

/// Every long computation of the process calls `check` from now on, between steps and between
/// iterations; null, the default, for none. A simulation that it ended within a step cannot
/// continue (see Simulation::advance_to()).
void set_stop_check(StopCheck check);

/// Calls the check. Without one it costs an atomic read. Throws what the check throws.
void check_stop();

}  // namespace taut
