#include "render/python/windows.h"

#include <utility>

namespace taut::python {

namespace py = pybind11;

py::array Windows::open(std::vector<Vec3>& vectors, std::shared_ptr<const void> owner,
                        bool writeable) {
  std::erase_if(open_, [](const auto& window) { return window.expired(); });
  auto window = std::make_shared<Window>(Window{&vectors, std::move(owner)});
  open_.push_back(window);
  using Held = std::shared_ptr<Window>;
  const py::capsule base(new Held(std::move(window)),
                         [](void* held) { delete static_cast<Held*>(held); });
  py::array_t<double> array({py::ssize_t(vectors.size()), py::ssize_t(3)}, vectors.data()->data(),
                            base);
  if (!writeable) array.attr("setflags")(py::arg("write") = false);
  return array;
}

void Windows::detach() {
  for (const std::weak_ptr<Window>& open : std::exchange(open_, {})) {
    const std::shared_ptr<Window> window = open.lock();
    if (!window) continue;
    std::vector<Vec3>& shown = *window->shown;
    std::vector<Vec3> fresh;
    fresh.reserve(shown.capacity());
    fresh = shown;
    window->kept = std::exchange(shown, std::move(fresh));
    window->owner.reset();
  }
}

}  // namespace taut::python
