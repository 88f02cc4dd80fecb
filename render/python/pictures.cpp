// Pictures as arrays of numpy.
#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <utility>

#include "render/python/renderer.h"
#include "render/python/scene.h"
#include "render/python/signals.h"
#include "render/python/simulation.h"
#include "scenes/load/load_scene.h"

namespace taut::python {
namespace {

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
