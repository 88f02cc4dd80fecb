// Names as messages print them.
#pragma once

#include <string>
#include <string_view>

namespace taut::scenes {

/// `text` as one line that any terminal can be given: a newline becomes \n, other control
/// characters (NUL, DEL and U+0080 to U+009F too) and bytes that are no UTF-8 become \xNN; all else
/// stays. What is printable already stays as it is.
std::string printable(std::string_view text);

}  // namespace taut::scenes
