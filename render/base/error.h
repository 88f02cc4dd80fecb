// Errors while pictures and files are made; each cause has its own exit code.
#pragma once

#include <stdexcept>

namespace taut::render {

/// No OpenGL context of the kind that rendering needs.
class NoContext : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// FFmpeg or ffprobe is missing, failed, or made something else than was asked for.
class EncoderFailed : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An output could not be written; the message starts with the file's name.
class CannotWrite : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace taut::render
