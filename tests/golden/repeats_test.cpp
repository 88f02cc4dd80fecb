// The start of every golden motion has the same bits when it runs again: in another order, from a
// new simulation, and while others run on other threads.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <thread>

#include "scenes/load/golden_suite.h"
#include "scenes/load/load_scene.h"
#include "sim/motion/hash.h"
#include "sim/run/simulation.h"

namespace taut::repeats_test {
namespace {

constexpr double kUntil = 0.3;  // s

struct Motion {
  scenes::GoldenTrajectory kept;
  scenes::Scene scene;
};

/// The hash of the whole dynamic state at every frame.
std::uint64_t motion_hash(const Motion& motion) {
  const auto& [trajectory, scene] = motion;
  Simulation simulation = scenes::start(scene, trajectory.method);
  Hash hash;
  const int last = std::min(trajectory.last, static_cast<int>(kUntil * scene.fps));
  for (int k = 1; k <= last; ++k) {
    simulation.advance_to(double(k) / scene.fps);
    hash.number(state_hash(simulation.world()));
  }
  return hash.value();
}

TEST(GoldenMotions, HaveTheSameBitsAgain) {
  const std::vector<scenes::GoldenTrajectory> all =
      scenes::load_golden_suite(std::filesystem::path(TAUT_SOURCE_DIR) / "tests/golden/motions")
          .trajectories;
  std::vector<Motion> motions;
  for (const scenes::GoldenTrajectory& kept : all)
    if (!find_method(kept.method.name)->runs_alone)
      motions.push_back({kept, scenes::load_scene(kept.scene, false)});
  ASSERT_FALSE(motions.empty());
  std::vector<std::uint64_t> once, again(motions.size());
  for (const Motion& motion : motions) once.push_back(motion_hash(motion));

  // In the reverse order, on four threads.
  std::atomic<std::size_t> taken{0};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([&] {
      for (std::size_t k; (k = taken++) < motions.size();) {
        const std::size_t from_behind = motions.size() - 1 - k;
        again[from_behind] = motion_hash(motions[from_behind]);
      }
    });
  threads.clear();
  for (std::size_t i = 0; i < motions.size(); ++i)
    EXPECT_EQ(once[i], again[i]) << motions[i].kept.name;
}

}  // namespace
}  // namespace taut::repeats_test
