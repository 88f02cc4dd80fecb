// All that the check of a document's format finds.
#pragma once

#include "scenes/files/first_faults.h"
#include "scenes/format/document.h"

namespace taut::scenes {

/// The fault that check_format() would throw, and all that it would find after it.
FirstFaults format_faults(const Document& document);

}  // namespace taut::scenes
