// A drum that turns winds a rope up.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"
#include "tests/support/folder.h"

namespace taut::contact_test {
namespace {

constexpr double kRadius = 0.132, kAngle = 9.4;  // m, rad: of the rope's middle; of the drum

/// By how much the bucket of the windlass has risen once it hangs still again, m.
double rise(const std::string& particles) {
  std::ifstream file(TAUT_SOURCE_DIR "/scenes/contact/windlass.toml");
  std::stringstream stream;
  stream << file.rdbuf();
  std::string text = stream.str();
  const std::string count = "particles = 63";
  text.replace(text.find(count), count.size(), "particles = " + particles);
  const Folder folder;
  const scenes::Scene scene = scenes::load_scene(folder.write("windlass.toml", text), false);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-3}}));
  const auto height = [&] { return simulation.world().connectors[0].position.back().y(); };
  const double before = height();
  simulation.advance_to(5.2);
  // Beads that slide to and fro on the smooth drum end no steps: that took forty thousand.
  EXPECT_LT(simulation.method().counters().steps, 8000u) << particles;
  return height() - before;
}

// The rope lies as a polygon, whose corners are on the circle: it is longer than its chords by
// (l/R)^2/24 of them.
TEST(LongWindlass, LiftsItsLoadByWhatTheDrumWinds) {
  for (const auto& [particles, links] : {std::pair("32", 31.0), std::pair("63", 62.0)}) {
    const double link = 1.45 / links, chord = link / kRadius;
    EXPECT_NEAR(rise(particles), kRadius * kAngle * (1 - chord * chord / 24), 1e-3) << particles;
  }
}

}  // namespace
}  // namespace taut::contact_test
