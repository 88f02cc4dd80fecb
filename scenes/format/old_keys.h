// Keys of scene files that have another name now.
#pragma once

#include <string>
#include <vector>

#include "scenes/format/document.h"

namespace taut::scenes {

/// Gives every key that stands under the name it had (KeyFormat::formerly) its name of now, so that
/// the readers know one alone. Returns a sentence for each, with its place in the file.
std::vector<std::string> rename_old_keys(Document& document);

}  // namespace taut::scenes
