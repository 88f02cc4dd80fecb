// All that the check of a document's format finds.
#pragma once

#include <vector>

#include "scenes/files/fault.h"
#include "scenes/format/document.h"

namespace taut::scenes {

/// What check_format() would throw, and all that it would find after that.
std::vector<SceneFault> format_faults(const Document& document);

}  // namespace taut::scenes
