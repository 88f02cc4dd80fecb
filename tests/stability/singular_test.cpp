// Systems of tensions that are singular, as they must be, and the methods that survive them.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "../physics/worlds.h"
#include "sim/links/mechanism.h"
#include "sim/links/tension.h"
#include "sim/measure/measure.h"
#include "sim/run/simulation.h"

namespace taut::singular_test {
namespace {

/// A straight chain between two fixed points, exactly its length apart.
World tightrope(std::size_t particles) {
  World world = worlds::chain(particles, 1, Vec3::UnitX());
  world.connectors[0].holds.push_back({particles - 1, worlds::fixed_at(Vec3::UnitX())});
  finish(world);
  return world;
}

struct System {
  explicit System(const World& world) : mechanism(world), tensions(mechanism) {
    mechanism.load(world, state);
    mechanism.update(world.time, state.data());
    tensions.assemble(mechanism);
  }
  Mechanism mechanism;
  TensionSystem tensions;
  std::vector<double> state;
};

// n links and n - 1 particles that can move along them: one row too many.
TEST(Singular, ATightropeHasOneTensionTooMany) {
  System system(tightrope(11));
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(system.tensions.dense()).eigenvalues();
  EXPECT_LT(std::abs(values[0]), 1e-12 * values[9]);
  EXPECT_GT(values[1], 1e-3 * values[9]);
  std::vector<double> right(10, 1), x;
  EXPECT_FALSE(system.tensions.solve_banded(right, x));
  EXPECT_FALSE(system.tensions.solve(right, x));
  for (const double tension : x) EXPECT_TRUE(std::isfinite(tension));
}

// The solution of least norm of a consistent system: a uniform pull is none, and so not added.
TEST(Singular, TheDenseSolverTakesTheLeastTensions) {
  System system(tightrope(11));
  const Eigen::MatrixXd& a = system.tensions.dense();
  const Eigen::VectorXd pulls = Eigen::VectorXd::LinSpaced(10, -1, 1);  // sums to zero
  const Eigen::VectorXd product = a * pulls;
  std::vector<double> right(product.data(), product.data() + product.size()), x;
  system.tensions.solve_dense(right, x);
  for (int i = 0; i < 10; ++i) EXPECT_NEAR(x[static_cast<std::size_t>(i)], pulls[i], 1e-10);
}

// Pins make spans of a straight rope: each has a tension too many, and none costs the others
// anything.
TEST(Singular, ManySpansAtFullLengthAreAsManySmallSystems) {
  constexpr std::size_t kLinks = 30'000, kSpan = 3;
  World world = worlds::chain(kLinks + 1, 1, Vec3::UnitX());
  for (std::size_t i = kSpan; i <= kLinks; i += kSpan) {
    world.connectors[0].holds.push_back({i, worlds::fixed_at(world.connectors[0].position[i])});
  }
  finish(world);
  System system(world);
  // In a span the pulls -1, 0 and 1 add up to nothing: those of least norm that do what they do.
  const auto pull = [](std::size_t row) { return static_cast<double>(row % kSpan) - 1; };
  const double w = system.mechanism.inverse_mass()[1];
  std::vector<double> right(kLinks), x;
  for (std::size_t r = 0; r < kLinks; ++r) {
    const double before = r % kSpan > 0 ? pull(r) - pull(r - 1) : 0;
    const double behind = r % kSpan + 1 < kSpan ? pull(r) - pull(r + 1) : 0;
    right[r] = w * (before + behind);
  }
  EXPECT_FALSE(system.tensions.solve(right, x));
  for (std::size_t r = 0; r < kLinks; ++r) ASSERT_NEAR(x[r], pull(r), 1e-9) << r;
}

TEST(Singular, BandedAndDenseAgreeWhereNothingIsSingular) {
  for (const World& world : {worlds::chain_with_box(11), worlds::thrown(11), worlds::garland()}) {
    System system(world);
    std::vector<double> right(system.mechanism.rows().size()), banded, dense;
    for (std::size_t r = 0; r < right.size(); ++r) {
      right[r] = system.mechanism.free_acceleration(r) + 1;
    }
    ASSERT_TRUE(system.tensions.solve_banded(right, banded));
    system.tensions.solve_dense(right, dense);
    for (std::size_t r = 0; r < right.size(); ++r) {
      EXPECT_NEAR(banded[r], dense[r], 1e-9 * (1 + std::abs(dense[r]))) << r;
    }
  }
}

/// Both solvers; the tridiagonal one hands singular systems to the dense one.
World constrained(const World& start, const char* solver, double time) {
  Simulation simulation(start, make_method("dynamic-constraints",
                                           {{"step", 0.001}, {"solver", std::string(solver)}}));
  simulation.advance_to(time);
  return simulation.world();
}

// Half of it pulls and half of it pushes against a weight along it, and nothing moves.
TEST(Singular, ATightropeBearsAWeightAlongIt) {
  World world = tightrope(11);
  world.gravity = Vec3(9.81, 0, 0);
  for (const char* solver : {"dense", "tridiagonal"}) {
    const World end = constrained(world, solver, 0.2);
    EXPECT_LT(stretch_max(end), 1e-9) << solver;
    EXPECT_LT(end.connectors[0].velocity[5].norm(), 1e-9) << solver;
  }
}

// No tensions can keep the lengths: those that come closest share the stretch among all links.
TEST(Singular, EndsPulledApartBeyondTheLengthStretchAllLinksAlike) {
  World world = tightrope(11);
  world.gravity.setZero();
  std::vector<PathKey> keys(2);
  keys[0] = {.time = 0, .position = Vec3(1, 0, 0), .rotation = Quat::Identity(), .ease = true};
  keys[1] = {.time = 0.2, .position = Vec3(1.01, 0, 0), .rotation = Quat::Identity(), .ease = true};
  world.connectors[0].holds[1].to = worlds::on_path(std::make_shared<const Path>(keys));
  for (const char* solver : {"dense", "tridiagonal"}) {
    EXPECT_NEAR(stretch_max(constrained(world, solver, 0.3)), 0.01, 1e-3) << solver;
  }
}

TEST(Singular, PointsThatCoincideHaveNoDirectionAndNoForce) {
  World world = worlds::chain(5, 0.4, -Vec3::UnitY());
  world.connectors[0].position[3] = world.connectors[0].position[2];
  System system(world);
  EXPECT_TRUE(system.mechanism.direction()[2].isZero());
  std::vector<double> x;
  system.tensions.solve(std::vector<double>(4, 1), x);
  for (const double tension : x) EXPECT_TRUE(std::isfinite(tension));
}

}  // namespace
}  // namespace taut::singular_test
