// How --help looks: lines of at most 100 letters.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>

namespace taut::cli {

std::shared_ptr<CLI::Formatter> help_format();

}  // namespace taut::cli
