// The settings of the methods, as --help lists them.
#pragma once

#include <string>

namespace taut::options {

/// Every setting of every method: name, default, unit, range, meaning. From the list of methods.
std::string settings_help();

}  // namespace taut::options
