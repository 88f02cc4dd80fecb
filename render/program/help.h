// How --help looks: lines of at most 100 letters.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

namespace taut::program {

std::shared_ptr<CLI::Formatter> help_format();

/// What an option takes, in capitals: its own name where it has no better word; empty for flags.
std::string value_of(const CLI::Option& option);

}  // namespace taut::program
