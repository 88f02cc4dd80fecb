#include "sim/motion/path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <stdexcept>

namespace taut::path_test {
namespace {

Quat turn(double angle, const Vec3& axis) {
  return Quat(Eigen::AngleAxisd(angle, axis));
}

/// A swing, a hold of 0.4 s, and a swing on.
std::vector<PathKey> swing_hold_swing() {
  return {{0.0, Vec3(0, 1, 0), Quat::Identity()},
          {0.3, Vec3(0.4, 1.2, 0.1), turn(0.9, Vec3::UnitZ())},
          {0.5, Vec3(0.5, 1.0, -0.2), turn(1.7, Vec3(1, 2, 3).normalized())},
          {0.9, Vec3(0.1, 0.8, 0.2), turn(2.9, Vec3(1, 2, 2).normalized()), true},
          {1.3, Vec3(0.1, 0.8, 0.2), turn(2.9, Vec3(1, 2, 2).normalized()), true},
          {1.6, Vec3(-0.3, 1.1, 0.2), turn(1.4, Vec3::UnitX())},
          {2.0, Vec3(0.2, 1.3, 0.0), turn(0.2, Vec3::UnitY())}};
}

TEST(Path, PassesThroughEveryKey) {
  const Path path(swing_hold_swing());
  for (const PathKey& key : path.keys()) {
    const FrameMotion motion = path.at(key.time);
    EXPECT_LT((motion.position - key.position).norm(), 1e-15);
    EXPECT_LT(motion.rotation.angularDistance(key.rotation), 1e-7);  // acos of 1 - rounding
    EXPECT_NEAR(motion.rotation.norm(), 1, 1e-15);
  }
}

TEST(Path, RestsOutsideAndWhereItHolds) {
  const Path path(swing_hold_swing());
  for (const double time : {-1.0, 0.0, 0.9, 0.95, 1.1, 1.3, 2.0, 5.0}) {
    const FrameMotion motion = path.at(time);
    EXPECT_LT(motion.velocity.norm(), 1e-13) << time;
    EXPECT_LT(motion.acceleration.norm(), 1e-12) << time;
    EXPECT_LT(motion.spin.norm(), 1e-13) << time;
    EXPECT_LT(motion.spin_rate.norm(), 1e-12) << time;
  }
  EXPECT_LT((path.at(1.1).position - path.keys()[3].position).norm(), 1e-15);
  EXPECT_EQ(path.at(-1).position, path.keys().front().position);
  EXPECT_EQ(path.at(5).position, path.keys().back().position);
}

/// The largest difference quotient of the function over the path, as a bound of its derivative.
template <typename Function>
double steepest(Function f) {
  double most = 0;
  for (double t = -0.1; t < 2.1; t += 1e-4)
    most = std::max(most, (f(t + 1e-4) - f(t)).norm() / 1e-4);
  return most;
}

TEST(Path, IsTwiceContinuouslyDifferentiable) {
  const Path path(swing_hold_swing());
  const auto acceleration = [&](double t) { return path.at(t).acceleration; };
  const auto spin_rate = [&](double t) { return path.at(t).spin_rate; };
  const double jerk = steepest(acceleration), spin_jerk = steepest(spin_rate);
  const double side = 1e-7;
  for (const PathKey& key : path.keys()) {
    const FrameMotion before = path.at(key.time - side), after = path.at(key.time + side);
    // A jump would stay however small `side`; a slope gives at most 2 side jerk.
    EXPECT_LT((after.acceleration - before.acceleration).norm(), 3 * side * jerk);
    EXPECT_LT((after.spin_rate - before.spin_rate).norm(), 3 * side * spin_jerk);
  }
}

TEST(Path, DerivativesAreThoseOfTheMotion) {
  const Path path(swing_hold_swing());
  // A central difference over +-h is off by at most h^2/6 of the third derivative and, in a value
  // of size about 1, by rounding of about 1e-15/h.
  const double h = 1e-4;
  const auto acceleration = [&](double t) { return path.at(t).acceleration; };
  const auto spin_rate = [&](double t) { return path.at(t).spin_rate; };
  const double jerk = steepest(acceleration), spin_jerk = steepest(spin_rate);
  const double jump = 2 * h * jerk;  // at a key the third derivative jumps
  for (double t = 0.013; t < 2; t += 0.017) {
    const FrameMotion before = path.at(t - h), now = path.at(t), after = path.at(t + h);
    const Vec3 velocity = (after.position - before.position) / (2 * h);
    EXPECT_LT((velocity - now.velocity).norm(), h * h / 6 * jerk + 1e-10) << t;
    const Vec3 change = (after.velocity - before.velocity) / (2 * h);
    EXPECT_LT((change - now.acceleration).norm(), jump + 1e-10) << t;
    const Quat turned = after.rotation * before.rotation.conjugate();
    const Vec3 spin = 2 * turned.vec() / (turned.w() < 0 ? -1 : 1) / (2 * h);
    // Turning by the vector s over 2h: sin(|s| h) / h is off by |s|^3 h^2 / 6 besides.
    const double size = now.spin.norm();
    EXPECT_LT((spin - now.spin).norm(), h * h * (spin_jerk + size * size * size) + 1e-10) << t;
    const Vec3 spin_change = (after.spin - before.spin) / (2 * h);
    EXPECT_LT((spin_change - now.spin_rate).norm(), 2 * h * spin_jerk + 1e-10) << t;
  }
}

TEST(Path, HoldsSeparateWhatIsBeforeFromWhatIsAfter) {
  std::vector<PathKey> keys = swing_hold_swing();
  const Path path(keys);
  keys[1].position += Vec3(0.3, -0.2, 0.1);
  const Path moved(keys);
  for (double t = 0.9; t < 2.1; t += 0.01) {
    EXPECT_EQ(path.at(t).position, moved.at(t).position);
    EXPECT_EQ(path.at(t).spin, moved.at(t).spin);
  }
  EXPECT_GT((path.at(0.4).position - moved.at(0.4).position).norm(), 0.05);
}

TEST(Path, TurnsTheShortWayAndAboutTheAxisOfItsKeys) {
  std::vector<PathKey> keys;
  for (int i = 0; i <= 8; ++i)
    keys.push_back({i * 0.25, Vec3::Zero(), turn(i * M_PI / 4, Vec3::UnitZ())});
  keys[3].rotation.coeffs() = -keys[3].rotation.coeffs();  // the same rotation
  const Path path(keys);
  for (double t = 0; t < 2; t += 0.01) {
    const FrameMotion motion = path.at(t);
    EXPECT_LT(motion.spin.head<2>().norm(), 1e-12);
    EXPECT_GT(motion.spin.z(), -1e-12);
    EXPECT_LT(motion.spin.z(), 2 * M_PI);  // pi rad/s on average
  }
}

// Its velocity goes from a key's to the next one's by the smooth step 3 u^2 - 2 u^3, where places
// are apart by the mean of both.
TEST(Path, PassesKeysWithTheirVelocity) {
  const Vec3 slow(0.2, 0, -0.1), fast(1.0, 2.0, 0.5), start(1, 2, 3);
  const double h = 0.8;
  const Path path({{0.5, start, Quat::Identity(), true, slow},
                   {0.5 + h, start + h * (slow + fast) / 2, Quat::Identity(), true, fast},
                   {0.5 + 2 * h, start + h * (slow + 3 * fast) / 2, Quat::Identity(), true, fast}});
  for (const double u : {0.0, 0.1, 0.5, 0.8, 1.0}) {
    const FrameMotion now = path.at(0.5 + u * h);
    const double share = u * u * (3 - 2 * u);
    EXPECT_LT((now.velocity - slow - share * (fast - slow)).norm(), 1e-14);
    EXPECT_LT((now.acceleration - 6 * u * (1 - u) / h * (fast - slow)).norm(), 1e-13);
    const double way = u * u * u * (1 - u / 2);
    EXPECT_LT((now.position - start - h * (u * slow + way * (fast - slow))).norm(), 1e-14);
  }
  for (const double t : {1.3, 1.7, 2.1, 3.0}) {  // steady between equal keys and beyond the last
    const Vec3 way = h * (slow + fast) / 2 + (t - 0.5 - h) * fast;
    EXPECT_LT((path.at(t).position - start - way).norm(), 1e-14);
    EXPECT_LT((path.at(t).velocity - fast).norm(), 1e-14);
    EXPECT_LT(path.at(t).acceleration.norm(), 1e-13);
  }
  EXPECT_LT((path.at(-1).position - start + 1.5 * slow).norm(), 1e-15);
  EXPECT_NE(path.fingerprint(), Path(std::vector<PathKey>{{0.5, start}}).fingerprint());
}

TEST(Path, OneKeyIsAPlace) {
  const Path path({{2.0, Vec3(1, 2, 3), turn(1, Vec3::UnitX())}});
  for (const double t : {0.0, 2.0, 3.0}) EXPECT_EQ(path.at(t).position, Vec3(1, 2, 3));
}

TEST(Path, GoesRoundACircle) {
  const Circle circle{Vec3(0, 1.15, 0), Vec3(0, 1, 0), Vec3::UnitZ(), 1.5, 0.5};
  const Path path = Path::round(circle);
  EXPECT_EQ(path.at(-1).position, circle.start);
  EXPECT_EQ(path.at(-1).velocity, Vec3::Zero());
  const double speed = 2 * M_PI * 1.5;  // rad/s
  // The smoothstep's integral is a half, so half a ramp of full speed is behind.
  for (const double t : {0.5, 0.6, 1.0, 7.0}) {
    const double angle = speed * (t - 0.25);
    const Vec3 out(std::sin(angle), -std::cos(angle), 0),
        along(std::cos(angle), std::sin(angle), 0);
    const FrameMotion motion = path.at(t);
    EXPECT_LT((motion.position - (circle.centre + 0.15 * out)).norm(), 1e-14) << t;
    EXPECT_LT((motion.velocity - 0.15 * speed * along).norm(), 1e-12) << t;
    EXPECT_LT((motion.acceleration + 0.15 * speed * speed * out).norm(), 1e-11) << t;
  }
  // Half of the ramp: smoothstep 1/2, its integral 3/32, its slope 3/2 over the ramp.
  const FrameMotion half = path.at(0.25);
  EXPECT_NEAR(half.velocity.norm(), 0.15 * speed / 2, 1e-14);
  EXPECT_NEAR(std::atan2(half.position.x(), 1.15 - half.position.y()), speed * 0.5 * 3 / 32, 1e-14);
  EXPECT_NEAR(half.acceleration.dot(half.velocity.normalized()), 0.15 * speed * 1.5 / 0.5, 1e-12);
}

TEST(Path, RefusesTimesThatDoNotRise) {
  EXPECT_THROW(Path(std::vector<PathKey>{}), std::invalid_argument);
  EXPECT_THROW(Path({{0, Vec3::Zero()}, {0, Vec3::UnitX()}}), std::invalid_argument);
  EXPECT_THROW(Path({{1, Vec3::Zero()}, {0, Vec3::UnitX()}}), std::invalid_argument);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Path({{0, Vec3::Zero()}, {nan, Vec3::UnitX()}}), std::invalid_argument);
}

/// Turns about x and moves along it, as a screw.
Path screw() {
  Axle axle;
  axle.position = {0.1, 0.2, 0.3};
  axle.axis = Vec3::UnitX();
  axle.pitch = 0.5;
  axle.angle = std::make_shared<const Path>(
      std::vector<PathKey>{{0, Vec3::Zero()}, {1, {7, 0, 0}}, {2, {4, 0, 0}}});
  return Path::about(axle);
}

TEST(Path, TurnsAboutAnAxleAndMovesByItsPitch) {
  const Path path = screw();
  const FrameMotion frame = path.at(1);
  const double turns = 7 / (2 * std::numbers::pi);
  EXPECT_NEAR((frame.position - Vec3(0.1 + 0.5 * turns, 0.2, 0.3)).norm(), 0, 1e-15);
  EXPECT_NEAR((frame.rotation * Vec3::UnitY() - Vec3::UnitX()).norm(), 0, 1e-15);
  constexpr double kStep = 1e-5;  // s
  const Vec3 arm(0.3, 0.1, -0.2);
  const PointMotion point = path.at(0.6).point(arm), later = path.at(0.6 + kStep).point(arm),
                    before = path.at(0.6 - kStep).point(arm);
  EXPECT_NEAR((later.position - before.position - 2 * kStep * point.velocity).norm(), 0, 1e-11);
  EXPECT_NEAR((later.velocity - before.velocity - 2 * kStep * point.acceleration).norm(), 0, 1e-9);
}

TEST(Path, IsTheSameMotionBesideAndLater) {
  Circle circle;
  circle.start = circle.centre + Vec3::UnitX();
  for (const Path& path :
       {Path::round(circle), screw(), Path({{0, Vec3::Zero()}, {2, Vec3::UnitY()}})}) {
    const Path moved = path.moved({1, 2, 3}, 0.25);
    const FrameMotion one = path.at(0.7), other = moved.at(0.95);
    EXPECT_NEAR((other.position - one.position - Vec3(1, 2, 3)).norm(), 0, 1e-14);
    EXPECT_NEAR((other.velocity - one.velocity).norm(), 0, 1e-13);
    EXPECT_NEAR(other.rotation.angularDistance(one.rotation), 0, 1e-7);  // of an arc cosine
    EXPECT_NE(moved.fingerprint(), path.fingerprint());
    EXPECT_EQ(moved.keys().front().time, path.keys().front().time + 0.25);
  }
}

}  // namespace
}  // namespace taut::path_test
