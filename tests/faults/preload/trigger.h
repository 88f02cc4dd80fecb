// Decides which call fails.
#pragma once

#include "tests/faults/preload/page.h"

namespace taut::faults {

/// Counts a call that is about `what` (or about an open file); true where it must fail, errno set.
/// Does not return where the process is to be killed.
bool fails(Kind kind, const char* call, const char* what);
bool fails(Kind kind, const char* call, int descriptor);
/// The same for a write to an open file.
bool write_fails(int descriptor);

}  // namespace taut::faults
