// The cost of computing.
#pragma once

namespace taut {

/// CPU time (s) of the calling thread.
double thread_seconds();

}  // namespace taut
