// Pictures as numpy arrays. They are drawn on a thread of their own: a context belongs to the
// thread that made it, and objects of Python to none.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "render/film/film.h"
#include "render/gl/context.h"
#include "render/python/errors.h"
#include "render/python/scene.h"
#include "render/python/simulation.h"
#include "scenes/load/default_stage.h"
#include "scenes/load/load_scene.h"
#include "scenes/scene/clip.h"
#include "scenes/scene/scene.h"

namespace taut::python {
namespace {

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

// Pictures of a scene, drawn on a thread of their own.

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

Renderer::Renderer(scenes::Scene scene, const std::vector<scenes::SceneChange>& changes,
                   const PictureOptions& options, const std::function<void()>& tick)
    : scene_(std::move(scene)), transparent_(options.transparent) {
  if (options.width > 0) scene_.width = options.width;
  if (options.height > 0) scene_.height = options.height;
  scenes::complete_stage(scene_, changes, tick);
  shown_ = divided(scene_.world, scene_.timeline);
  thread_ = DrawingThread::of(options.backend);
  thread_->run([&](const gl::Context& context) {
    film_ =
        std::make_unique<film::Film>(context, scene_, scene_.width, scene_.height, options.samples);
    film_->set_transparent(transparent_);
  });
}

Renderer::~Renderer() {
  if (thread_) thread_->run([&](const gl::Context&) { film_.reset(); });
}

picture::Picture Renderer::made(const std::function<picture::Picture(film::Film&)>& draw) {
  picture::Picture picture;
  thread_->run([&](const gl::Context&) { picture = draw(*film_); });
  if (!transparent_) {  // the fourth byte is nobody's
    for (std::size_t i = 3; i < picture.pixels.size(); i += 4) picture.pixels[i] = 255;
  }
  return picture;
}

picture::Picture Renderer::frame(double time, const std::function<void()>& tick) {
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene_);
  const double end = static_cast<double>(frames.size()) / scene_.fps;
  if (!(time >= 0 && time <= end)) {
    throw std::invalid_argument(
        fmt::format("time {} s: the clip lasts from 0 to {:g} s", time, end));
  }
  const int frame = std::min(static_cast<int>(std::lround(time * scene_.fps)),
                             static_cast<int>(frames.size()) - 1);
  const auto open = scenes::record(scene_, frames, {frame}, tick);
  const scenes::ClipFrame& wanted = frames[static_cast<std::size_t>(frame)];
  return made(
      [&](film::Film& film) { return film.draw(wanted, film.shutter(wanted, open[0])).picture; });
}

picture::Picture Renderer::draw(const Snapshot& state) {
  const auto same = [](const Connector& connector, const std::vector<Vec3>& particles) {
    return connector.particles() == particles.size();
  };
  if (state.bodies.size() != shown_.bodies.size() ||
      !std::ranges::equal(shown_.connectors, state.connectors, same)) {
    throw std::invalid_argument("the simulation has other particles or bodies than the scene");
  }
  scenes::ClipFrame frame;
  const scenes::Shot shot{0, std::max(state.time, scene_.duration) + 1, 1, scene_.stage->camera};
  frame.shot = &shot;
  frame.time = state.time;
  return made([&](film::Film& film) {
    return film.draw(frame, film.shutter(frame, {0, {state}})).picture;
  });
}

/// Takes the picture's memory.
py::array to_array(picture::Picture picture) {
  auto* const held = new picture::Picture(std::move(picture));
  const py::capsule base(held, [](void* memory) { delete static_cast<picture::Picture*>(memory); });
  return py::array_t<std::uint8_t>({held->height, held->width, 4}, held->pixels.data(), base);
}

PictureOptions picture_options(const py::object& size, int samples, const std::string& backend,
                               bool transparent) {
  PictureOptions options;
  options.samples = samples;
  options.backend = gl::backend_named(backend);
  options.transparent = transparent;
  constexpr int kMost = 64;  // per pixel
  if (samples < 1 || samples > kMost) {
    throw std::invalid_argument(fmt::format("samples: found {}, expected 1 to {}", samples, kMost));
  }
  if (size.is_none()) return options;
  const Numbers two = numbers(size, "size", 1, 2);
  constexpr double kLargest = 16384;  // px
  const auto side = [&](int i) {
    const double length = two.data()[i];
    if (!(length >= 1 && length <= kLargest)) {
      throw std::invalid_argument(
          fmt::format("size: found {}, expected 1 to {} px", length, kLargest));
    }
    return static_cast<int>(length);
  };
  options.width = side(0);
  options.height = side(1);
  return options;
}

/// Ends its thread's work without Python's lock, which a thread that waits for it may have.
struct WithoutLock {
  void operator()(Renderer* renderer) const {
    const py::gil_scoped_release unlocked;
    delete renderer;
  }
};

class RendererObject {
 public:
  RendererObject(const SceneObject& object, const PictureOptions& options) {
    const py::gil_scoped_release unlocked;
    scenes::Scene staged = scenes::load_scene(object.scene.file, true, object.changes);
    scenes::settle_breaks(staged);
    renderer_.reset(new Renderer(std::move(staged), object.changes, options, look_for_signals));
  }

  py::array frame(double time) {
    picture::Picture picture;
    {
      const Turn turn(taken_);
      const py::gil_scoped_release unlocked;
      picture = renderer_->frame(time, look_for_signals);
    }
    return to_array(std::move(picture));
  }

  py::array draw(const SimulationObject& simulation) {
    const Snapshot state = simulation.simulation().state();
    picture::Picture picture;
    {
      const Turn turn(taken_);
      const py::gil_scoped_release unlocked;
      picture = renderer_->draw(state);
    }
    return to_array(std::move(picture));
  }

  py::tuple size() const {
    return py::make_tuple(renderer_->scene().width, renderer_->scene().height);
  }

 private:
  std::unique_ptr<Renderer, WithoutLock> renderer_;
  bool taken_ = false;
};

}  // namespace

void add_pictures(py::module_& module, py::class_<SceneObject>& scene) {
  using namespace py::literals;
  py::class_<RendererObject>(module, "Renderer", "Draws states of a scene, see Scene.renderer().")
      .def(
          "draw", &RendererObject::draw, "simulation"_a,
          R"(The present state of a simulation of the scene, seen by the scene's camera at that time.

Returns a new array (height, width, 4) of uint8: red, green, blue (sRGB) and opacity, the top row
first. Raises ArgumentError where the simulation has other particles than the scene, as after a cut
by hand. Particles that were added by a pin by hand count, too.)")
      .def("frame", &RendererObject::frame, "time"_a,
           R"(The frame of the clip at `time` (s of the clip), as an array like that of draw().

The scene is simulated up to there by its own method; captions, cards, shots and motion blur are
those of the clip. It is the picture of `taut render --poster`. Raises ArgumentError where the clip
is shorter, DivergedError and InterventionError.)")
      .def_property_readonly("size", &RendererObject::size, "(width, height) of the pictures.");
  scene
      .def(
          "renderer",
          [](const SceneObject& object, const py::object& size, int samples,
             const std::string& backend, bool transparent) {
            return std::make_unique<RendererObject>(
                object, picture_options(size, samples, backend, transparent));
          },
          py::kw_only(), "size"_a = py::none(), "samples"_a = 4, "backend"_a = "auto",
          "transparent"_a = false,
          R"(Makes ready to draw pictures of the scene, on a thread of its own.

size: (width, height), or None: the scene's. samples: per pixel. backend: "auto", "egl" or
"osmesa". transparent: opacity 0 where the background would be. Raises SceneError, AssetError,
ContextError and ArgumentError.)")
      .def(
          "render",
          [](const SceneObject& object, double time, const py::object& size, int samples,
             const std::string& backend, bool transparent) {
            return RendererObject(object, picture_options(size, samples, backend, transparent))
                .frame(time);
          },
          "time"_a, py::kw_only(), "size"_a = py::none(), "samples"_a = 4, "backend"_a = "auto",
          "transparent"_a = false, "One frame of the clip: Renderer.frame() of renderer().");
}

}  // namespace taut::python
