// Words for whoever runs the program.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <cstdio>
#include <string>
#include <string_view>
#include <utility>

#include "sim/motion/printable.h"

namespace taut::program {

/// A text of several lines, whose newlines note() leaves.
struct Lines {
  std::string_view text;
};

/// A value as note() writes it: text without anything that a terminal would obey.
template <class Value>
auto shown(const Value& value) {
  if constexpr (std::same_as<Value, Lines>) {
    return printable_lines(value.text);
  } else if constexpr (std::convertible_to<const Value&, std::string_view>) {
    return printable(value);
  } else {
    return value;
  }
}

/// Writes to standard error. A run goes on where nobody can read it; fmt::print
/// throws there.
template <class... Values>
void note(fmt::format_string<decltype(shown(std::declval<const Values&>()))...> format,
          const Values&... values) {
  const std::string text = fmt::format(format, shown(values)...);
  std::fwrite(text.data(), 1, text.size(), stderr);
}

}  // namespace taut::program
