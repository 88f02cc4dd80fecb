// Kinds of rows that the direct method does not know (plane_row.h, rod_row.h), with known answers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sim/measure/measure.h"
#include "sim/methods/direct/integrator.h"
#include "tests/physics/contact/plane_row.h"
#include "tests/physics/joined/rod_row.h"

namespace taut::direct {
namespace {

constexpr double kGravity = 9.81;            // m/s^2
constexpr double kLink = 0.5;                // m
constexpr double kUpper = 0.2, kLast = 0.3;  // kg
constexpr ConstraintRow::Particle kHeld{0, 0}, kTip{0, 2};

/// Two links that hang from the origin, at rest; their last two particles are at these places.
World two_links(const Vec3& middle, const Vec3& tip) {
  World world;
  Connector links = straight_connector("links", 2 * kLink, 1, 3, Vec3::Zero(), Vec3::UnitX());
  links.holds = {{0, {}}};
  links.position = {Vec3::Zero(), middle, tip};
  links.particle_mass = {0.1, kUpper, kLast};
  world.connectors = {links};
  finish(world);
  return world;
}

/// Follows a world of one component under rows, which may change between two looks.
class RowRun {
 public:
  explicit RowRun(World world) : world_(std::move(world)), integrator_(options()) {
    integrator_.follow(division_.divide(world_)[0]);
    set_rows({});
  }
  void set_rows(std::initializer_list<const ConstraintRow*> rows) {
    integrator_.set_rows({rows.begin(), rows.size()});
    integrator_.load(world_);
    integrator_.store(world_);
  }
  void advance(double until) {
    Counters counters;
    integrator_.advance(world_, until, counters);
    world_.time = until;
    place_prescribed(world_, until);
    integrator_.store(world_);
  }
  const World& world() const { return world_; }
  const Vec3& position(std::size_t k) const { return world_.connectors[0].position[k]; }
  const Vec3& velocity(std::size_t k) const { return world_.connectors[0].velocity[k]; }

 private:
  static StepOptions options() {
    StepOptions options;
    options.tolerance = 1e-9;
    return options;
  }
  World world_;
  Division division_;
  Integrator integrator_;
};

/// An angle that starts at rest, after `time`, by the classical method of Runge and Kutta.
template <typename Acceleration>
std::pair<double, double> angle_after(double time, double angle, Acceleration acceleration) {
  constexpr int kSteps = 4000;
  const double h = time / kSteps;
  double rate = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double a1 = acceleration(angle, rate), r2 = rate + h / 2 * a1;
    const double a2 = acceleration(angle + h / 2 * rate, r2), r3 = rate + h / 2 * a2;
    const double a3 = acceleration(angle + h / 2 * r2, r3), r4 = rate + h * a3;
    const double a4 = acceleration(angle + h * r3, r4);
    angle += h / 6 * (rate + 2 * r2 + 2 * r3 + r4);
    rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
  }
  return {angle, rate};
}

// A slider crank: both links at the same angle against the vertical on which the tip slides. With
// the angle p, (m + 4 M sin^2 p) l p'' = -(m + 2 M) g sin p - 4 M l sin p cos p p'^2.
TEST(ConstraintRows, ATipThatSlidesOnAPlaneIsASliderCrank) {
  constexpr double kStart = 1.0, kTime = 0.7;
  RowRun run(two_links({kLink * std::sin(kStart), -kLink * std::cos(kStart), 0},
                       {0, -2 * kLink * std::cos(kStart), 0}));
  const PlaneRow wall(kTip, Vec3::UnitX(), 0);
  run.set_rows({&wall});
  run.advance(kTime);
  const auto [angle, rate] = angle_after(kTime, kStart, [](double p, double v) {
    const double s = std::sin(p), c = std::cos(p);
    return -((kUpper + 2 * kLast) * kGravity * s + 4 * kLast * kLink * s * c * v * v) /
           ((kUpper + 4 * kLast * s * s) * kLink);
  });
  constexpr double kError = 1e-8;
  const Vec3 middle(kLink * std::sin(angle), -kLink * std::cos(angle), 0);
  EXPECT_LT((run.position(1) - middle).norm(), kError);
  EXPECT_LT((run.velocity(2) - Vec3(0, 2 * kLink * std::sin(angle) * rate, 0)).norm(), 10 * kError);
  EXPECT_LT(std::abs(run.position(2).x()), 1e-14);
}

// At rest the tip starts upwards with 2 l p'' sin p; the plane takes what its link pulls sideways.
TEST(ConstraintRows, AMultiplierIsTheForceOfItsRow) {
  constexpr double kStart = 1.0;
  const double s = std::sin(kStart), c = std::cos(kStart);
  const World world = two_links({kLink * s, -kLink * c, 0}, {0, -2 * kLink * c, 0});
  const PlaneRow wall(kTip, Vec3::UnitX(), 0);
  const ConstraintRow* const rows[] = {&wall};
  Division division;
  System system;
  system.rebuild(world, division.divide(world)[0], std::nullopt, rows);
  Array q(system.size()), rate(system.size()), acceleration(system.size());
  system.load(world, 0, q.data(), rate.data());
  system.acceleration(0, q.data(), rate.data(), acceleration.data());
  const double turn = -(kUpper + 2 * kLast) * kGravity * s / ((kUpper + 4 * kLast * s * s) * kLink);
  const double tension = kLast * (kGravity + 2 * kLink * s * turn) / c;
  EXPECT_NEAR(system.tension(1), tension, 1e-13);
  EXPECT_NEAR(system.multiplier(0), -tension * s, 1e-13);
}

// A triangle that hangs by a corner is one pendulum.
TEST(ConstraintRows, ARodMakesAPendulumOfTwoLinks) {
  constexpr double kRod = 0.6, kTime = 0.8;
  const double corner = std::acos(kRod / 2 / kLink);  // between the rod and the first link
  const auto at = [](double distance, double angle) {
    return Vec3(distance * std::sin(angle), -distance * std::cos(angle), 0);
  };
  constexpr double kStart = 1.2;  // rad, of the rod
  RowRun run(two_links(at(kLink, kStart + corner), at(kRod, kStart)));
  const RodRow rod(kHeld, kTip, kRod);
  run.set_rows({&rod});
  run.advance(kTime);
  const auto [angle, rate] = angle_after(kTime, kStart, [&](double p, double) {
    return -kGravity * (kUpper * kLink * std::sin(p + corner) + kLast * kRod * std::sin(p)) /
           (kUpper * kLink * kLink + kLast * kRod * kRod);
  });
  constexpr double kError = 1e-8;
  EXPECT_LT((run.position(1) - at(kLink, angle + corner)).norm(), kError);
  EXPECT_LT((run.position(2) - at(kRod, angle)).norm(), kError);
  EXPECT_NEAR(run.velocity(2).norm(), kRod * std::abs(rate), 10 * kError);
}

// A row that joins takes the velocity along its gradient by one impulse, as the mass matrix of the
// two angles has it; then nothing is lost, and a row that leaves is felt no more.
TEST(ConstraintRows, JoinAndLeaveAtAnyInstant) {
  RowRun run(two_links({kLink, 0, 0}, {2 * kLink, 0, 0}));
  run.advance(0.313);
  const auto angles = [&run] {
    const Vec3 a = run.position(1), b = run.position(2) - run.position(1);
    return Eigen::Vector2d(std::atan2(a.x(), -a.y()), std::atan2(b.x(), -b.y()));
  };
  const auto along = [](double angle) { return Eigen::Vector2d(std::cos(angle), std::sin(angle)); };
  const Eigen::Vector2d p = angles();
  Eigen::Matrix<double, 2, 2> upper, tip;  // of the velocities, by the angles' rates
  upper << kLink * along(p[0]), Eigen::Vector2d::Zero();
  tip << kLink * along(p[0]), kLink * along(p[1]);
  const Eigen::Matrix2d mass = kUpper * upper.transpose() * upper + kLast * tip.transpose() * tip;
  const Eigen::Vector2d before = tip.inverse() * run.velocity(2).head<2>();
  const Eigen::Vector2d row = tip.row(0).transpose(), response = mass.inverse() * row;
  const Eigen::Vector2d after = before - response * row.dot(before) / row.dot(response);

  const PlaneRow wall(kTip, Vec3::UnitX(), run.position(2).x());
  run.set_rows({&wall});
  constexpr double kRounding = 1e-12;
  EXPECT_LT((tip.inverse() * run.velocity(2).head<2>() - after).norm(), kRounding * after.norm());
  EXPECT_LT(std::abs(run.velocity(2).x()), kRounding);

  const double kept = energy(run.world()), place = run.position(2).x();
  run.advance(0.313 + 0.2);
  EXPECT_NEAR(energy(run.world()), kept, 1e-8 * std::abs(kept));
  EXPECT_NEAR(run.position(2).x(), place, kRounding);

  run.set_rows({});
  RowRun alone(run.world());
  run.advance(0.313 + 0.4);
  alone.advance(0.313 + 0.4);
  EXPECT_LT((run.position(2) - alone.position(2)).norm(), 1e-9);
  EXPECT_GT(std::abs(run.velocity(2).x()), 0.01);
  EXPECT_NEAR(energy(run.world()), kept, 1e-8 * std::abs(kept));
}

TEST(ConstraintRows, OfWhatTheyCannotHoldAreRefused) {
  World flying = two_links({kLink, 0, 0}, {2 * kLink, 0, 0});
  const PlaneRow wall(kTip, Vec3::UnitX(), 0), elsewhere({1, 0}, Vec3::UnitX(), 0);
  RowRun run(flying);
  EXPECT_THROW(run.set_rows({&elsewhere}), std::invalid_argument);
  flying.connectors[0].holds.clear();
  finish(flying);
  RowRun free(flying);
  EXPECT_THROW(free.set_rows({&wall}), std::invalid_argument);
}

}  // namespace
}  // namespace taut::direct
