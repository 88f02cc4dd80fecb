// Thousands of connectors at once.
#include "sim/batch/batch.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>
#include <variant>

#include "render/python/errors.h"
#include "render/python/scene.h"

namespace taut::python {
namespace {

using Clock = std::chrono::steady_clock;

/// One number for all ropes, or one for each.
std::vector<double> one_or_each(const py::object& value, const char* what, std::size_t ropes,
                                double least) {
  const Numbers found = numbers(py::module_::import("numpy").attr("atleast_1d")(value), what, 1);
  std::vector<double> all(found.data(), found.data() + found.size());
  if (all.size() == 1) all.assign(ropes, all[0]);
  if (all.size() != ropes) {
    throw std::invalid_argument(
        fmt::format("{}: expected 1 or {} numbers, found {}", what, ropes, all.size()));
  }
  for (const double x : all) {
    if (!(x >= least))
      throw std::invalid_argument(fmt::format("{}: found {}, expected {} or more", what, x, least));
  }
  return all;
}

/// The hold of a rope's first particle: the point where it is, or that point of the path's frame.
Attachment carried(const Vec3& first, const std::shared_ptr<const Path>& path) {
  Attachment to;
  to.point = first;
  if (!path) return to;
  to.kind = Attachment::Kind::path;
  to.path = path;
  const Pose frame = path->at(0).pose();
  to.point = frame.rotation.conjugate() * (first - frame.position);
  return to;
}

struct BatchOptions {
  Numbers positions, velocities;
  std::vector<double> mass, end_mass;  // kg
  std::shared_ptr<const Path> path;
  Vec3 gravity;
};

World world_of(const BatchOptions& options) {
  const auto ropes = static_cast<std::size_t>(options.positions.shape(0));
  const auto particles = static_cast<std::size_t>(options.positions.shape(1));
  if (particles < 2)
    throw std::invalid_argument("positions: expected at least 2 particles in a rope");
  World world;
  world.gravity = options.gravity;
  const double *at = options.positions.data(), *moving = options.velocities.data();
  for (std::size_t i = 0; i < ropes; ++i) {
    Connector rope;
    rope.mass = options.mass[i];
    rope.particle_mass.assign(particles, rope.mass / static_cast<double>(particles));
    rope.particle_mass.back() += options.end_mass[i];
    for (std::size_t k = 0; k < particles; ++k, at += 3, moving += 3) {
      rope.position.emplace_back(at[0], at[1], at[2]);
      rope.velocity.emplace_back(moving[0], moving[1], moving[2]);
      if (k == 0) continue;
      rope.rest.push_back((rope.position[k] - rope.position[k - 1]).norm());
      rope.length += rope.rest.back();
    }
    rope.holds = {{0, carried(rope.position[0], options.path), {}}};
    world.connectors.push_back(std::move(rope));
  }
  finish(world);
  return world;
}

/// A batch, its world and what numpy sees of it.
class BatchObject {
 public:
  BatchObject(const BatchOptions& options, double step, bool single)
      : world_(world_of(options)), step_(step), positions_(shape()), velocities_(shape()) {
    if (!(step > 0 && std::isfinite(step))) {
      throw std::invalid_argument(fmt::format("step: found {}, expected a number above 0", step));
    }
    if (single) {
      batch_.emplace<batch::Batch<float>>(world_, step);
    } else {
      batch_.emplace<batch::Batch<double>>(world_, step);
    }
    read();
  }

  void advance(double until, int threads) {
    if (!(std::isfinite(until) && until >= world_.time)) {
      throw std::invalid_argument(
          fmt::format("until {} s: the batch is at {} s, and goes forward", until, world_.time));
    }
    if (threads < 0) throw std::invalid_argument("threads: expected 0 or more");
    const int workers =
        threads > 0 ? threads : std::max(1, int(std::thread::hardware_concurrency()));
    const Turn turn(taken_);
    const py::gil_scoped_release unlocked;
    try {
      std::visit([&](auto& batch) { go(batch, until, workers); }, batch_);
    } catch (...) {  // the arrays show how far it came
      read();
      throw;
    }
    read();
  }

  double time() const { return world_.time; }
  const py::array_t<double>& positions() const { return positions_; }
  const py::array_t<double>& velocities() const { return velocities_; }

 private:
  std::vector<py::ssize_t> shape() const {
    return {py::ssize_t(world_.connectors.size()),
            py::ssize_t(world_.connectors.front().particles()), 3};
  }

  void go(std::monostate&, double, int) {}

  /// Looks for signals at multiples of the step, which changes no bit.
  template <class Scalar>
  void go(batch::Batch<Scalar>& batch, double until, int threads) {
    do {
      const double now = batch.time();
      const bool short_of = now + (stride_ + 1) * step_ < until;
      const auto begin = Clock::now();
      batch.advance(short_of ? std::round(now / step_ + stride_) * step_ : until, threads);
      if (Clock::now() - begin < std::chrono::milliseconds(100))
        stride_ *= 2;
      else if (stride_ > 1)
        stride_ /= 2;
      look_for_signals();
    } while (batch.time() < until);
  }

  void read() {
    std::visit([&](const auto& batch) { store(batch); }, batch_);
    double *at = positions_data_, *moving = velocities_data_;
    for (const Connector& rope : world_.connectors) {
      for (const Vec3& position : rope.position) at = std::ranges::copy(position, at).out;
      for (const Vec3& velocity : rope.velocity) moving = std::ranges::copy(velocity, moving).out;
    }
  }
  void store(const std::monostate&) {}
  template <class Scalar>
  void store(const batch::Batch<Scalar>& batch) {
    batch.store(world_);
  }

  World world_;
  double step_;
  double stride_ = 1;  // steps from one look for signals to the next
  std::variant<std::monostate, batch::Batch<float>, batch::Batch<double>> batch_;
  py::array_t<double> positions_, velocities_;
  double* positions_data_ = positions_.mutable_data();
  double* velocities_data_ = velocities_.mutable_data();
  bool taken_ = false;
};

std::unique_ptr<BatchObject> make(const py::object& positions, const py::object& mass, double step,
                                  const py::object& velocities, const py::object& end_mass,
                                  const std::shared_ptr<Path>& path, const py::object& gravity,
                                  const std::string& dtype) {
  if (dtype != "float64" && dtype != "float32") {
    throw std::invalid_argument(
        fmt::format("dtype: found \"{}\", expected \"float64\" or \"float32\"", dtype));
  }
  BatchOptions options{
      numbers(positions, "positions", 3, 3), {}, {}, {}, path, vec3(gravity, "gravity")};
  const auto& shape = options.positions;
  const auto ropes = static_cast<std::size_t>(shape.shape(0));
  if (velocities.is_none()) {
    options.velocities = Numbers(std::vector<py::ssize_t>(shape.shape(), shape.shape() + 3));
    std::fill_n(options.velocities.mutable_data(), options.velocities.size(), 0.0);
  } else {
    options.velocities = numbers(velocities, "velocities", 3, 3);
    if (!std::equal(shape.shape(), shape.shape() + 3, options.velocities.shape())) {
      throw std::invalid_argument("velocities: expected the shape of positions");
    }
  }
  options.mass = one_or_each(mass, "mass", ropes, std::numeric_limits<double>::min());
  options.end_mass = one_or_each(end_mass, "end_mass", ropes, 0);
  return std::make_unique<BatchObject>(options, step, dtype == "float32");
}

}  // namespace

void add_batch(py::module_& module) {
  using namespace py::literals;
  py::class_<BatchObject>(
      module, "Batch",
      R"(Thousands of ropes with as many particles each, stepped together on all cores.

positions: (ropes, n, 3) m; links are as long as they are here, the first particles are held. mass:
kg of a rope, one or (ropes,). step: s, the longest. velocities: (ropes, n, 3) m/s, or None: at
rest. end_mass: kg of a point mass on the last particle, one or (ropes,). path: what carries the
first particles; without one they stay. dtype: "float64", or "float32", twice as fast, with errors
of some 1e-5 of the length. Links are exactly rigid; ropes do not touch. The bits of a rope are
those of it alone, on any number of threads. Raises ArgumentError.)")
      .def(py::init(&make), "positions"_a, "mass"_a, "step"_a, py::kw_only(),
           "velocities"_a = py::none(), "end_mass"_a = 0.0, "path"_a = std::shared_ptr<Path>(),
           "gravity"_a = py::make_tuple(0.0, -9.81, 0.0), "dtype"_a = "float64")
      .def("advance", &BatchObject::advance, "until"_a, "threads"_a = 0,
           R"(Goes to the time `until` (s) in equal steps, on so many threads (0: all).

Python's lock is free meanwhile, and Ctrl-C ends it between two steps. Raises DivergedError, where
the step is too long.)")
      .def_property_readonly("time", &BatchObject::time, "s")
      .def_property_readonly("positions", &BatchObject::positions,
                             "(ropes, n, 3) m: one array, which advance() brings up to date.")
      .def_property_readonly("velocities", &BatchObject::velocities,
                             "(ropes, n, 3) m/s, in the same way.");
}

}  // namespace taut::python
