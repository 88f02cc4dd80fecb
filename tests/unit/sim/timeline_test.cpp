#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "sim/interventions/interventions.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "sim/topology/components.h"
#include "sim/world/places.h"

namespace taut::timeline_test {
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

TEST(Timeline, AFlawIsFoundWhereAnyTwoPinsDoNotFit) {
  // Neighbours alone are looked at: all pairs must say the same.
  std::mt19937 chance(1);
  const auto draw = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(chance);
  };
  const World world = hanging_rope();
  const auto fit = [&](double a, const Vec3& at, double b, const Vec3& there) {
    const auto [low, high] = std::minmax(a, b);
    double start = 0, longest = 0;  // m, of a piece of a link between the two
    for (const double rest : world.connectors[0].rest) {
      longest = std::max(longest, std::min(start + rest, high) - std::max(start, low));
      start += rest;
    }
    const double most = high - low, least = std::max(0.0, 2 * longest - most);
    const double apart = (at - there).norm();
    return most > 1e-9 && apart <= most + 1e-6 && apart >= least - 1e-6;
  };
  int flawless = 0;
  for (int round = 0; round < 2000; ++round) {
    Timeline timeline;
    for (int i = 0; i < 6; ++i) {
      const double along = 0.1 * std::floor(draw(1, 11)), from = draw(0, 6);
      const double aside = draw(0, 1) < 0.1 ? draw(-0.3, 0.3) : 0;
      timeline.pins.push_back(
          pin_at(along, from, from + draw(0.1, 2), Vec3(aside, std::abs(aside) - along, 0)));
    }
    bool fits = true;
    for (std::size_t i = 0; i < timeline.pins.size(); ++i) {
      const TimedPin& a = timeline.pins[i];
      fits &= fit(0, Vec3::Zero(), a.along, a.to->point);
      for (std::size_t j = 0; j < i; ++j) {
        const TimedPin& b = timeline.pins[j];
        if (!(a.from < b.until && b.from < a.until)) continue;
        fits &= fit(b.along, b.to->point, a.along, a.to->point);
      }
    }
    EXPECT_EQ(find_flaw(world, timeline).has_value(), !fits) << round;
    flawless += fits;
  }
  EXPECT_GT(flawless, 100);
  EXPECT_LT(flawless, 1900);
}

TEST(Timeline, AFoldBetweenPinsOfOneBodyIsFoundWhereverTheBodyIs) {
  World world = hanging_rope();
  Body body;
  body.mass_properties = solid_sphere(1, 0.5);
  body.position = Vec3(0, -1, 0);
  world.bodies = {body};
  finish(world);
  const auto on = [](double along, double from, const Vec3& point) {
    return TimedPin{0, along, from, INFINITY, Attachment{Attachment::Kind::body, point, nullptr, 0},
                    0};
  };
  EXPECT_FALSE(find_flaw(world, {{on(0.9, 1, Vec3(0, 0.1, 0)), on(1, 2, Vec3::Zero())}, {}}));
  const auto flaw = find_flaw(world, {{on(0.9, 1, Vec3(0, 0.2, 0)), on(1, 2, Vec3::Zero())}, {}});
  ASSERT_TRUE(flaw);
  EXPECT_EQ(flaw->index, 1u);
  EXPECT_EQ(flaw->what,
            "at 2 s it is 0.2 m from what holds the connector at 0.9 m, with 0.1 m of the "
            "connector between them, and one body holds both");
}

TEST(Timeline, APlaceThatIsHeldIsNotCut) {
  const Vec3 low(0, -0.5, 0);
  EXPECT_EQ(flaw({{pin_at(0.5, 1, 2, low)}, {{0, 0.5, 0.5}}}), "");
  EXPECT_EQ(flaw({{pin_at(0.5, 1, 2, low)}, {{0, 0.5, 2}}}), "");
  for (const double time : {1.0, 1.5}) {
    EXPECT_EQ(flaw({{pin_at(0.5, 1, 2, low)}, {{0, 0.3, 1}, {0, 0.5, time}}}),
              "cut 1: pins[0] holds the connector there from 1 s until 2 s, expected another place "
              "or time");
  }
}

TEST(Timeline, PartsAreFoundWhateverTheOrderOfTheCuts) {
  const World world = hanging_rope();
  std::vector<double> places;
  for (int i = 1; i < 40; ++i) places.push_back(0.025 * i);
  std::ranges::shuffle(places, std::mt19937(1));
  Parts parts(world.connectors);
  std::size_t made = 1;
  for (const double place : places) parts.cut(0, place, made++);
  for (int i = 0; i < 40; ++i) {
    const auto [connector, along] = parts.at(0, 0.025 * i + 0.0125);
    const auto is_it = [&](const Parts::Part& part) { return part.connector == connector; };
    const auto part = std::ranges::find_if(parts.all(), is_it);
    EXPECT_NEAR(part->start, 0.025 * i, 1e-12);
    EXPECT_NEAR(part->end, 0.025 * (i + 1), 1e-12);
    EXPECT_NEAR(along, 0.0125, 1e-12);
  }
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
  // A pin that the timeline does not foresee.
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
    // The rope hangs at rest until its parts fall, one after the other.
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

// Times of keys and frames are quotients and sums, which miss each other by roundings: no method
// may see a step of 5e-17 s.
TEST(Timeline, ARoundingOffAFrameIsThatFrame) {
  const auto moved = [](const MethodInfo& method, double off) {
    World swing = hanging_rope();
    for (Vec3& place : swing.connectors[0].position) place = Vec3(-place.y(), 0, 0);
    const double late = 1 + off * std::numeric_limits<double>::epsilon();
    // The last two are between frames, and a rounding apart.
    const Timeline timeline{
        {{0, 0.45, 0.3 * late, 0.5 / late, {}, 0}, {0, 0.7, 0.6 / late, 1, {}}},
        {{0, 0.8, 0.4 * late}, {0, 0.85, 0.45}, {0, 0.9, 0.45 * std::max(late, 1.0)}}};
    Simulation simulation(swing, make_method(method.name, {}), timeline);
    for (int frame = 1; frame <= 7; ++frame) simulation.advance_to(frame / 10.0);
    return std::pair(simulation.state().connectors, simulation.method().counters().steps);
  };
  for (const MethodInfo& method : all_methods()) {
    if (method.name == "sdfast") continue;  // follows no pinned chain
    const auto exact = moved(method, 0);
    for (const double off : {-3, -1, 1, 3}) {
      EXPECT_EQ(moved(method, off), exact) << method.name << ' ' << off;
    }
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
  // A body that is elsewhere by then.
  Body body;
  body.mass_properties = solid_sphere(1, 0.1);
  body.position = Vec3(0, -0.7, 0);
  world.bodies = {body};
  finish(world);
  TimedPin far = pin_at(0.5, 0, 1, Vec3::Zero());
  far.to->kind = Attachment::Kind::body;
  Simulation other(world, make_method("impulse", {}), {{far}, {}});
  try {
    other.advance_to(0.3);
    FAIL();
  } catch (const BadIntervention& bad) {
    EXPECT_STREQ(bad.what(),
                 "pin 1, at 0 s: it is 0.7 m from what holds the connector at 0 m, with 0.5 m of "
                 "the connector between them, expected a point of the body that is within reach");
  }
}

}  // namespace
}  // namespace taut::timeline_test
