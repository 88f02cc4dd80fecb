// A place to draw without a display: an OpenGL 4.5 core context through EGL or OSMesa.
#pragma once

#include <memory>
#include <string>

#include "render/error.h"
#include "render/gl.h"

namespace taut {

enum class Backend { automatic, egl, osmesa };

/// "auto", "egl" or "osmesa". Throws std::invalid_argument for any other name.
Backend backend_named(const std::string& name);

/// A context that is current on the thread that made it, until it is destroyed. EGL and OSMesa are
/// opened at run time; `automatic` tries EGL without a surface, EGL on a device, then OSMesa.
class Context {
 public:
  /// Throws NoContext. `threads` > 0 sets how many threads a software rasteriser uses (only the
  /// first context of the process can choose).
  explicit Context(Backend backend, int threads = 0);
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const Gl& gl() const { return gl_; }
  /// The way in, and the driver's own name and version.
  const std::string& description() const { return description_; }
  int max_size() const { return max_size_; }        // pixels, of a picture's side
  int max_samples() const { return max_samples_; }  // per pixel

  class Platform;  // EGL or OSMesa

 private:
  std::unique_ptr<Platform> platform_;
  Gl gl_;
  std::string description_;
  int max_size_ = 0, max_samples_ = 0;
};

}  // namespace taut
