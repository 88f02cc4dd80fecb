// Stepping and interventions do not allocate after the start: every operator new of this program is
// counted.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "sim/simulation.h"

namespace {
thread_local std::size_t allocations = 0;
}

// Not inline: GCC would take free() for the wrong counterpart of new.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace taut {
namespace {

World stick_on_a_rope() {
  World world;
  Connector rope = straight_connector("rope", 1, 0.2, 21, Vec3::Zero(), Vec3(1, -1, 0));
  rope.elasticity = 0.5;
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

TEST(Allocation, TheCounterCounts) {
  const std::size_t before = allocations;
  const auto number = std::make_unique<int>(3);
  EXPECT_EQ(allocations - before, 1u) << *number;
}

TEST(Allocation, SteppingDoesNotAllocateAfterTheFirstCall) {
  World world = stick_on_a_rope();
  const auto method = make_method("impulse", {});
  method->advance(world, 0.001);
  const std::size_t before = allocations;
  method->advance(world, 2.0);
  EXPECT_EQ(allocations - before, 0u);
  EXPECT_FALSE(method->events().empty());
}

TEST(Allocation, NeitherDoInterventions) {
  Simulation simulation(stick_on_a_rope(), make_method("impulse", {}));
  World& world = simulation.world();
  Interventions& interventions = simulation.interventions();
  interventions.reserve(world, 4, 0);
  const auto storm = [&](double from) {
    for (int i = 1; i <= 20; ++i) {
      const Pinned a = interventions.pin(world, 0, 0.33), b = interventions.pin(world, 0, 0.5);
      simulation.advance_to(from + i * 0.02 - 0.01);
      Attachment to;
      to.point = material_point(world.connectors[0], 0.33).position;
      EXPECT_EQ(interventions.move(world, a.pin, to, 0.02), Outcome::done);
      interventions.release(world, a.pin);
      interventions.release(world, b.pin);
      simulation.advance_to(from + i * 0.02);
    }
  };
  storm(0);
  const std::size_t before = allocations;
  storm(0.4);
  EXPECT_EQ(allocations - before, 0u);
}

}  // namespace
}  // namespace taut
