// Words for whoever runs the program.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace taut::program {

/// Writes to standard error. A run goes on where nobody can read it; fmt::print
/// throws there.
template <class... Values>
void note(fmt::format_string<Values...> format, Values&&... values) {
  std::fputs(fmt::format(format, std::forward<Values>(values)...).c_str(), stderr);
}

}  // namespace taut::program
