// Values between Python and taut, and numpy arrays that show a simulation's memory.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"
#include "sim/motion/types.h"
#include "sim/world/world.h"

namespace taut::python {
namespace py = pybind11;

/// Numbers in C order, converted where they are of another kind.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

// All throw std::invalid_argument, which calls the value `what`.

/// Three finite numbers.
Vec3 vec3(const py::object& value, const char* what);
/// Four finite numbers, not all zero, as w, x, y, z; made a unit quaternion.
Quat quaternion(const py::object& value, const char* what);
/// An array of that many dimensions whose numbers are finite; `last` of them in the last dimension
/// where that is not 0.
Numbers numbers(const py::object& value, const char* what, py::ssize_t dimensions,
                py::ssize_t last = 0);
/// Rows of three numbers.
std::vector<Vec3> points(const py::object& value, const char* what);

/// Settings of a method from keywords.
Settings settings_of(const py::kwargs& keywords);
py::dict to_dict(const Settings& settings);

/// The index of what has that name in `all`, which is a `kind`.
template <class Named>
std::size_t index_of(const std::vector<Named>& all, const std::string& name, const char* kind);
extern template std::size_t index_of(const std::vector<Connector>&, const std::string&,
                                     const char*);
extern template std::size_t index_of(const std::vector<Body>&, const std::string&, const char*);
extern template std::size_t index_of(const std::vector<Pulley>&, const std::string&, const char*);

template <class Named>
std::vector<std::string> names(const std::vector<Named>& all) {
  std::vector<std::string> list;
  for (const Named& one : all) list.push_back(one.name);
  return list;
}

/// The hold of a particle, from a point and at most one of a body and a path: a point in space, in
/// the body's own frame or in the path's frame (the origin unless given). None without any of them.
std::optional<Attachment> attachment(const World& world, const py::object& point,
                                     const std::optional<std::string>& body,
                                     const std::shared_ptr<const Path>& path);

/// The method and its settings of a scene with others put over them, as the commands of taut do:
/// another method starts from its own settings, a step replaces a tolerance and the other way
/// round. No name: the scene's.
MethodChoice chosen_method(const scenes::Scene& scene, const std::string& name,
                           const Settings& settings);

/// Makes a method of a build that has it, for a world. Throws std::invalid_argument.
std::unique_ptr<Method> made_method(const World& world, const MethodChoice& choice);

// Arrays of numpy that show memory of a simulation.

/// The arrays that show vectors of one object. The object may change, move and free them: before it
/// does, detach() leaves to each array the memory that it shows.
class Windows {
 public:
  /// The vectors as an array (n, 3), without a copy. `owner` keeps them.
  pybind11::array open(std::vector<Vec3>& vectors, std::shared_ptr<const void> owner,
                       bool writeable);

  /// From now on the arrays show what they show now, and the object has memory of its own. Costs
  /// nothing where no array is left.
  void detach();

 private:
  struct Window {
    std::vector<Vec3>* shown = nullptr;
    std::shared_ptr<const void> owner;
    std::vector<Vec3> kept = {};
  };
  std::vector<std::weak_ptr<Window>> open_;
};

}  // namespace taut::python
