// A place to draw without a display: an OpenGL 4.5 core context through EGL or OSMesa.
#pragma once

#include <memory>
#include <string>

#include "render/base/error.h"
#include "render/gl/gl.h"

namespace taut::gl {

enum class Backend { automatic, egl, osmesa };

/// "auto", "egl" or "osmesa". Throws std::invalid_argument for any other name.
Backend backend_named(const std::string& name);

/// A software rasteriser draws for all contexts of a display one after another: of two that are to
/// draw at the same time, each on a thread of its own, one sits at EGL's display without a surface
/// and the other at a device's.
enum class EglDisplay { any, surfaceless, device };

/// A context that is current on the thread that made it, until it is destroyed. EGL and OSMesa are
/// opened at run time; `automatic` tries EGL without a surface, EGL on a device, then OSMesa.
class Context {
 public:
  /// Throws NoContext. `threads` > 0 sets on how many threads a software rasteriser draws, if this
  /// is the first context at its display: with 1, on the one that calls it.
  explicit Context(Backend backend, int threads = 0, EglDisplay display = EglDisplay::any);
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const Gl& gl() const { return gl_; }
  /// The way in, and the driver's own name and version.
  std::string description() const { return way_ + ": " + driver_; }
  /// True where threads of this machine draw.
  bool is_software() const;
  int max_size() const { return max_size_; }        // pixels, of a picture's side
  int max_samples() const { return max_samples_; }  // per pixel

  class Platform;  // EGL or OSMesa

 private:
  std::unique_ptr<Platform> platform_;
  Gl gl_;
  std::string way_, driver_;
  int max_size_ = 0, max_samples_ = 0;
};

}  // namespace taut::gl
