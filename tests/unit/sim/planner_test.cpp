#include "sim/study/planner.h"

#include <gtest/gtest.h>

#include <cmath>

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/run/simulation.h"
#include "sim/world/winched.h"

namespace taut::planner_test {
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

TEST(SamplePoints, LieBetweenTheParticlesOfACoarserChain) {
  const World fine = swing(5), coarse = swing(2);
  const study::SamplePoints sample_points(fine, snapshot(fine)), own(coarse, snapshot(coarse));
  const std::vector<Vec3> places = own.places(sample_points, snapshot(coarse));
  ASSERT_EQ(places.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR((places[i] - fine.connectors[0].position[i]).norm(), 0, 1e-16) << i;
  }
}

/// A rope that a winch takes in by half, straight down to a ball, whose link keeps its length.
World half_taken_in(std::size_t particles) {
  World world;
  Body ball;
  ball.mass_properties = solid_cylinder(1, 0.1, 0.1);
  ball.position = {0, -1.05, 0};
  world.bodies.push_back(ball);
  Connector rope = straight_connector("rope", 1, 0.05, particles, {0, 0, 0}, {0, -1, 0});
  Hold load;
  load.particle = particles - 1;
  load.to.kind = Attachment::Kind::body;
  load.to.point = {0, 0.05, 0};
  rope.holds = {{0, Attachment{}}, load};
  world.connectors.push_back(std::move(rope));
  add_winches(world, world.connectors[0],
              std::make_shared<const Path>(std::vector<PathKey>{{0, {0, 0, 0}}, {1, {-0.5, 0, 0}}}),
              nullptr);
  finish(world);
  return world;
}

// However much of the length a coarser rope's links share, points are where they were along it.
TEST(SamplePoints, KeepTheirShareOfALengthThatChanges) {
  const World fine = half_taken_in(11), coarse = half_taken_in(4);
  const study::SamplePoints sample_points(fine, snapshot(fine)), own(coarse, snapshot(coarse));
  Simulation exact(fine, make_method("direct", {})), run(coarse, make_method("direct", {}));
  exact.advance_to(1);
  run.advance_to(1);
  const std::vector<Vec3> places = own.places(sample_points, run.state());
  const std::vector<Vec3> right = sample_points.places(sample_points, exact.state());
  EXPECT_NEAR(right[10].y(), -0.5, 1e-9);
  EXPECT_NEAR(right[9].y(), -0.4, 1e-9);
  for (std::size_t i = 0; i < 11; ++i) EXPECT_LT((places[i] - right[i]).norm(), 1e-9) << i;
}

TEST(SamplePoints, OfAStickAreItsEnds) {
  World world;
  Body stick;
  stick.mass_properties = solid_cylinder(0.2, 0.3, 0.02);
  world.bodies.push_back(stick);
  finish(world);
  const study::SamplePoints sample_points(world, snapshot(world));
  const std::vector<Vec3> places = sample_points.places(sample_points, snapshot(world));
  ASSERT_EQ(places.size(), 6u);
  double extent = 0;
  for (const Vec3& place : places) extent = std::max(extent, std::abs(place.y()));
  EXPECT_NEAR(extent, 0.15, 1e-12);  // the box of a cylinder's moments is as long as it is
}

double metres(const Vec3& at, const Vec3& truth, double) {
  return (at - truth).norm();
}

void no_tick(double) {}

TEST(Distributions, DifferByTheLargestShare) {
  const std::vector<double> a{1, 2, 3, 4}, b{1.1, 2.1, 5, 6};
  EXPECT_DOUBLE_EQ(study::distribution_distance(a, a, 0), 0);
  EXPECT_DOUBLE_EQ(study::distribution_distance(a, b, 0),
                   0.5);  // below 4.5: all of one, half of the other
  EXPECT_DOUBLE_EQ(study::distribution_distance(b, a, 0), 0.5);
  EXPECT_DOUBLE_EQ(study::distribution_distance(a, b, 1.5), 0.25);
  EXPECT_DOUBLE_EQ(study::distribution_distance(a, b, 2), 0);
}

TEST(ReferenceSolution, OfASwingIsKnownToItsEnd) {
  const study::ReferenceSolution reference =
      study::solve_reference({swing(21), study::frame_times(0.5, 60)}, 1e-3, 1e9, no_tick);
  EXPECT_EQ(reference.known, reference.points.size());
  EXPECT_EQ(reference.checked, reference.known) << "by the truth";
  EXPECT_FALSE(reference.goes_on());
  EXPECT_LT(reference.self_error, 1e-5);
}

/// Upright but for a hair: a nudge soon decides where it goes.
World drop(std::size_t particles) {
  World world;
  Connector rope =
      straight_connector("rope", 0.2, 0.05, particles, {0, 0, 0}, Vec3(0.002, 1, 0).normalized());
  rope.particle_mass.back() += 0.2;
  rope.holds.push_back({0, Attachment{}});
  world.connectors.push_back(std::move(rope));
  finish(world);
  return world;
}

TEST(ReferenceSolution, BeyondTheHorizonKeepsWhatAllMotionsHaveInCommon) {
  const study::ReferenceSolution reference =
      study::solve_reference({drop(21), study::frame_times(1.5, 60)}, 1e-3, 1e9, no_tick);
  ASSERT_TRUE(reference.goes_on());
  EXPECT_LT(reference.known, 20u);
  EXPECT_NEAR(reference.most.energy, 1e-3 / 0.2, 1e-4) << "a closed world keeps its energy";
  const study::PlanModel model{drop(21), {}, {}};
  const auto outcome = [&](const MethodChoice& candidate) {
    return study::attempt(model, candidate, reference, {metres, 1e-3}, INFINITY).end;
  };
  EXPECT_EQ(outcome({"direct", {{"tolerance", 1e-5}}}), study::Trial::End::within);
  EXPECT_EQ(outcome({"springs", {{"stiffness", 2e4}, {"step", 1.0 / 7680}}}),
            study::Trial::End::unlike);
}

TEST(ErrorOfAChain, IsWhereTwiceAndFourTimesTheLinksLeadTo) {
  // Errors of 8, 4 and 2.
  EXPECT_DOUBLE_EQ(study::error_of_chain(4, 6).value(), 8);
  EXPECT_DOUBLE_EQ(study::error_of_chain(3, 3).value(), 3);
  EXPECT_FALSE(study::error_of_chain(1, 2).has_value()) << "they go on as they went";
  // Errors of 4/3, -2/3 and 1/3.
  EXPECT_GE(study::error_of_chain(2, 1).value(), 4.0 / 3);
  EXPECT_FALSE(study::error_of_chain(2, 0.1).has_value());
  EXPECT_FALSE(study::error_of_chain(1, INFINITY).has_value());
}

/// A rope of equal masses nears a continuous one with 1/n: the extrapolation from n, 2n and 4n
/// links must be what far more links show.
TEST(ErrorOfAChain, IsThatOfFarMoreLinks) {
  const study::ReferenceSolution reference =
      study::solve_reference({swing(6), study::frame_times(0.3, 60)}, 1e-3, 1e9, no_tick);
  const auto from = [&](std::size_t particles) {
    return study::distance_between(reference, swing(particles), {},
                                   {"direct", {{"tolerance", 1e-6}}}, metres);
  };
  const std::optional<double> error = study::error_of_chain(from(11), from(21));
  ASSERT_TRUE(error.has_value());
  EXPECT_NEAR(*error, from(321), 0.1 * *error);
}

class Planner : public testing::Test {
 protected:
  Planner() {
    std::vector<MethodChoice> candidates;
    for (int i = 2; i <= 7; ++i)
      candidates.push_back({"direct", {{"tolerance", std::pow(10, -i)}}});
    for (int i = 2; i <= 7; ++i) {
      const double step = std::ldexp(1.0 / 60, -i);
      candidates.push_back({"dynamic-constraints", {{"step", step}}});
      candidates.push_back({"impulse", {{"passes", 4.0}, {"step", step}}});
    }
    for (const std::size_t particles : {21, 11, 2}) {
      models_.push_back({swing(particles), {}, candidates});
    }
  }
  study::Search within(double most) {
    return study::search(models_, reference_, {metres, most}, [](std::size_t) {});
  }

  const study::ReferenceSolution reference_ =
      study::solve_reference({swing(21), study::frame_times(0.5, 60)}, 1e-3, 1e9, no_tick);
  std::vector<study::PlanModel> models_;
};

/// Candidates that the search gave up early for their cost, or did not run, must be dear when run
/// to their end.
TEST_F(Planner, FindsTheLeastWorkOfAllThatStayWithin) {
  for (const double most : {1e-4, 1e-3, 3e-2}) {
    const study::Search found = within(most);
    ASSERT_TRUE(found.best.has_value()) << most;
    const study::Trial& best = found.trials[*found.best];
    EXPECT_LE(best.error, most);
    EXPECT_LT(found.trials.size(), 3 * models_[0].candidates.size());
    for (std::size_t m = 0; m < models_.size(); ++m) {
      for (const MethodChoice& candidate : models_[m].candidates) {
        const study::Trial alone =
            study::attempt(models_[m], candidate, reference_, {metres, most}, INFINITY);
        if (alone.end != study::Trial::End::within) continue;
        EXPECT_GE(alone.cycles, best.cycles) << describe(candidate);
      }
    }
  }
}

TEST_F(Planner, TakesFewerParticlesWhereThatCannotBeSeen) {
  const study::Search fine = within(1e-4), coarse = within(3e-2);
  EXPECT_EQ(fine.trials[*fine.best].model, 0u) << "11 particles are a millimetre off";
  EXPECT_GT(coarse.trials[*coarse.best].model, 0u);
}

TEST_F(Planner, SaysWhereNothingIsNearEnough) {
  EXPECT_FALSE(within(1e-12).best.has_value());
}

TEST_F(Planner, LeavesOutWhatThereIsNoTimeFor) {
  const study::Search none = study::search(
      models_, reference_, {metres, 1e-2}, [](std::size_t) {}, [] { return 0.0; });
  EXPECT_FALSE(none.best.has_value());
  EXPECT_TRUE(none.trials.empty());
  EXPECT_EQ(none.left_out, 3 * models_[0].candidates.size());
  EXPECT_EQ(within(1e-2).left_out, 0u);
  // Rather a step that needs far more CPU time than a run may have.
  const MethodChoice fine{"impulse", {{"step", 1e-7}}};
  const study::Trial cut =
      study::attempt(models_[0], fine, reference_, {metres, 1}, INFINITY, 0.01);
  EXPECT_EQ(cut.end, study::Trial::End::cut);
}

TEST_F(Planner, MayBeStopped) {
  int tried = 0;
  EXPECT_THROW(study::search(models_, reference_, {metres, 1},
                             [&](std::size_t) {
                               if (++tried == 2) throw std::runtime_error("stop");
                             }),
               std::runtime_error);
}

}  // namespace
}  // namespace taut::planner_test
