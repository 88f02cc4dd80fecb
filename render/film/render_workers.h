// Several frames of a clip drawn at the same time.
#pragma once

#include <functional>
#include <future>
#include <optional>
#include <thread>

#include "render/film/film.h"
#include "render/gl/context.h"

namespace taut::film {

/// How many frames so many threads of this machine draw at once; 0: as many as it has. Much of a
/// frame's work is one thread's. Two threads do nearly as much on one frame as on two, which take
/// twice the memory.
int frames_at_once(int threads);

/// Films of the scene that share the threads where these draw. A graphics card has one film.
class RenderWorkers {
 public:
  /// `threads` 0: as many as the machine has. `alone`: one film, come what may. Throws as Context
  /// and Film do.
  RenderWorkers(gl::Backend backend, int threads, bool alone, const scenes::Scene& scene, int width,
                int height, int samples);
  ~RenderWorkers();

  /// The film of the thread that made these.
  Film& film() { return own_->film; }
  const gl::Context& context() const { return own_->context; }

  using Work = std::function<void(Film&)>;
  /// Asks `next` for work, one call at a time, until it gives none; the work is done on the threads
  /// of the films. Throws what the first call or work that failed threw. May be called once.
  void run(const std::function<Work()>& next);

 private:
  struct Worker {
    Worker(gl::Backend backend, int threads, gl::EglDisplay display, const scenes::Scene& scene,
           int width, int height, int samples)
        : context(backend, threads, display), film(context, scene, width, height, samples) {}
    gl::Context context;
    Film film;
  };
  /// Ends the other thread.
  void stop_other();

  std::optional<Worker> own_;
  std::jthread other_;
  std::promise<Work> job_;  // of the other thread: broken, before that is joined, there is none
};

}  // namespace taut::film
