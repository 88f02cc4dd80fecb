// The thread that draws: a context belongs to the thread that made it, and objects of Python to
// none.
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <thread>

#include "render/gl/context.h"

namespace taut::python {

/// A thread with a context. All work of one is done in turn.
class DrawingThread {
 public:
  /// The one that is running, or a new one. Throws NoContext, and std::invalid_argument where the
  /// one that is running draws by another backend.
  static std::shared_ptr<DrawingThread> of(gl::Backend backend);

  ~DrawingThread();

  /// Does the work on the thread and waits for it; throws what it throws.
  void run(const std::function<void(const gl::Context&)>& work);

  explicit DrawingThread(gl::Backend backend);

 private:
  using Job = std::packaged_task<void(const gl::Context&)>;
  void live(gl::Backend backend, std::promise<void> ready);

  gl::Backend backend_;
  std::mutex mutex_;
  std::condition_variable changed_;
  Job* job_ = nullptr;
  bool ends_ = false;
  std::mutex turn_;  // of who gives it work
  std::thread thread_;
};

}  // namespace taut::python
