#include "sim/timeline.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/measure.h"
#include "sim/simulation.h"

namespace taut {
namespace {

Attachment fixed(const Vec3& point) {
  return {Attachment::Kind::fixed, point, nullptr, 0};
}

World hanging_rope() {
  World world;
  Connector rope = straight_connector("rope", 1, 0.2, 11, Vec3::Zero(), Vec3(0, -1, 0));
  rope.holds = {{0, fixed(Vec3::Zero())}};
  world.connectors = {rope};
  finish(world);
  return world;
}

TimedPin pin_at(double along, double from, double until, const Vec3& point) {
  return {0, along, from, until, fixed(point), 0};
}

std::string flaw(const Timeline& timeline) {
  const std::optional<Flaw> found = find_flaw(hanging_rope(), timeline);
  return found ? (found->cut ? "cut " : "pin ") + std::to_string(found->index) + ": " + found->what
               : "";
}

TEST(Timeline, FlawsAreFoundBeforehand) {
  const Vec3 low(0, -0.5, 0);
  EXPECT_EQ(flaw({{pin_at(0.5, 1, 2, low)}, {{0, 0.3, 1}}}), "");
  EXPECT_EQ(flaw({{pin_at(1.5, 1, 2, low)}, {}}),
            "pin 0: its place at 1.5 m is not on the connector, which is 1 m long");
  EXPECT_EQ(flaw({{pin_at(0.5, -1, 2, low)}, {}}),
            "pin 0: it begins at -1 s, before the scene, which begins at 0 s");
  EXPECT_EQ(flaw({{pin_at(0.5, 1, 1, low)}, {}}),
            "pin 0: it ends at 1 s, expected later than it begins, at 1 s");
  EXPECT_EQ(flaw({{pin_at(0, 1, 2, Vec3::Zero())}, {}}),
            "pin 0: the connector is held there already");
  EXPECT_EQ(flaw({{pin_at(0.5, 1, 2, Vec3(0, -0.6, 0))}, {}}),
            "pin 0: at 1 s it is 0.6 m from what holds the connector at 0 m, with 0.5 m of the "
            "connector between them");
  EXPECT_EQ(flaw({{pin_at(0.5, 1, 3, low), pin_at(0.5, 2, 4, low)}, {}}),
            "pin 1: the connector is held there already, by another pin at that time");
  EXPECT_EQ(flaw({{pin_at(0.5, 1, 3, low), pin_at(0.5, 3, 4, low)}, {}}), "");
  EXPECT_EQ(flaw({{{3, 0.5, 1, 2, {}, 0}}, {}}), "pin 0: there is no such connector");
  EXPECT_EQ(flaw({{{0, 0.5, 1, 2, Attachment{Attachment::Kind::body, low, nullptr, 0}, 0}}, {}}),
            "pin 0: what should hold it does not exist");
  EXPECT_EQ(flaw({{}, {{0, 1.3, 1}}}),
            "cut 0: its place at 1.3 m is not on the connector, which is 1 m long");
}

TEST(Timeline, PinsThatMoveApartAreFoundWhereTheyDo) {
  TimedPin still = pin_at(0.4, 1, 9, Vec3(0, -0.4, 0));
  TimedPin moving = pin_at(0.6, 2, 9, Vec3::Zero());
  moving.to->kind = Attachment::Kind::path;
  moving.to->path = std::make_shared<const Path>(
      std::vector<PathKey>{{2, Vec3(0, -0.5, 0)}, {4, Vec3(0.3, -0.4, 0)}});
  const std::string what = flaw({{still, moving}, {}});
  // A part s of the way they are apart by |(0.3 s, 0.1 s - 0.1)|: 0.2 m at s = 0.657, which the
  // quintic has after 0.585 of its 2 s.
  EXPECT_EQ(what.find("pin 1: at 3.17"), 0u) << what;
  EXPECT_NE(what.find("from what holds the connector at 0.4 m, with 0.2 m"), std::string::npos);
}

TEST(Timeline, ThingsHappenAtTheirTimes) {
  World world = hanging_rope();
  Timeline timeline{{{0, 0.45, 0.1, 0.3, {}, 0}}, {{0, 0.7, 0.25}}};
  Simulation simulation(world, make_method("impulse", {}), timeline);
  simulation.advance_to(0.0999);
  EXPECT_EQ(simulation.world().connectors[0].particles(), 11u);
  simulation.advance_to(0.1);
  EXPECT_EQ(simulation.world().connectors[0].particles(), 12u);
  simulation.advance_to(0.3);
  EXPECT_EQ(simulation.world().connectors.size(), 2u);
  EXPECT_EQ(simulation.world().connectors[0].holds.size(), 1u);
  // The lower part has fallen since the cut.
  simulation.advance_to(0.45);
  EXPECT_NEAR(simulation.world().connectors[1].position.front().y(), -0.7 - 9.81 * 0.04 / 2, 1e-3);
  // What nobody foresaw.
  EXPECT_EQ(simulation.interventions().pin(simulation.world(), 1, 0.1).outcome, Outcome::done);
  simulation.advance_to(0.6);
  EXPECT_EQ(simulation.world().connectors[1].holds.size(), 1u);
}

TEST(Timeline, StatesKeepTheirParticlesWhateverIsPinnedAndCut) {
  const World rope = hanging_rope();
  // Cut at a particle and between two, pinned between two; the later cut is of what the first left.
  const Timeline timeline{{{0, 0.45, 0.1, 0.3, {}, 0}}, {{0, 0.7, 0.25}, {0, 0.85, 0.2}}};
  const World parts = divided(rope, timeline);
  ASSERT_EQ(parts.connectors.size(), 3u);
  Simulation simulation(rope, make_method("truth", {}), timeline);
  for (const double time : {0.0, 0.15, 0.22, 0.26, 0.35}) {
    simulation.advance_to(time);
    const Snapshot state = simulation.state();
    ASSERT_EQ(state.connectors.size(), 3u);
    for (std::size_t c = 0; c < 3; ++c) {
      ASSERT_EQ(state.connectors[c].size(), parts.connectors[c].particles()) << time;
    }
    // It hangs at rest until its parts fall, one after the other.
    const auto fallen = [&](double since) {
      return time > since ? 9.81 * (time - since) * (time - since) / 2 : 0;
    };
    const double top = state.connectors[0][7].y(), middle = state.connectors[2][0].y(),
                 low = state.connectors[1][0].y();
    EXPECT_NEAR(top, -0.7, 1e-9) << time;
    EXPECT_NEAR(middle, -0.7 - fallen(0.25), 1e-9) << time;
    EXPECT_NEAR(low, -0.85 - fallen(0.2), 1e-9) << time;
    EXPECT_NEAR(state.connectors[0][3].y(), -0.3, 1e-9);
  }
}

TEST(Timeline, WhatCannotBeWhenItsTimeComesIsNamed) {
  World world = hanging_rope();
  Timeline timeline{{pin_at(0.5, 0.2, 1, Vec3(0, -0.5, 0))}, {}};
  Simulation simulation(world, make_method("impulse", {}), timeline);
  simulation.advance_to(0.1);
  ASSERT_EQ(simulation.interventions().pin(simulation.world(), 0, 0.5).outcome, Outcome::done);
  try {
    simulation.advance_to(0.3);
    FAIL();
  } catch (const BadIntervention& bad) {
    EXPECT_FALSE(bad.flaw.cut);
    EXPECT_EQ(bad.flaw.index, 0u);
    EXPECT_EQ(bad.time, 0.2);
    EXPECT_STREQ(bad.what(), "pin 1, at 0.2 s: the connector is held there already");
  }
}

}  // namespace
}  // namespace taut
