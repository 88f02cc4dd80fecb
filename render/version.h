// Which taut this is.
#pragma once

namespace taut {

/// As in 0.1.0.
const char* version();

}  // namespace taut
