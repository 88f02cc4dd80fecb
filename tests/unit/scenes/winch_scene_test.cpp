// Winches in scene files: what they are read as, and what is said against them.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/interventions/interventions.h"
#include "sim/run/simulation.h"
#include "tests/unit/scenes/scene_texts.h"

namespace taut::winch_scene_test {
namespace {

const std::string kKeys = "[{ t = 0.0, paid_out = 0.0 }, { t = 1.0, paid_out = -0.5 }]";

std::string scene(const std::string& from, const std::string& to = "free = true",
                  const std::string& more = "", const std::string& method = "direct") {
  return "duration = 1.0\n[method]\nname = \"" + method +
         "\"\n[connectors.rope]\nlength = 1.0\nmass = 0.1\nparticles = 11\nfrom = { " + from +
         " }\nto = { " + to + " }\n" + more + "\n";
}
std::string held(const std::string& keys) {
  return "fixed = [0, 2, 0], winch = " + keys;
}

class WinchScene : public SceneTexts {};

TEST_F(WinchScene, PaysOutByKeys) {
  const scenes::Scene made = read(scene(held(kKeys)));
  const Winch& winch = *made.world.connectors[0].winch;
  EXPECT_EQ(winch.longer(0.5).length, -0.25);  // a smooth step is at its middle there
  EXPECT_EQ(winch.paid_out(1, 0.5).length, 0);
  EXPECT_DOUBLE_EQ(winch.share(0), winch.share(9));
}

// Between keys the speed is a cubic without acceleration at either: symmetric about the middle.
TEST_F(WinchScene, PaysOutBySpeeds) {
  const std::string keys =
      "[{ t = 0.1, speed = 0.0 }, { t = 0.5, speed = -0.6 }, { t = 0.6, speed = -0.6 }, "
      "{ t = 0.8, speed = 0.2 }]";
  const scenes::Scene made = read(scene(held(keys)));
  const Winch& winch = *made.world.connectors[0].winch;
  const auto expect_at = [&](double time, double length, double speed, double acceleration) {
    const PaidOut at = winch.paid_out(0, time);
    EXPECT_NEAR(at.length, length, 1e-15) << time;
    EXPECT_NEAR(at.rate, speed, 1e-14) << time;
    EXPECT_NEAR(at.acceleration, acceleration, 1e-13) << time;
  };
  expect_at(0.05, 0, 0, 0);
  // The smooth step 3 u^2 - 2 u^3 has the integral 3/32 up to its middle, and the slope 3/2 there.
  expect_at(0.3, -0.6 * 0.4 * 3 / 32, -0.3, -0.6 / 0.4 * 3 / 2);
  expect_at(0.5, -0.12, -0.6, 0);
  expect_at(0.55, -0.15, -0.6, 0);
  expect_at(0.6, -0.18, -0.6, 0);
  expect_at(0.8, -0.22, 0.2, 0);
  expect_at(1.0, -0.18, 0.2, 0);
  expect_at(1.5, -0.08, 0.2, 0);
  const double turns = 0.75;  // of the way from -0.6 to 0.2: 3 u^2 - 2 u^3 = 3/4, u = 0.673648
  const double share = 0.6736481776669303;
  const double paid = -0.6 * share + 0.8 * (std::pow(share, 3) - std::pow(share, 4) / 2);
  EXPECT_NEAR(3 * share * share - 2 * share * share * share, turns, 1e-15);
  EXPECT_NEAR(winch.least(), -0.18 + 0.2 * paid, 1e-12);
}

TEST_F(WinchScene, LinkAtAFreeBodyKeepsItsLength) {
  const std::string body =
      "[bodies.load]\nmass = 1.0\nshape = { sphere = { diameter = 0.1 } }\nhangs = [0, -1, 0]\n";
  const scenes::Scene made =
      read(scene(held(kKeys), "body = \"load\", point = [0, 0.05, 0]", body));
  Simulation simulation(made.world, make_method("direct", {}));
  simulation.advance_to(1);
  const Connector& rope = simulation.world().connectors[0];
  EXPECT_DOUBLE_EQ(rope.rest[9], 0.1);
  EXPECT_DOUBLE_EQ(rope.rest[0], 0.1 - 0.5 / 9);
  EXPECT_DOUBLE_EQ(rope.length, 0.5);
}

TEST_F(WinchScene, IsNeitherPinnedNorCut) {
  World world = read(scene(held(kKeys))).world;
  Interventions interventions;
  EXPECT_EQ(interventions.pin(world, 0, 0.5).outcome, Outcome::has_winch);
  EXPECT_EQ(interventions.cut(world, 0, 0.5).outcome, Outcome::has_winch);
  const std::string cut = "[[cuts]]\nt = 0.5\nconnector = \"rope\"\nat = 0.5\n";
  expect(scene(held(kKeys), "free = true", cut),
         "has a winch or passes a pulley, expected one that keeps");
}

// Beside an intervention elsewhere, what is shown of it are its own particles.
TEST_F(WinchScene, IsShownBesideATimeline) {
  const std::string other =
      "[connectors.other]\nlength = 1.0\nmass = 0.1\nparticles = 5\nfrom = { fixed = [1, 2, 0] }\n"
      "to = { free = true }\n[[cuts]]\nt = 0.5\nconnector = \"other\"\nat = 0.5\n";
  const scenes::Scene made = read(scene(held(kKeys), "free = true", other));
  Simulation simulation(made.world, make_method("direct", {}), made.timeline);
  simulation.advance_to(1);
  const Snapshot shown = simulation.state();
  EXPECT_EQ(shown.connectors[0], simulation.world().connectors[0].position);
  EXPECT_NEAR(shown.connectors[0].back().y(), 1.5, 1e-9);
}

TEST_F(WinchScene, SaysWhatIsWrong) {
  expect(scene("point_mass = 1.0, winch = " + kKeys, "fixed = [0, 2, 0]"),
         "needs an end that is fixed");
  expect(scene(held("[{ t = 0.0, paid_out = 0.1 }]")), "has 0.1 m of paid_out at the start");
  expect(scene(held("[{ t = 0.0, paid_out = 0.0 }, { t = 1.0, paid_out = -1.0 }]")),
         "takes in 1 m, of 0.99 m that it can");
  expect(scene(held("[{ t = 1.0, paid_out = 0.0 }, { t = 1.0, paid_out = 0.1 }]")),
         "a time after 1 s");
  expect(scene(held("[{ t = 0.0, speed = 0.2 }]")), "has 0.2 m/s of speed at the start");
  expect(scene(held("[{ t = 0.0, speed = 0.0 }, { t = 0.5, speed = -1.5 }]")),
         "takes in 1.125 m, of 0.99 m that it can");
  expect(scene(held("[{ t = 0.0, speed = 0.0 }, { t = 0.5, paid_out = 0.1 }]")),
         "winch[1].paid_out: stands beside keys of speed");
  expect(scene(held("[{ t = 0.0, paid_out = 0.0 }, { t = 0.5, speed = 0.1 }]")),
         "winch[1].speed: stands beside keys of paid_out");
  expect(scene(held("[{ t = 0.0, speed = 0.0, ease = true }]")), "only one of: ease, speed");
  expect(scene(held("[{ t = 0.0 }]")), "one of: paid_out, speed");
  EXPECT_EQ(said(scene(held(kKeys), "free = true", "links = \"pull\"", "truth")), "nothing");
  expect(scene(held(kKeys), "free = true", "look = \"chain\""), "look of a chain");
  expect(scene(held(kKeys), "free = true", "repeat = [{ count = 2, by = [1, 0, 0] }]"), "copies");
  expect(scene(held(kKeys), "free = true", "", "impulse"),
         "winch: the method impulse does not follow winches, expected one of: springs, xpbd, "
         "direct, truth");
  EXPECT_EQ(
      said(scene(held(kKeys), "free = true",
                 "[obstacles.floor]\nshape = { plane = {} }\nposition = [0, -1, 0]\n", "truth")),
      "nothing");
}

}  // namespace
}  // namespace taut::winch_scene_test
