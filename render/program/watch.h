// Work that is done again whenever a file is saved.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "render/program/command.h"

namespace taut::program {

/// Calls `work` now and whenever one of the files changes, until the program is interrupted, which
/// is how it ends well. Errors of `work` are told, and wait for the next change.
int watch(const std::vector<std::filesystem::path>& files, const Common& common,
          const std::function<int()>& work);

}  // namespace taut::program
