// Several frames of a clip drawn at the same time.
#pragma once

#include <functional>
#include <future>
#include <optional>
#include <thread>

#include "render/context.h"
#include "render/film.h"

namespace taut {

/// Where threads of this machine draw, two films of the scene share them: most of a frame's work is
/// one thread's, so that two frames at once take less time than one after another on all threads.
/// Elsewhere, and where one thread is all there is, one film.
class RenderWorkers {
 public:
  /// `threads` 0: as many as the machine has. `alone`: one film, come what may. Throws as Context
  /// and Film do.
  RenderWorkers(Backend backend, int threads, bool alone, const Scene& scene, int width, int height,
                int samples);
  ~RenderWorkers();

  /// The film of the thread that made these.
  Film& film() { return own_->film; }
  const Context& context() const { return own_->context; }

  /// Calls work(film, i) for every i below `count`, begun in rising order, on the threads of the
  /// films. Throws what the first work that failed threw. May be called once.
  void each(std::size_t count, const std::function<void(Film&, std::size_t)>& work);

 private:
  struct Worker {
    Worker(Backend backend, int threads, Seat seat, const Scene& scene, int width, int height,
           int samples)
        : context(backend, threads, seat), film(context, scene, width, height, samples) {}
    Context context;
    Film film;
  };
  using Job = std::function<void(Film&)>;

  /// Ends the other thread.
  void stop_other();

  std::optional<Worker> own_;
  std::jthread other_;
  std::promise<Job> job_;  // of the other thread: broken, before that is joined, there is none
};

}  // namespace taut
