// Which taut this is.
#pragma once

namespace taut::render {

/// As in 0.1.0.
const char* version();

}  // namespace taut::render
