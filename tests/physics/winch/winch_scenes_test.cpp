// Scenes with winches: a load that is let down without swing, a string that stands in the air.
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"
#include "tests/support/folder.h"

namespace taut::winch_test {
namespace {

std::string text_of(const std::string& scene) {
  std::ifstream file(std::string(TAUT_SOURCE_DIR) + "/scenes/topology/" + scene + ".toml");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

/// The most by which the load is aside of where it is to stand, from when it is there, m.
double swing(const std::string& text, double standing, double until) {
  const Folder folder;
  const scenes::Scene scene = scenes::load_scene(folder.write("crane.toml", text), false);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-5}}));
  double most = 0;
  for (double time = standing; time <= until; time += 1.0 / 60) {
    simulation.advance_to(time);
    most = std::max(most, std::abs(simulation.world().connectors[0].position.back().x() - 1.1));
  }
  return most;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what)) {
    text.replace(at, what.size(), by);
  }
  return text;
}

// A smooth step of fifth degree in 1.834 periods leaves a pendulum at rest; one in 2.03 does not.
TEST(Crane, LetsItsLoadDownWithoutSwing) {
  const std::string text = text_of("crane");
  EXPECT_LT(swing(text, 8.42, 11), 0.002);
  const std::string slower = replaced(replaced(text, "t = 6.12", "t = 6.5"), "t = 8.42", "t = 8.8");
  EXPECT_GT(swing(slower, 8.8, 11), 0.05);
}

/// The tackle's world at `time` (s).
World lifted(const std::string& text, double tolerance, double time) {
  const Folder folder;
  const scenes::Scene scene = scenes::load_scene(folder.write("tackle.toml", text), false);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", tolerance}}));
  simulation.advance_to(time);
  return simulation.world();
}
double bodies_apart(const World& a, const World& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    most = std::max(most, (a.bodies[i].position - b.bodies[i].position).norm());
  }
  return most;
}

// Twelve falls: the block rises by a twelfth of what the winch takes in, as nearly as falls are
// upright. A rope of a hundred-thousandth of the load is nearly one without mass.
TEST(Tackle, LiftsByATwelfth) {
  const std::string text = text_of("tackle");
  const std::string massless =
      replaced(replaced(text, "mass = 4.0", "mass = 0.0"), "particles = 4", "particles = 2");
  const World end = lifted(massless, 1e-6, 5);
  const double taken_in = -end.connectors.back().winch->paid_out(1, 5).length;
  EXPECT_GT(taken_in, 8.5);
  EXPECT_NEAR(end.bodies[6].position.y(), 1 + taken_in / 12, 0.01);
  EXPECT_NEAR(end.pulleys.back().passed, taken_in, 1e-12);
  EXPECT_LT(bodies_apart(lifted(massless, 1e-3, 5), end), 1e-3);
  const std::string light =
      replaced(replaced(text, "mass = 4.0", "mass = 0.01"), "particles = 4", "particles = 3");
  EXPECT_LT(bodies_apart(lifted(light, 1e-3, 0.5), lifted(massless, 1e-3, 0.5)), 1e-3);
}

/// How high the string is on an average above the wheels, m, from 3 s until 8 s.
double height(const std::string& text) {
  const Folder folder;
  const scenes::Scene scene = scenes::load_scene(folder.write("shooter.toml", text), false);
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-3}}));
  double sum = 0, count = 0;
  for (double time = 3; time < 8; time += 0.05) {
    simulation.advance_to(time);
    for (const Vec3& at : simulation.world().connectors[0].position) {
      sum += at.y() - 1.25;
      ++count;
    }
  }
  return sum / count;
}

// The air carries it: where that drags nothing along, the loop hangs, however fast it runs.
TEST(StringShooter, StandsInTheAir) {
  const std::string text = text_of("string_shooter");
  EXPECT_GT(height(text), 0.2);
  EXPECT_LT(height(replaced(text, "along = 0.06", "along = 0.0")), -0.1);
}

}  // namespace
}  // namespace taut::winch_test
