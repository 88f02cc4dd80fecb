// Stepping and interventions do not allocate after the start: every operator new of this program is
// counted.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <new>

#include "sim/motion/rotation.h"
#include "sim/run/error_estimate.h"

namespace {
thread_local std::size_t allocations = 0;
}

// Not inline: GCC would take free() for the wrong counterpart of new.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size > 0 ? size : 1);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto line = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(line, (size + line - 1) / line * line)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace taut::allocation_test {
namespace {

World stick_on_a_rope() {
  World world;
  Connector rope = straight_connector("rope", 1, 0.2, 21, Vec3::Zero(), Vec3(1, -1, 0));
  rope.restitution = 0.5;
  Body stick;
  stick.mass_properties = solid_cylinder(0.3, 0.4, 0.03);
  rope.position.back() = Vec3(0.3, -0.3, 0);  // slack at first
  stick.position = rope.position.back() - Vec3(0, 0.2, 0);
  world.bodies = {stick};
  rope.holds = {{0, {}}, {20, {Attachment::Kind::body, Vec3(0, 0.2, 0), nullptr, 0}}};
  world.connectors = {rope};
  finish(world);
  return world;
}

TEST(Allocations, TheCounterCounts) {
  const std::size_t before = allocations;
  const auto number = std::make_unique<int>(3);
  EXPECT_EQ(allocations - before, 1u) << *number;
}

TEST(Allocations, SteppingDoesNotAllocateAfterTheFirstCall) {
  World world = stick_on_a_rope();
  const auto method = make_method("impulse", {});
  method->advance(world, 0.001);
  const std::size_t before = allocations;
  method->advance(world, 2.0);
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_FALSE(method->events().empty());
}

/// Every method but those that other libraries make anew: what they allocate is not ours to keep.
std::vector<std::string_view> own_methods() {
  std::vector<std::string_view> names;
  for (const MethodInfo& method : all_methods()) {
    if (method.name != "multibody" && method.name != "sdfast") names.push_back(method.name);
  }
  return names;
}

/// A rope in a spiral, nowhere straight between two places, with a stick in line at its end.
World spiral() {
  World world = stick_on_a_rope();
  Connector& rope = world.connectors[0];
  Vec3 along;
  for (std::size_t k = 0; k < rope.links(); ++k) {
    const double turn = 0.1 * static_cast<double>(k);
    along = Vec3(std::sin(turn), -1, 1 - std::cos(turn)).normalized();
    rope.position[k + 1] = rope.position[k] + rope.rest[k] * along;
  }
  Body& stick = world.bodies[0];
  stick.rotation = rotation_between(-Vec3::UnitY(), along);
  stick.position = rope.position.back() + 0.2 * along;
  return world;
}

/// Weights that swing on massless spans, a stick that hangs on one, and a rope of links.
World weights_on_spans() {
  World world;
  for (int k = 0; k < 4; ++k) {
    const Vec3 place(k, 0, 0), along = Vec3(0.3, -1, 0.1 * k).normalized();
    Connector cord = straight_connector("cord", 1, 0, 6, place, along);
    cord.model = ConnectorModel::span;
    cord.particle_mass.back() = 0.2;
    cord.holds = {{0, {Attachment::Kind::fixed, place, nullptr, 0}}};
    world.connectors.push_back(cord);
  }
  Body stick;
  stick.mass_properties = solid_cylinder(0.3, 0.4, 0.03);
  stick.position = world.connectors[0].position.back() - Vec3(0, 0.2, 0);
  world.bodies = {stick};
  world.connectors[0].particle_mass.back() = 0;
  world.connectors[0].holds.push_back({5, {Attachment::Kind::body, Vec3(0, 0.2, 0), nullptr, 0}});
  Connector rope = straight_connector("rope", 1, 0.2, 11, -Vec3::UnitX(), Vec3(1, -1, 0.2));
  rope.holds = {{0, {Attachment::Kind::fixed, -Vec3::UnitX(), nullptr, 0}}};
  world.connectors.push_back(rope);
  finish(world);
  return world;
}

TEST(Allocations, DirectDoesNotAllocateWhileSpansStayTaut) {
  World world = weights_on_spans();
  const auto method = make_method("direct", {});
  method->advance(world, 0.02);
  const std::size_t before = allocations;
  for (int k = 2; k <= 25; ++k) method->advance(world, 0.02 * k);
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_TRUE(method->events().empty());
}

TEST(Allocations, DirectDoesNotAllocateWhileSpansAreSlack) {
  World world = weights_on_spans();
  for (std::size_t k = 1; k < 4; ++k) world.connectors[k].position.back() += Vec3(0, 0.3, 0);
  const auto method = make_method("direct", {});
  method->advance(world, 0.01);
  const std::size_t before = allocations;
  for (int k = 2; k <= 10; ++k) method->advance(world, 0.01 * k);
  EXPECT_EQ(allocations - before, 0u);
  for (std::size_t k = 1; k < 4; ++k) {
    const Connector& cord = world.connectors[k];
    EXPECT_LT((cord.position.back() - cord.position.front()).norm(), 0.9) << "slack to the end";
  }
}

TEST(Allocations, SteppingMaterialsDoesNotAllocateAfterTheFirstCall) {
  World start;
  Connector rope = straight_connector("rope", 1, 0.2, 21, Vec3::Zero(), Vec3(1, -1, 0));
  Section section;
  section.axial_stiffness = 300;
  section.axial_damping = 0.1;
  section.bending_stiffness = 0.01;
  section.bending_damping = 1e-4;
  section.diameter = 0.01;
  rope.sections.assign(rope.links(), section);
  rope.drag = {1.2, 0.1};
  Hold hold;
  hold.clamp = Vec3(1, -1, 0);
  rope.holds = {hold};
  start.air = {1.2, Vec3(1, 0, 0)};
  start.connectors = {rope};
  finish(start);
  for (const MethodInfo& method : all_methods()) {
    if (!method.abilities.follows.has(Feature::bending) || method.reference) continue;
    World world = start;
    const auto stepper = make_method(method.name, {});
    stepper->advance(world, 0.05);
    const std::size_t before = allocations;
    stepper->advance(world, 0.3);
    EXPECT_EQ(allocations, before) << method.name;
  }
}

TEST(Allocations, SteppingJoinedConnectorsDoesNotAllocateAfterTheFirstCall) {
  World start;
  Connector trunk = straight_connector("trunk", 1, 0.2, 11, Vec3::Zero(), Vec3(1, -1, 0));
  trunk.holds = {{}};
  const Connector branch =
      straight_connector("branch", 0.5, 0.1, 6, trunk.position[4], Vec3(1, 0, 1));
  start.connectors = {trunk, branch};
  start.joints = {{{{0, 4}, {1, 0}}}};
  finish(start);
  for (const MethodInfo& method : all_methods()) {
    if (!method.abilities.follows.has(Feature::joint) || method.reference) continue;
    World world = start;
    const auto stepper = make_method(method.name, {});
    stepper->advance(world, 0.05);
    const std::size_t before = allocations;
    stepper->advance(world, 0.3);
    EXPECT_EQ(allocations, before) << method.name;
  }
}

/// A rope with a stick at its end that fall on a floor, and a stick that falls on that.
World sticks_on_a_floor() {
  World world = stick_on_a_rope();
  world.connectors[0].holds.erase(world.connectors[0].holds.begin());
  world.connectors[0].radius = 0.01;
  Body above = world.bodies[0];
  above.mass_properties = above.bare;
  above.position += Vec3(0.02, 0.3, 0);
  world.bodies.push_back(above);
  for (Body& body : world.bodies) {
    body.capsule = {0.015, Vec3(0, -0.18, 0), Vec3(0, 0.18, 0)};
  }
  world.pairs = {{0, 1, 0.3, 0.3, 0.5}};
  Obstacle floor;
  floor.place.position.y() = -1.2;
  world.obstacles = {floor};
  refresh(world);
  return world;
}

TEST(Allocations, SteppingContactDoesNotAllocateAfterTheFirstCall) {
  for (const std::string_view name : {"xpbd", "springs"}) {
    World world = sticks_on_a_floor();
    const auto method = make_method(name, {});
    method->advance(world, 1.0 / 240);
    const std::size_t before = allocations;
    for (int k = 2; k <= 240; ++k) method->advance(world, k / 240.0);
    EXPECT_EQ(allocations - before, 0u) << name;
    EXPECT_LT(world.bodies[0].position.y(), -0.8) << name;  // it lies there
  }
}

TEST(Allocations, DirectDoesNotAllocateAtCoarseTolerances) {
  for (const double tolerance : {0.01, 0.03, 0.06, 0.1, 0.3}) {
    World world = spiral();
    const auto method = make_method("direct", {{"tolerance", tolerance}});
    method->advance(world, 1.0 / 240);
    const std::size_t before = allocations;
    for (int k = 2; k <= 240; ++k) method->advance(world, k / 240.0);
    EXPECT_EQ(allocations - before, 0u) << tolerance;
  }
}

class Allocation : public testing::TestWithParam<std::string_view> {};

TEST_P(Allocation, NoInterventionAllocates) {
  Simulation simulation(spiral(), make_method(GetParam(), {}));
  World& world = simulation.world();
  Interventions& interventions = simulation.interventions();
  interventions.reserve(world, 2, 1);
  simulation.advance_to(0.01);
  const std::size_t before = allocations;
  for (int i = 1; i <= 5; ++i) {
    const Pinned a = interventions.pin(world, 0, 0.33), b = interventions.pin(world, 0, 0.5);
    EXPECT_EQ(b.outcome, Outcome::done);
    simulation.advance_to(i * 0.02);
    Attachment to;
    to.point = material_point(world.connectors[0], 0.33).position;
    EXPECT_EQ(interventions.move(world, a.pin, to, 0.02), Outcome::done);
    EXPECT_EQ(allocations - before, 0u) << i;
    simulation.advance_to(i * 0.02 + 0.005);
    EXPECT_EQ(interventions.release(world, a.pin), Outcome::done);
    EXPECT_EQ(interventions.release(world, b.pin), Outcome::done);
    simulation.advance_to(i * 0.02 + 0.01);
    EXPECT_EQ(allocations - before, 0u) << i;
  }
  EXPECT_EQ(interventions.cut(world, 0, 0.53).outcome, Outcome::done);
  EXPECT_EQ(allocations - before, 0u);
  simulation.advance_to(0.12);
  EXPECT_EQ(interventions.pin(world, 1, 0.2).outcome, Outcome::done);
  simulation.advance_to(0.13);
  EXPECT_EQ(allocations - before, 0u);
}

TEST_P(Allocation, NoEstimateAllocates) {
  Timeline timeline;
  TimedPin pin;
  pin.along = 0.33;
  pin.from = 0.1;
  pin.until = 0.15;
  timeline.pins = {pin};
  timeline.cuts = {{.along = 0.52, .time = 0.2}};
  Simulation simulation(spiral(), make_method(GetParam(), {}), timeline);
  ErrorEstimate estimate(spiral(), GetParam(), {}, timeline);
  simulation.advance_to(0.01);
  estimate.follow(simulation);
  // The run beside it may meet a change of the scene a frame later than the other.
  std::size_t stepping = 0, estimating = 0;
  for (int k = 2; k <= 30; ++k) {
    const std::size_t at_first = allocations;
    simulation.advance_to(0.01 * k);
    const std::size_t stepped = allocations;
    estimate.follow(simulation);
    stepping += stepped - at_first;
    estimating += allocations - stepped;
  }
  EXPECT_LE(estimating, stepping);
}

INSTANTIATE_TEST_SUITE_P(OwnMethods, Allocation, testing::ValuesIn(own_methods()),
                         [](const auto& row) {
                           std::string name(row.param);
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace taut::allocation_test
