#include "render/python/simulation.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <stdexcept>

#include "render/base/atomic_file.h"
#include "render/python/errors.h"
#include "render/python/world.h"
#include "scenes/files/files.h"
#include "sim/measure/measure.h"
#include "sim/run/forces.h"

namespace taut::python {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kSlice = 0.02;  // s from one look for signals to the next, about

std::vector<double> times_of(const Timeline& timeline) {
  std::vector<double> times;
  for (const TimedPin& pin : timeline.pins) times.insert(times.end(), {pin.from, pin.until});
  for (const TimedCut& cut : timeline.cuts) times.push_back(cut.time);
  std::ranges::sort(times);
  return times;
}

}  // namespace

SimulationObject::SimulationObject(const World& world, MethodChoice method, Timeline timeline,
                                   double fps)
    : method_(std::move(method)),
      fps_(fps),
      timed_(!timeline.empty()),
      happens_(times_of(timeline)),
      simulation_(world, made_method(world, method_), std::move(timeline)) {
  step_ = step_of(method_.settings);
  may_break_ = std::ranges::any_of(
      world.connectors, [](const Connector& one) { return std::isfinite(one.breaks_at); });
}

double SimulationObject::next_stop(double until) {
  const double now = simulation_.world().time;
  if (step_ > 0) {
    // Stops on the grid of the steps leave every bit as it is.
    return now + (stride_ + 1) * step_ < until ? std::round(now / step_ + stride_) * step_ : until;
  }
  double frame = std::floor(now * fps_);
  while (!(frame / fps_ > now)) ++frame;
  constexpr double kSame = 1e-6;  // of a frame
  return frame / fps_ < until - kSame / fps_ ? frame / fps_ : until;
}

void SimulationObject::detach_before(double until) {
  const std::size_t before = happened_;
  while (happened_ < happens_.size() && happens_[happened_] <= until) ++happened_;
  if (happened_ > before || may_break_) windows_.detach();
}

void SimulationObject::advance(double until) {
  if (!(std::isfinite(until) && until >= world().time)) {
    throw std::invalid_argument(fmt::format(
        "until {} s: the simulation is at {} s, and goes forward", until, world().time));
  }
  if (const std::string wrong = step_complaint(method_.settings, until - world().time);
      !wrong.empty()) {
    throw std::invalid_argument(wrong);
  }
  const Turn turn(taken_);
  const py::gil_scoped_release unlocked;
  events_.clear();
  do {
    const auto begin = Clock::now();
    const double next = next_stop(until);
    detach_before(next);
    simulation_.advance_to(next);
    for (const Event& event : simulation_.take_events()) events_.push_back(event);
    const double spent = std::chrono::duration<double>(Clock::now() - begin).count();
    if (spent < kSlice / 2) stride_ *= 2;
    if (spent > kSlice && stride_ > 1) stride_ /= 2;
    look_for_signals();
  } while (simulation_.world().time < until);
}

void SimulationObject::refuse_unless_done(const char* what, Outcome outcome) const {
  if (outcome == Outcome::done) return;
  const double time = simulation_.world().time;
  throw Refused(fmt::format("{} at {} s: {}", what, time, words(outcome)), time);
}

std::uint64_t SimulationObject::pin(const std::string& connector, double along,
                                    const std::optional<Attachment>& to, double over) {
  const std::size_t index = index_of(world().connectors, connector, "connector");
  windows_.detach();
  Interventions& interventions = simulation_.interventions();
  const Pinned pinned = to ? interventions.pin(simulation_.world(), index, along, *to, over)
                           : interventions.pin(simulation_.world(), index, along);
  refuse_unless_done("pin", pinned.outcome);
  return pinned.pin;
}

void SimulationObject::move(std::uint64_t pin, const Attachment& to, double over) {
  refuse_if_taken(taken_);
  refuse_unless_done("move", simulation_.interventions().move(simulation_.world(), pin, to, over));
}

void SimulationObject::release(std::uint64_t pin) {
  refuse_if_taken(taken_);
  windows_.detach();
  refuse_unless_done("release", simulation_.interventions().release(simulation_.world(), pin));
}

std::string SimulationObject::cut(const std::string& connector, double along) {
  if (timed_) {
    throw std::invalid_argument(
        "the scene has pins or cuts of its own: write this cut into the scene, as [[cuts]]");
  }
  const std::size_t index = index_of(world().connectors, connector, "connector");
  windows_.detach();
  const Divided divided = simulation_.interventions().cut(simulation_.world(), index, along);
  refuse_unless_done("cut", divided.outcome);
  return world().connectors[divided.connector].name;
}

void SimulationObject::save(const std::filesystem::path& file) const {
  const std::string bytes = simulation().save();
  render::AtomicFile out(file);
  out.write(bytes);
  out.commit();
}

void SimulationObject::load(const std::filesystem::path& file) {
  constexpr std::size_t kLargest = std::size_t{1} << 30;
  const std::string bytes = scenes::read_regular_file(file, kLargest, "a state that save() wrote");
  refuse_if_taken(taken_);
  windows_.detach();
  try {
    simulation_.load(bytes);
  } catch (const BadState& bad) {
    throw scenes::bad_asset(file, bad.what());
  }
  happened_ = 0;
  while (happened_ < happens_.size() && happens_[happened_] <= simulation_.world().time) {
    ++happened_;
  }
  events_.clear();
}

std::vector<Vec3>& SimulationObject::particles(const std::string& connector,
                                               std::vector<Vec3> Connector::*which) {
  refuse_if_taken(taken_);
  auto& all = simulation_.world().connectors;
  return all[index_of(all, connector, "connector")].*which;
}

py::array SimulationObject::positions(const std::string& connector) {
  return windows_.open(particles(connector, &Connector::position), shared_from_this(), false);
}

py::array SimulationObject::velocities(const std::string& connector) {
  return windows_.open(particles(connector, &Connector::velocity), shared_from_this(), false);
}

py::array SimulationObject::pose(const std::string& name) const {
  const std::size_t body = index_of(world().bodies, name, "body");
  const Pose frame = simulation().state().bodies[body];
  const Quat& q = frame.rotation;
  const double all[] = {
      frame.position.x(), frame.position.y(), frame.position.z(), q.w(), q.x(), q.y(), q.z()};
  return py::array_t<double>(7, all);
}

double SimulationObject::passed(const std::string& pulley) const {
  return world().pulleys[index_of(world().pulleys, pulley, "pulley")].passed;
}

namespace {

py::dict counters(const SimulationObject& object) {
  const Counters& counted = object.simulation().method().counters();
  py::dict all;
  all["steps"] = counted.steps;
  all["solves"] = counted.solves;
  all["rejected"] = counted.rejected;
  all["handed_over"] = counted.handed_over;
  return all;
}

py::tuple cells(const Named& of) {
  return py::make_tuple(of.name, of.part);
}

py::array array_of(const Vec3& v) {
  return py::array_t<double>(3, v.data());
}

py::dict forces(const SimulationObject& object) {
  using namespace py::literals;
  const World& world = object.world();
  const Forces found = forces_of(world);
  std::map<std::string, std::vector<double>> tensions;
  for (const Forces::Link& at : found.links) {
    tensions[world.connectors[at.connector].name].push_back(at.tension);
  }
  py::dict by_name;
  for (const auto& [name, of] : tensions) {
    by_name[py::str(name)] = py::array_t<double>(static_cast<py::ssize_t>(of.size()), of.data());
  }
  py::list holds, contacts;
  for (const Forces::Hold& at : found.holds) {
    holds.append(py::dict("connector"_a = world.connectors[at.connector].name,
                          "particle"_a = at.particle, "place"_a = array_of(at.place),
                          "force"_a = array_of(at.force), "moment"_a = array_of(at.moment)));
  }
  for (const Forces::Contact& at : found.contacts) {
    contacts.append(py::dict("of"_a = cells(named(world, at.one)),
                             "other"_a = cells(named(world, at.other)),
                             "place"_a = array_of(at.place), "normal"_a = array_of(at.normal),
                             "force"_a = array_of(at.force)));
  }
  return py::dict("tensions"_a = by_name, "holds"_a = holds, "contacts"_a = contacts);
}

py::list events(const SimulationObject& object) {
  using namespace py::literals;
  const World& world = object.world();
  py::list all;
  for (const Event& event : object.events()) {
    py::dict told("kind"_a = std::string(kind_name(event.kind)), "time"_a = event.time,
                  "size"_a = event.size);
    if (event.of_contact) {
      told["of"] = cells(named(world, event.one));
      told["other"] = cells(named(world, event.other));
      told["place"] = array_of(event.place);
    } else {
      told["of"] =
          py::make_tuple(world.connectors[event.connector].name, std::to_string(event.span));
    }
    all.append(told);
  }
  return all;
}

}  // namespace

void add_simulation(py::module_& module) {
  using namespace py::literals;
  using Sim = SimulationObject;
  py::class_<Sim, std::shared_ptr<Sim>>(module, "Simulation", R"(A world, a method and a clock.

Settings of the method are keywords: Simulation(world, "direct", tolerance=1e-4). Raises
ArgumentError where the method or a setting is wrong. fps: frames per second at which a method that
chooses its own steps stops on its way.)")
      .def(py::init([](const WorldObject& world, const std::string& method, double fps,
                       const py::kwargs& settings) {
             if (!(fps > 0 && fps <= 1e6))
               throw std::invalid_argument(
                   fmt::format("fps: found {}, expected a number above 0", fps));
             return std::make_shared<Sim>(
                 world.world(), MethodChoice{method, settings_of(settings)}, Timeline{}, fps);
           }),
           "world"_a, "method"_a = "direct", py::kw_only(), "fps"_a = 60.0)
      .def("advance", &Sim::advance, "until"_a, R"(Goes to the time `until` (s).

A method with a step goes in equal steps. One that chooses its steps stops at every frame on its
way, as the commands of taut do: the same frames have the same bits. Python's lock is free
meanwhile, and Ctrl-C ends it between two steps or frames. It also ends a step of more than half a second; the
simulation cannot continue after that. Raises DivergedError, InterventionError,
and ArgumentError where `until` has passed.)")
      .def("save", &Sim::save, "file"_a,
           R"(Writes the present state into a file. `taut simulate` reads it, too.

Raises Error where the file cannot be written, or a pin is on a path that came later.)")
      .def("load", &Sim::load, "file"_a,
           R"(Goes on from a state that a simulation of the same world or scene saved.

By whatever method, which begins anew: one with a step and without friction goes on to the bit.
Raises AssetError: not there, damaged, or of another world.)")
      .def(
          "pin",
          [](Sim& sim, const std::string& connector, double along, const py::object& point,
             const std::optional<std::string>& body, const std::shared_ptr<Path>& path,
             double over) {
            return sim.pin(connector, along, attachment(sim.world(), point, body, path), over);
          },
          "connector"_a, "along"_a, py::kw_only(), "point"_a = py::none(),
          "body"_a = std::optional<std::string>(), "path"_a = std::shared_ptr<Path>(),
          "over"_a = 0.0,
          R"(Holds the connector at `along` (m of its length) and returns the pin's number.

Without point, body and path it is held where it is. point: (3,) m in space or, with a body or a
path, in its frame. over: s in which it is drawn there. Raises InterventionError.)")
      .def(
          "move",
          [](Sim& sim, std::uint64_t pin, const py::object& point,
             const std::optional<std::string>& body, const std::shared_ptr<Path>& path,
             double over) {
            const auto to = attachment(sim.world(), point, body, path);
            if (!to) throw std::invalid_argument("move: expected a point, a body or a path");
            sim.move(pin, *to, over);
          },
          "pin"_a, py::kw_only(), "point"_a = py::none(), "body"_a = std::optional<std::string>(),
          "path"_a = std::shared_ptr<Path>(), "over"_a = 0.0,
          "Takes what the pin holds to another place, within `over` (s). Raises InterventionError.")
      .def("release", &Sim::release, "pin"_a, "Lets go. Raises InterventionError.")
      .def("cut", &Sim::cut, "connector"_a, "along"_a,
           "Divides the connector at `along` (m of its length) for good; returns the name of the "
           "second\n"
           "part. Raises InterventionError, and ArgumentError where the scene has pins or cuts.")
      .def(
          "positions", &Sim::positions, "connector"_a,
          R"(The particles as an array (n, 3) of m: memory of the simulation, read-only, not a copy.

It shows the present state until a pin, release, cut or load (a scene's own included) changes the
particles, or where connectors may break until the next advance; from then on it keeps what it showed last, and positions() gives another one. It keeps
the simulation's memory alive. A body that is simulated as a link is a particle more.)")
      .def("velocities", &Sim::velocities, "connector"_a,
           "Their velocities, (n, 3) m/s, in the same way.")
      .def("pose", &Sim::pose, "body"_a,
           "A body's own frame as a new array (7,): x, y, z (m), qw, qx, qy, qz.")
      .def("passed", &Sim::passed, "pulley"_a,
           "How much rope has passed a scene's pulley since the start, m.")
      .def("forces", &forces,
           R"(The forces that the scene's laws give in the present state, in newtons.

tensions: of each connector's links, an array (links,), negative where one pushes; where there are
some. holds: a list of dicts with connector, particle, place (3,) in m and force (3,) on the
particle. contacts: a list of dicts with of and other, each (name, part), place (3,), normal (3,) out
of the other and force (3,). Raises Diverged where no forces satisfy the laws.)")
      .def_property_readonly("events", &events,
                             R"(What happened in the last advance(), in order of time.

A list of dicts: kind (taut, impulse, slack, break; of contacts hit, impulse, leave, slide, stick), time
(s), size (N s, of a hit or an impulse, N of a break, else 0), of (name, part) and, of contacts, other (name, part)
and place (3,) in m.)")
      .def_property_readonly(
          "time", [](const Sim& sim) { return sim.world().time; }, "s")
      .def_property_readonly(
          "method", [](const Sim& sim) { return sim.method().name; }, "The method's name.")
      .def_property_readonly(
          "settings", [](const Sim& sim) { return to_dict(with_defaults(sim.method())); },
          "Every setting of the method.")
      .def_property_readonly(
          "connectors", [](const Sim& sim) { return names(sim.world().connectors); },
          "Names of the connectors that there are now.")
      .def_property_readonly(
          "bodies", [](const Sim& sim) { return names(sim.world().bodies); },
          "Names of the bodies.")
      .def_property_readonly(
          "kinetic_energy", [](const Sim& sim) { return kinetic_energy(sim.world()); }, "J")
      .def_property_readonly(
          "potential_energy", [](const Sim& sim) { return potential_energy(sim.world()); },
          "J, zero at the origin")
      .def_property_readonly(
          "stretch", [](const Sim& sim) { return stretch_max(sim.world()); },
          "The largest |length / rest length - 1| of any link.")
      .def_property_readonly("counters", counters,
                             "What the method did: steps, solves, rejected, handed_over.")
      .def_property_readonly(
          "state_hash",
          [](const Sim& sim) { return fmt::format("{:016x}", state_hash(sim.world())); },
          "A hash of the state, bit for bit, as `taut simulate --json` has it.");
}

}  // namespace taut::python
