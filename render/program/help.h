// How --help looks: lines of at most 100 letters.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>

namespace taut::program {

std::shared_ptr<CLI::Formatter> help_format();

/// A name and, from a column on, its description, broken between words.
std::string help_entry(const std::string& name, const std::string& description);

/// The name of an option's value, in capitals: the option's own if none is better; none for flags.
std::string value_of(const CLI::Option& option);

}  // namespace taut::program
