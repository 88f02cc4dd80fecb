// Faults of a scene file or an asset.
#pragma once

#include <stdexcept>
#include <string>

namespace taut::scenes {

/// A scene that cannot be read: the message starts with file:line:column and names the key, what
/// was found and what was expected.
class BadScene : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// A model or data file that cannot be used; the message starts with the file's name.
class BadAsset : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace taut::scenes
