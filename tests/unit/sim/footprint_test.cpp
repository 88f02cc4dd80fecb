// The estimated footprint of a simulation, against the kernel's account.
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <functional>

#include "sim/run/simulation.h"

namespace taut::footprint_test {
namespace {

World rope_of(std::size_t particles) {
  World world;
  Connector rope =
      straight_connector("rope", 1, 0.1, particles, Vec3::Zero(), Vec3(1, -1, 0).normalized());
  rope.holds = {{0, {}}};
  world.connectors = {rope};
  finish(world);
  return world;
}

/// By how much the peak of a process's memory rises (bytes) while it does that, in one of its own.
double taken_memory(const std::function<void()>& work) {
  malloc_trim(0);  // or the process would take what this one has freed
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) return -1;
  const pid_t child = fork();
  if (child == 0) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    work();
    getrusage(RUSAGE_SELF, &after);
    const double bytes = 1024.0 * double(after.ru_maxrss - before.ru_maxrss);
    _exit(write(pipe_ends[1], &bytes, sizeof bytes) == sizeof bytes ? 0 : 1);
  }
  double bytes = -1;
  if (read(pipe_ends[0], &bytes, sizeof bytes) != sizeof bytes) bytes = -1;
  close(pipe_ends[0]);
  close(pipe_ends[1]);
  waitpid(child, nullptr, 0);
  return bytes;
}

/// Bodies that hang from each other by single links.
World chain_of_bodies(std::size_t count) {
  World world;
  Attachment above;
  for (std::size_t i = 0; i < count; ++i) {
    Body body;
    body.mass_properties = solid_sphere(1, 0.1);
    const double top = -1.1 * double(i);
    body.position = Vec3(0, top - 1.05, 0);
    world.bodies.push_back(body);
    Connector link = straight_connector("link", 1, 0, 2, Vec3(0, top, 0), Vec3(0, -1, 0));
    link.holds = {{0, above}, {1, {Attachment::Kind::body, Vec3(0, 0.05, 0), nullptr, i}}};
    world.connectors.push_back(link);
    above = {Attachment::Kind::body, Vec3(0, -0.05, 0), nullptr, i};
  }
  finish(world);
  return world;
}

class Footprint : public testing::Test {
 protected:
  void SetUp() override {
#ifdef TAUT_SANITIZED
    GTEST_SKIP() << "a sanitizer's allocator takes more";
#endif
  }
};

void expect_within(const MethodInfo& method, const Settings& settings, const World& world) {
  const Settings full = with_defaults(method, settings);
  const auto taken_by = [&](const World& start) {
    return taken_memory([&] {
      Simulation simulation(start, make_method(method.name, full));
      simulation.advance_to(1e-4);
      simulation.state();
    });
  };
  const double said = memory_of(method, world, full);
  // The pages of the code itself are no part of it.
  const double taken = taken_by(world) - taken_by(rope_of(2));
  EXPECT_LE(taken, said) << method.name;
  // The world alone is a part of it that no method can do without.
  EXPECT_GE(taken, said / 8) << method.name;
}

TEST_F(Footprint, IsWhatAMethodTakes) {
  for (const MethodInfo& method : all_methods()) {
    // SD/FAST's models are made for a number of particles beforehand.
    if (!method.missing.empty() || method.name == "sdfast") continue;
    expect_within(method, {}, rope_of(4000));
  }
}

// Each leaves a part to the method; that of one after another grew with the square of their number.
TEST_F(Footprint, LastingPinsOneAfterAnotherTakeLittleMore) {
  const MethodInfo& method = *find_method("direct");
  World world = rope_of(2001);
  Connector& rope = world.connectors[0];
  rope.position = hanging_points(rope, Vec3::Zero(), Vec3(0.5, -0.5, 0), world.gravity);
  finish(world);
  const double taken = taken_memory([&] {
    Simulation simulation(world, make_method(method.name, {}));
    for (int i = 1; i <= 800; ++i) {
      simulation.advance_to(1e-6 * i);
      simulation.interventions().pin(simulation.world(), 0, 1 - 0.0011 * i);
    }
    simulation.advance_to(1e-3);
  });
  constexpr double kPart = 3e4;  // bytes
  EXPECT_LE(taken, memory_of(method, world, with_defaults(method, {})) + 800 * kPart);
}

TEST_F(Footprint, GrowsWithTheSquareOfBodiesThatHangFromEachOther) {
  for (const char* method : {"dynamic-constraints", "truth"}) {
    expect_within(*find_method(method), {}, chain_of_bodies(500));
  }
}

TEST_F(Footprint, OfAWholeMatrixGrowsWithItsSquare) {
  const MethodInfo& method = *find_method("dynamic-constraints");
  expect_within(method, {{"solver", std::string("dense")}}, rope_of(1000));
  const Settings dense = with_defaults(method, {{"solver", std::string("dense")}});
  EXPECT_GT(memory_of(method, rope_of(100'000), dense), 1.7e11);
}

}  // namespace
}  // namespace taut::footprint_test
