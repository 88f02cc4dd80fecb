// Errors while pictures and files are made; each cause has its own exit code. Messages are
// printable (see printable()): names have escapes.
#pragma once

#include <stdexcept>
#include <string>

#include "sim/motion/printable.h"

namespace taut::render {

/// No OpenGL context of the kind that rendering needs.
class NoContext : public std::runtime_error {
 public:
  explicit NoContext(const std::string& message) : std::runtime_error(printable_lines(message)) {}
};

/// FFmpeg or ffprobe is missing, failed, or made something else than was asked for. The message has
/// what it said, in its lines.
class EncoderFailed : public std::runtime_error {
 public:
  explicit EncoderFailed(const std::string& message)
      : std::runtime_error(printable_lines(message)) {}
};

/// An output could not be written; the message starts with the file's name.
class CannotWrite : public std::runtime_error {
 public:
  explicit CannotWrite(const std::string& message) : std::runtime_error(printable(message)) {}
};

}  // namespace taut::render
