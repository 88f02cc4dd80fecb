#include "render/python/drawing_thread.h"

#include <optional>
#include <stdexcept>

namespace taut::python {

std::shared_ptr<DrawingThread> DrawingThread::of(gl::Backend backend) {
  static std::mutex mutex;
  static std::weak_ptr<DrawingThread> running;
  const std::lock_guard lock(mutex);
  std::shared_ptr<DrawingThread> thread = running.lock();
  if (!thread) running = thread = std::make_shared<DrawingThread>(backend);
  if (thread->backend_ != backend) {
    throw std::invalid_argument(
        "backend: another one is drawing already, delete its renderers first");
  }
  return thread;
}

DrawingThread::DrawingThread(gl::Backend backend) : backend_(backend) {
  std::promise<void> ready;
  std::future<void> is_ready = ready.get_future();
  thread_ = std::thread(
      [this, backend, ready = std::move(ready)]() mutable { live(backend, std::move(ready)); });
  try {
    is_ready.get();
  } catch (...) {
    thread_.join();
    throw;
  }
}

DrawingThread::~DrawingThread() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void DrawingThread::live(gl::Backend backend, std::promise<void> ready) {
  std::optional<gl::Context> context;
  try {
    context.emplace(backend);
  } catch (...) {
    ready.set_exception(std::current_exception());
    return;
  }
  ready.set_value();
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [&] { return job_ || ends_; });
    if (!job_) return;
    (*job_)(*context);
    job_ = nullptr;
  }
}

void DrawingThread::run(const std::function<void(const gl::Context&)>& work) {
  const std::lock_guard turn(turn_);
  Job job(work);
  std::future<void> done = job.get_future();
  {
    const std::lock_guard lock(mutex_);
    job_ = &job;
  }
  changed_.notify_all();
  done.wait();
  const std::lock_guard lock(mutex_);  // it has put the job away
  done.get();
}

}  // namespace taut::python
