#include "render/film/render_workers.h"

#include <algorithm>
#include <exception>
#include <mutex>
#include <system_error>

namespace taut::film {

namespace {

int number_of(int threads) {
  return threads > 0 ? threads : std::max(int(std::thread::hardware_concurrency()), 1);
}

}  // namespace

int frames_at_once(int threads) {
  return number_of(threads) < 4 ? 1 : 2;
}

RenderWorkers::RenderWorkers(gl::Backend backend, int threads, bool alone,
                             const scenes::Scene& scene, int width, int height, int samples) {
  threads = number_of(threads);
  const auto paint = [=, &scene](std::optional<Worker>& worker, int share, gl::EglDisplay display) {
    worker.emplace(backend, share, display, scene, width, height, samples);
  };
  if (!alone && frames_at_once(threads) > 1 && backend != gl::Backend::osmesa) {
    std::promise<bool> ready;
    std::future<bool> is_ready = ready.get_future();
    auto help = [paint, threads, ready = std::move(ready), job = job_.get_future()]() mutable {
      std::optional<Worker> worker;
      try {
        paint(worker, threads / 2, gl::EglDisplay::device);
      } catch (...) {  // whatever it is, the own worker meets it, too
      }
      const bool helps = worker && worker->context.is_software();
      ready.set_value(helps);
      if (!helps) return;
      try {
        job.get()(worker->film);
      } catch (const std::future_error&) {  // it is not needed
      }
    };
    bool helps = false;
    try {
      other_ = std::jthread(std::move(help));
      helps = is_ready.get();
    } catch (const std::system_error&) {  // no thread is to be had
    }
    try {
      if (helps) {
        paint(own_, threads / 2, gl::EglDisplay::surfaceless);
        return;
      }
    } catch (const render::NoContext&) {
    }
    stop_other();
  }
  paint(own_, threads, gl::EglDisplay::any);
}

RenderWorkers::~RenderWorkers() {
  stop_other();
}

void RenderWorkers::stop_other() {
  job_ = {};
  if (other_.joinable()) other_.join();
}

void RenderWorkers::run(const std::function<Work()>& next) {
  std::mutex mutex;
  std::exception_ptr failure;
  const auto take = [&]() -> Work {
    const std::lock_guard lock(mutex);
    if (failure) return {};
    try {
      return next();
    } catch (...) {  // no other thread may ask again what has failed
      failure = std::current_exception();
      return {};
    }
  };
  const auto job = [&](Film& film) {
    try {
      while (const Work work = take()) work(film);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  if (other_.joinable()) job_.set_value(job);
  job(own_->film);
  if (other_.joinable()) other_.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace taut::film
