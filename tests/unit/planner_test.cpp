#include "sim/study/planner.h"

#include <gtest/gtest.h>

#include "sim/study/marks.h"
#include "sim/study/run.h"

namespace taut {
namespace {

World swing(std::size_t particles) {
  World world;
  Connector rope = straight_connector("rope", 0.2, 0.05, particles, {0, 0, 0}, {1, 0, 0});
  rope.particle_mass.back() += 0.2;
  rope.holds.push_back({0, Attachment{}});
  world.connectors.push_back(std::move(rope));
  finish(world);
  return world;
}

TEST(Marks, LieBetweenTheParticlesOfACoarserChain) {
  const World fine = swing(5), coarse = swing(2);
  const Marks marks(fine, snapshot(fine)), own(coarse, snapshot(coarse));
  const std::vector<Vec3> places = own.places(marks, snapshot(coarse));
  ASSERT_EQ(places.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR((places[i] - fine.connectors[0].position[i]).norm(), 0, 1e-16) << i;
  }
}

TEST(Marks, OfAStickAreItsEnds) {
  World world;
  Body stick;
  stick.mass_properties = solid_cylinder(0.2, 0.3, 0.02);
  world.bodies.push_back(stick);
  finish(world);
  const Marks marks(world, snapshot(world));
  const std::vector<Vec3> places = marks.places(marks, snapshot(world));
  ASSERT_EQ(places.size(), 6u);
  double reach = 0;
  for (const Vec3& place : places) reach = std::max(reach, std::abs(place.y()));
  EXPECT_NEAR(reach, 0.15, 1e-12);  // the box of a cylinder's moments is as long as it is
}

class Planner : public testing::Test {
 protected:
  Planner() {
    const std::vector<double> times = frame_times(0.5, 60);
    truth_.frames = run({exact_, times}, {"truth", {}}, 100).frames;
    truth_.horizon = times.back();
    const std::vector<Candidate> candidates = {{"direct", {{"tolerance", 1e-2}}},
                                               {"direct", {{"tolerance", 1e-5}}},
                                               {"dynamic-constraints", {{"step", 1.0 / 1920}}},
                                               {"impulse", {{"step", 1.0 / 960}}}};
    for (const std::size_t particles : {21, 11, 2}) {
      models_.push_back({swing(particles), {}, candidates});
    }
  }
  Search within(double metres) {
    const Distance distance = [](const Vec3& at, const Vec3& truth, double) {
      return (at - truth).norm();
    };
    return search(models_, exact_, truth_, {distance, metres}, [](std::size_t) {});
  }

  const World exact_ = swing(21);
  Reference truth_;
  std::vector<PlanModel> models_;
};

/// What the search gave up early for being dear must be dear when it is run to its end.
TEST_F(Planner, FindsTheLeastWorkOfAllThatStayWithin) {
  for (const double metres : {1e-4, 1e-3, 3e-2}) {
    const Search found = within(metres);
    ASSERT_TRUE(found.best.has_value()) << metres;
    const Trial& best = found.trials[*found.best];
    EXPECT_LE(best.error, metres);
    ASSERT_EQ(found.trials.size(), 12u);
    for (std::size_t m = 0; m < models_.size(); ++m) {
      for (const Candidate& candidate : models_[m].candidates) {
        const std::vector<PlanModel> alone = {{models_[m].world, {}, {candidate}}};
        const Search one = search(
            alone, exact_, truth_,
            {[](const Vec3& at, const Vec3& truth, double) { return (at - truth).norm(); }, metres},
            [](std::size_t) {});
        if (!one.best) continue;
        EXPECT_GE(one.trials[0].work, best.work) << describe(candidate);
      }
    }
  }
}

TEST_F(Planner, TakesFewerParticlesWhereThatCannotBeSeen) {
  const Search fine = within(1e-4), coarse = within(3e-2);
  EXPECT_EQ(fine.trials[*fine.best].model, 0u) << "11 particles are a millimetre off";
  EXPECT_GT(coarse.trials[*coarse.best].model, 0u);
}

TEST_F(Planner, SaysWhereNothingIsNearEnough) {
  EXPECT_FALSE(within(1e-12).best.has_value());
}

TEST_F(Planner, MayBeStopped) {
  int tried = 0;
  EXPECT_THROW(
      search(models_, exact_, truth_, {[](const Vec3&, const Vec3&, double) { return 0.0; }, 1},
             [&](std::size_t) {
               if (++tried == 3) throw std::runtime_error("stop");
             }),
      std::runtime_error);
}

}  // namespace
}  // namespace taut
