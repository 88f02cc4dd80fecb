// The names of connectors that the reader makes of one.
#pragma once

#include <string_view>

namespace taut::scenes {

/// Whether it names a copy, a span behind a pulley or a cord of a net: these are numbered,
/// "cord#2".
inline bool is_numbered(std::string_view name) {
  return name.find('#') != std::string_view::npos;
}

/// The name that the scene file has for it: "cord" of "cord#2".
inline std::string_view written_name(std::string_view name) {
  return name.substr(0, name.find('#'));
}

}  // namespace taut::scenes
