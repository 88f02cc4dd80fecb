#include "render/python/convert.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace taut::python {

Numbers numbers(const py::object& value, const char* what, py::ssize_t dimensions,
                py::ssize_t last) {
  const Numbers found = Numbers::ensure(value);
  if (!found) {
    PyErr_Clear();
    throw std::invalid_argument(fmt::format("{}: expected numbers, found {}", what,
                                            std::string(py::str(py::type::of(value)))));
  }
  const bool fits =
      found.ndim() == dimensions && (last == 0 || found.shape(dimensions - 1) == last);
  if (!fits) {
    std::string shape;
    for (py::ssize_t d = 0; d < dimensions; ++d) {
      shape += fmt::format("{}{}", d > 0 ? ", " : "",
                           d == dimensions - 1 && last > 0 ? std::to_string(last) : "any");
    }
    throw std::invalid_argument(
        fmt::format("{}: expected an array of shape ({}), found ({})", what, shape,
                    fmt::join(found.shape(), found.shape() + found.ndim(), ", ")));
  }
  const double* begin = found.data();
  if (!std::all_of(begin, begin + found.size(), [](double x) { return std::isfinite(x); })) {
    throw std::invalid_argument(fmt::format("{}: expected finite numbers", what));
  }
  return found;
}

Vec3 vec3(const py::object& value, const char* what) {
  const Numbers three = numbers(value, what, 1, 3);
  return {three.data()[0], three.data()[1], three.data()[2]};
}

Quat quaternion(const py::object& value, const char* what) {
  const Numbers four = numbers(value, what, 1, 4);
  const Quat q(four.data()[0], four.data()[1], four.data()[2], four.data()[3]);
  if (!(q.norm() > 0)) throw std::invalid_argument(fmt::format("{}: all zero", what));
  return q.normalized();
}

std::vector<Vec3> points(const py::object& value, const char* what) {
  const Numbers rows = numbers(value, what, 2, 3);
  std::vector<Vec3> list;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    list.emplace_back(rows.data()[3 * i], rows.data()[3 * i + 1], rows.data()[3 * i + 2]);
  }
  return list;
}

Settings settings_of(const py::kwargs& keywords) {
  Settings settings;
  for (const auto& [key, value] : keywords) {
    const auto name = py::cast<std::string>(key);
    if (py::isinstance<py::bool_>(value)) {
      settings[name] = py::cast<bool>(value);
    } else if (py::isinstance<py::str>(value)) {
      settings[name] = py::cast<std::string>(value);
    } else if (PyNumber_Check(value.ptr())) {
      settings[name] = py::cast<double>(py::float_(py::reinterpret_borrow<py::object>(value)));
    } else {
      throw std::invalid_argument(fmt::format("{}: expected a number, a flag or a text", name));
    }
  }
  return settings;
}

py::dict to_dict(const Settings& settings) {
  py::dict dict;
  for (const auto& [name, value] : settings) {
    std::visit([&, key = name.c_str()](const auto& v) { dict[key] = v; }, value);
  }
  return dict;
}

template <class Named>
std::size_t index_of(const std::vector<Named>& all, const std::string& name, const char* kind) {
  const auto found = std::ranges::find(all, name, &Named::name);
  if (found != all.end()) return static_cast<std::size_t>(found - all.begin());
  const auto known = names(all);
  throw std::invalid_argument(fmt::format(
      "there is no {} \"{}\", expected {}", kind, name,
      known.empty() ? "none: there are none" : fmt::format("one of: {}", fmt::join(known, ", "))));
}
template std::size_t index_of(const std::vector<Connector>&, const std::string&, const char*);
template std::size_t index_of(const std::vector<Body>&, const std::string&, const char*);
template std::size_t index_of(const std::vector<Pulley>&, const std::string&, const char*);

std::optional<Attachment> attachment(const World& world, const py::object& point,
                                     const std::optional<std::string>& body,
                                     const std::shared_ptr<const Path>& path) {
  if (body && path) throw std::invalid_argument("expected a body or a path, found both");
  if (point.is_none() && !body && !path) return std::nullopt;
  Attachment to;
  if (!point.is_none()) to.point = vec3(point, "point");
  if (body) {
    to.kind = Attachment::Kind::body;
    to.body = index_of(world.bodies, *body, "body");
  } else if (path) {
    to.kind = Attachment::Kind::path;
    to.path = path;
  }
  return to;
}

namespace {

const MethodInfo& existing_method(const std::string& name) {
  const std::string wrong = method_complaint(name);
  if (!wrong.empty()) throw std::invalid_argument(wrong);
  return *find_method(name);
}

}  // namespace

MethodChoice chosen_method(const scenes::Scene& scene, const std::string& name,
                           const Settings& settings) {
  MethodChoice choice = scene.method;
  if (!name.empty() && name != choice.name) choice = {name, {}};
  existing_method(choice.name);
  for (const auto& [key, value] : settings) {
    if (key == "tolerance") choice.settings.erase("step");
    choice.settings[key] = value;
    const double* step = key == "step" ? std::get_if<double>(&value) : nullptr;
    if (!step) continue;
    choice.settings.erase("tolerance");
    if (!(*step > 0)) continue;
    const auto exact = scenes::dividing_step(*step, scene.fps);
    if (!exact) {
      throw std::invalid_argument(
          fmt::format("step {}: expected {}", *step, scenes::dividing_text(*step, scene.fps)));
    }
    choice.settings["step"] = *exact;
  }
  return choice;
}

std::unique_ptr<Method> made_method(const World& world, const MethodChoice& choice) {
  const MethodInfo& method = existing_method(choice.name);
  if (const std::string wrong = refusal(method, world); !wrong.empty()) {
    throw std::invalid_argument(fmt::format("{} {}", choice.name, wrong));
  }
  return make_method(choice.name, choice.settings);
}

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
