// Text from outside (names, titles, other programs' words) as a terminal may show it.
#pragma once

#include <string>
#include <string_view>

namespace taut {

/// `text` as valid UTF-8 of one line: newlines and tabs as \n and \t; other control characters (C0,
/// DEL, C1), line and paragraph separators, marks that turn the direction of writing, and bytes
/// that are no UTF-8 as \xNN for each byte. Of printable text it is a copy.
std::string printable(std::string_view text);

/// The same, but newlines stay.
std::string printable_lines(std::string_view text);

}  // namespace taut
