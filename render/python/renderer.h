// Pictures of a scene, drawn on a thread of their own.
#pragma once

#include <memory>
#include <optional>

#include "render/film/film.h"
#include "render/python/drawing_thread.h"
#include "scenes/scene/scene.h"

namespace taut::python {

struct PictureOptions {
  int width = 0, height = 0;  // 0: the scene's
  int samples = 4;            // per pixel
  gl::Backend backend = gl::Backend::automatic;
  bool transparent = false;
};

/// A scene's film. Works without Python's lock, and for one thread at a time.
class Renderer {
 public:
  /// `scene` was read with its stage and with `changes`; calls `tick` while it looks for what the
  /// file leaves open. Throws BadScene, NoContext and std::invalid_argument.
  Renderer(scenes::Scene scene, const std::vector<scenes::SceneChange>& changes,
           const PictureOptions& options, const std::function<void()>& tick);
  ~Renderer();

  /// The frame of the clip at `time` (s of the clip), from a simulation of its own.
  picture::Picture frame(double time, const std::function<void()>& tick);
  /// A state, as the scene's camera sees it at the state's time. Throws std::invalid_argument where
  /// its particles are not those of the scene.
  picture::Picture draw(const Snapshot& state);

  const scenes::Scene& scene() const { return scene_; }

 private:
  picture::Picture made(const std::function<picture::Picture(film::Film&)>& draw);

  scenes::Scene scene_;
  World shown_;  // the connectors that pictures have
  bool transparent_;
  std::shared_ptr<DrawingThread> thread_;
  std::unique_ptr<film::Film> film_;  // only its thread touches it
};

}  // namespace taut::python
