// Ten thousand ropes of 16 particles swing for a second, in steps of a millisecond, on all cores.
#include <taut/sim/batch/batch.h>
#include <taut/sim/measure/measure.h>

#include <chrono>
#include <cstdio>
#include <thread>

int main() {
  using namespace taut;
  constexpr int kRopes = 10000;
  World world;
  for (int i = 0; i < kRopes; ++i) {
    const Vec3 from(0.01 * (i % 100), 2, 0.01 * (i / 100));
    const Vec3 along(1, -1e-4 * i, 0.5);  // each falls a little later than the one before
    Connector rope = straight_connector("rope", 0.5, 0.05, 16, from, along.normalized());
    rope.holds = {{.particle = 0, .to = {.point = from}}};
    world.connectors.push_back(rope);
  }

  batch::Batch<float> batch(world, 1e-3);
  const auto start = std::chrono::steady_clock::now();
  batch.advance(1.0, static_cast<int>(std::thread::hardware_concurrency()));
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  batch.store(world);
  std::printf("%d ropes, %.1f s: %.2f s, largest stretch %.1e\n", kRopes, batch.time(),
              taken.count(), stretch_max(world));
}
