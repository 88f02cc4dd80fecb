// Faults of a scene file or an asset. Messages are printable (see printable()): names have escapes.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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

// A fault of a scene file that knows where it stands.

/// Where a scene file is wrong. Lines and columns count from 1; 0: no place in a file.
struct FaultPlace {
  std::string file = {};
  int line = 0, column = 0;
  std::string key = {};    // dotted, from the root
  std::string fault = {};  // the message without its place
};

class SceneFault : public BadScene {
 public:
  SceneFault(const std::string& message, FaultPlace where)
      : BadScene(message), place(std::move(where)) {}
  FaultPlace place;
};

// The faults that stand first in a file, so that a list of them has an end.

/// Keeps those that stand first; of the others only the number.
class FirstFaults {
 public:
  static constexpr std::size_t kMost = 100;

  void add(const SceneFault& fault);
  std::size_t count() const { return count_; }  // those left out, too

  /// At most kMost, in the order of the file.
  std::vector<SceneFault> list() &&;

 private:
  void keep_first();

  std::vector<SceneFault> kept_;
  std::size_t count_ = 0;
};

}  // namespace taut::scenes
