// The simulations of the page, as functions that JavaScript calls. Each instance of the module has
// one simulation: a world whose hand moves while it runs, by one method.
#include <cstddef>
#include <exception>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <typeinfo>
#include <utility>
#include <vector>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"

namespace taut::page {
namespace {

/// The hand's path from one frame to the next. It is replaced in place before each frame, so that
/// the methods go on without a restart: position and velocity are continuous, and the acceleration
/// is zero at every frame.
std::shared_ptr<Path> hand;
std::optional<Simulation> simulation;
std::vector<double> points;  // m, x and y
std::string state;

constexpr double kStick = 0.3;  // m, the length of a stick

World rope() {
  World world;
  world.connectors = {straight_connector("rope", 1.0, 0.1, 21, Vec3::Zero(), Vec3::UnitX())};
  Connector& rope = world.connectors[0];
  rope.holds = {{.particle = 0, .to = {.kind = Attachment::Kind::path, .path = hand}}};
  rope.particle_mass.back() += 0.2;  // kg
  return world;
}

/// The hand holds one stick in its middle, at a slant; the other one starts level.
World nunchaku() {
  World world;
  const Vec3 tip(0, kStick / 2, 0);
  Body held{.name = "held", .mass_properties = solid_cylinder(0.12, kStick, 0.028)};
  held.bare = held.mass_properties;
  held.path = hand;
  const Vec3 start = hand->at(0).rotation * tip;
  Body stick{.name = "stick", .mass_properties = held.mass_properties};
  stick.bare = stick.mass_properties;
  stick.rotation = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitZ());
  Connector chain = straight_connector("chain", 0.12, 0.012, 11, start, Vec3::UnitX());
  stick.position = chain.position.back() - stick.rotation * tip;
  chain.holds = {{.particle = 0, .to = {.kind = Attachment::Kind::body, .point = tip, .body = 0}},
                 {.particle = 10, .to = {.kind = Attachment::Kind::body, .point = tip, .body = 1}}};
  world.bodies = {held, stick};
  world.connectors = {chain};
  return world;
}

constexpr double kSlant = -0.6;  // rad, of the stick in the hand

Path path_of(double time, const Vec3& position, const Vec3& velocity, double until, const Vec3& to,
             const Vec3& velocity_there, bool slants) {
  Quat rotation = Quat::Identity();
  if (slants) rotation = Eigen::AngleAxisd(kSlant, Vec3::UnitZ());
  return Path(
      {{time, position, rotation, true, velocity}, {until, to, rotation, true, velocity_there}});
}

void put(const Vec3& at) {
  points.push_back(at.x());
  points.push_back(at.y());
}

}  // namespace

/// JavaScript's: throws there, and the instance is of no use afterwards.
[[noreturn]] __attribute__((import_module("page"), import_name("fail"))) void fail(
    const char* message, std::size_t size);

#define TAUT_EXPORT(name) __attribute__((export_name(#name)))

extern "C" {

/// Starts the world, 0: the rope, 1: the nunchaku, by the method `name` with one setting.
TAUT_EXPORT(start) void start(int which, int method, double setting) {
  const bool slants = which == 1;
  hand = std::make_shared<Path>(
      path_of(0, Vec3::Zero(), Vec3::Zero(), 1, Vec3::Zero(), Vec3::Zero(), slants));
  constexpr const char* kMethods[] = {"direct", "xpbd", "springs"};
  constexpr const char* kSettings[] = {"tolerance", "step", "stiffness"};
  simulation.reset();
  simulation.emplace(slants ? nunchaku() : rope(),
                     make_method(kMethods[method], {{kSettings[method], setting}}));
}

/// The hand's motion from `time` (s) to `until`: from (x, y) (m) and (vx, vy) (m/s) to (x1, y1) and
/// (vx1, vy1). Call it before each advance to `until`, and before load().
TAUT_EXPORT(move)
void move(double time, double x, double y, double vx, double vy, double until, double x1, double y1,
          double vx1, double vy1) {
  const bool slants = !std::as_const(*simulation).world().bodies.empty();
  *hand = path_of(time, Vec3(x, y, 0), Vec3(vx, vy, 0), until, Vec3(x1, y1, 0), Vec3(vx1, vy1, 0),
                  slants);
}
TAUT_EXPORT(advance) void advance(double time) {
  simulation->advance_to(time);
}

/// Fills points(): the particles, then both ends of each stick. Returns their number.
TAUT_EXPORT(count) std::size_t count() {
  const World& world = std::as_const(*simulation).world();
  points.clear();
  for (const Vec3& position : world.connectors[0].position) put(position);
  for (const Body& body : world.bodies) {
    put(body.point({0, kStick / 2, 0}));
    put(body.point({0, -kStick / 2, 0}));
  }
  return points.size() / 2;
}
TAUT_EXPORT(points) const double* points_of() {
  return points.data();
}

/// J, kinetic and potential.
TAUT_EXPORT(energy) double energy_of() {
  return taut::energy(std::as_const(*simulation).world());
}
/// J, to lift everything by the length of the connector.
TAUT_EXPORT(lift) double lift() {
  const World& world = std::as_const(*simulation).world();
  return energy_scale(world) - kinetic_energy(world);
}
/// Of the links: the largest |length / rest length - 1|.
TAUT_EXPORT(stretch) double stretch() {
  return stretch_max(std::as_const(*simulation).world());
}
/// The processor's cycles since the start as the method counts them: the same on every machine.
TAUT_EXPORT(cycles) double cycles() {
  return simulation->method().counters().cycles;
}

/// The state of a simulation as bytes, which another instance of the same world can go on from.
TAUT_EXPORT(save) std::size_t save() {
  state = simulation->save();
  return state.size();
}
TAUT_EXPORT(bytes) char* bytes(std::size_t size) {
  state.resize(size);
  return state.data();
}
TAUT_EXPORT(load) void load() {
  simulation->load(state);
}

// The libraries of WASI have no exceptions: what is thrown ends the instance, with its message.

void* __cxa_allocate_exception(std::size_t size) noexcept {
  return ::operator new(size);
}

[[noreturn]] void __cxa_throw(void* thrown, std::type_info* type, void (*)(void*)) {
  // Diverged, BadState and those of the standard library have a std::exception at their start.
  const std::string message = *type == typeid(Diverged) ? static_cast<Diverged*>(thrown)->what()
                                                        : std::string(type->name());
  fail(message.data(), message.size());
}
}

}  // namespace taut::page
