// Rigid bodies without torque, against the known motion of tops.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/measure/measure.h"
#include "sim/motion/rotation.h"

namespace taut::rigid_body_test {
namespace {

constexpr double kRounding = 1e-13;

Body tumbling(const MassProperties& properties, const Vec3& spin) {
  Body body;
  body.mass_properties = properties;
  body.rotation = Quat(Eigen::AngleAxisd(0.4, Vec3(2, -1, 1).normalized()));
  body.spin = body.rotation * spin;
  return body;
}

Vec3 momentum(const Body& body) {
  return body.world_inertia() * body.spin;
}
double energy(const Body& body) {
  return body.spin.dot(momentum(body)) / 2;
}

TEST(FreeRotation, ASymmetricTopPrecessesAboutItsMomentumAtLOverI) {
  const MassProperties stick = solid_cylinder(0.12, 0.3, 0.028);
  Body body = tumbling(stick, Vec3(5, 30, -2));  // mostly about its own axis, y
  const FreeRotation rotation(stick.inertia);
  const Vec3 held = momentum(body);
  const Vec3 axis = body.rotation * Vec3::UnitY();
  const double kinetic = energy(body);
  const double rate = held.norm() / stick.inertia(0, 0);
  double time = 0;
  for (const double dt : {0.37, 0.001, 1.9, 0.02}) {  // exact, so steps may be of any size
    rotation.turn(body.rotation, body.spin, dt);
    time += dt;
    const Vec3 expected = Eigen::AngleAxisd(rate * time, held.normalized()) * axis;
    EXPECT_LT((body.rotation * Vec3::UnitY() - expected).norm(), kRounding * (1 + rate * time));
    EXPECT_LT((momentum(body) - held).norm(), kRounding * held.norm());
    EXPECT_NEAR(energy(body), kinetic, kRounding * kinetic);
    EXPECT_NEAR(body.rotation.norm(), 1, 1e-15);
  }
}

TEST(FreeRotation, AnyBodyKeepsItsMomentumExactlyAndItsEnergyToSecondOrder) {
  const MassProperties book = solid_box(1, Vec3(0.05, 0.3, 0.2));
  const FreeRotation rotation(book.inertia);
  const auto drift = [&](double dt) {
    Body body = tumbling(book, Vec3(0.01, 0.02, 8));  // about the unstable middle axis
    const Vec3 held = momentum(body);
    const double kinetic = energy(body);
    double most = 0;
    for (int i = 0; i * dt < 20; ++i) {
      rotation.turn(body.rotation, body.spin, dt);
      most = std::max(most, std::abs(energy(body) / kinetic - 1));
      EXPECT_LT((momentum(body) - held).norm(), 1e-11 * held.norm());
    }
    return most;
  };
  const double coarse = drift(0.01), fine = drift(0.005);
  EXPECT_LT(coarse, 0.05);
  EXPECT_GT(coarse / fine, 3.5);  // bounded over many flips, and second order: a quarter
  EXPECT_LT(coarse / fine, 4.5);
}

TEST(FreeRotation, TheMiddleAxisIsUnstableAndTheOthersAreNot) {
  const MassProperties book = solid_box(1, Vec3(0.05, 0.3, 0.2));
  const FreeRotation rotation(book.inertia);
  const auto most_tilt = [&](int axis) {
    Vec3 spin = Vec3::Constant(0.02);
    spin[axis] = 8;
    Body body = tumbling(book, spin);
    const Vec3 start = body.rotation * Vec3::Unit(axis);
    double least = 1;
    for (int i = 0; i < 5000; ++i) {
      rotation.turn(body.rotation, body.spin, 0.002);
      least = std::min(least, start.dot(body.rotation * Vec3::Unit(axis)));
    }
    return std::acos(least);
  };
  // Moments of the box about x, y, z rise as y2+z2, x2+z2, x2+y2: 0.13, 0.0425, 0.0925.
  EXPECT_LT(most_tilt(0), 0.05);
  EXPECT_LT(most_tilt(1), 0.05);
  EXPECT_GT(most_tilt(2), 3.0);
}

TEST(FreeRotation, BodiesWithoutMomentsAboutAnAxisStayFinite) {
  for (const MassProperties& thin : {solid_cylinder(1, 0.5, 0), solid_sphere(1, 0)}) {
    Body body = tumbling(thin, Vec3(3, 4, 5));
    const FreeRotation rotation(thin.inertia);
    for (int i = 0; i < 1000; ++i) rotation.turn(body.rotation, body.spin, 0.01);
    EXPECT_TRUE(body.rotation.coeffs().allFinite());
    EXPECT_TRUE(rotation.inverse_inertia(body.rotation).allFinite());
    EXPECT_NEAR(body.spin.norm(), std::sqrt(50), 1e-9);
  }
}

TEST(FreeRotation, TheInverseInertiaUndoesTheInertia) {
  const MassProperties odd = with_point_mass(solid_box(1, Vec3(0.1, 0.3, 0.2)), 0.4, {0.1, 0.2, 0});
  const Body body = tumbling(odd, Vec3::Zero());
  const Mat3 inverse = FreeRotation(odd.inertia).inverse_inertia(body.rotation);
  EXPECT_TRUE((inverse * body.world_inertia()).isApprox(Mat3::Identity(), 1e-12));
}

}  // namespace
}  // namespace taut::rigid_body_test
