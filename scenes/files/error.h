// Faults of a scene file or an asset. Messages are printable (see printable()): names have escapes.
#pragma once

#include <stdexcept>
#include <string>

#include "sim/motion/printable.h"

namespace taut::scenes {

/// A scene that cannot be read: the message starts with file:line:column and names the key, what
/// was found and what was expected.
class BadScene : public std::runtime_error {
 public:
  explicit BadScene(const std::string& message) : std::runtime_error(printable(message)) {}
};

/// A model or data file that cannot be used; the message starts with the file's name.
class BadAsset : public std::runtime_error {
 public:
  explicit BadAsset(const std::string& message) : std::runtime_error(printable(message)) {}
};

}  // namespace taut::scenes
