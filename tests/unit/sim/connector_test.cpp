#include "sim/world/connector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace taut::connector_test {
namespace {

const Vec3 kGravity(0, -9.81, 0);

Connector rope(std::size_t particles) {
  return straight_connector("rope", 1, 0.3, particles, Vec3(1, 2, 3), Vec3(0, 0, -2));
}

TEST(Connector, AStraightOneSharesLengthAndMassEvenly) {
  const Connector connector = rope(6);
  EXPECT_EQ(connector.particles(), 6u);
  EXPECT_EQ(connector.links(), 5u);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_DOUBLE_EQ(connector.rest[k], 0.2);
    EXPECT_NEAR((connector.position[k + 1] - connector.position[k]).norm(), 0.2, 1e-15);
  }
  for (const double mass : connector.particle_mass) EXPECT_DOUBLE_EQ(mass, 0.05);
  EXPECT_LT((connector.position.back() - Vec3(1, 2, 2)).norm(), 1e-15);
}

TEST(Connector, RefusesWhatCannotBe) {
  const auto make = [](double length, double mass, std::size_t particles, const Vec3& direction) {
    return straight_connector("rope", length, mass, particles, Vec3::Zero(), direction);
  };
  EXPECT_THROW(make(1, 1, 1, Vec3::UnitX()), std::invalid_argument);
  EXPECT_THROW(make(-1, 1, 2, Vec3::UnitX()), std::invalid_argument);
  EXPECT_THROW(make(1, -1, 2, Vec3::UnitX()), std::invalid_argument);
  EXPECT_THROW(make(1, 1, 2, Vec3::Zero()), std::invalid_argument);
  EXPECT_THROW(make(std::nan(""), 1, 2, Vec3::UnitX()), std::invalid_argument);
  EXPECT_NO_THROW(make(0, 1, 2, Vec3::Zero()));  // a joint
}

/// The largest relative error of a link's length.
double misfit(const Connector& connector, const std::vector<Vec3>& points) {
  double most = 0;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    most = std::max(most, std::abs((points[k + 1] - points[k]).norm() / connector.rest[k] - 1));
  }
  return most;
}

TEST(HangingPoints, BeadsHangInTheirCatenary) {
  const Connector connector = rope(13);
  const Vec3 from(0.5, 1, 0.2), to(0.9, 1.3, -0.1);
  const std::vector<Vec3> points = hanging_points(connector, from, to, kGravity);
  EXPECT_EQ(points.front(), from);
  EXPECT_EQ(points.back(), to);
  EXPECT_LT(misfit(connector, points), 1e-12);
  // tan(theta_{k+1}) - tan(theta_k) = m g / H, the same for every bead.
  const Vec3 across = Vec3(0.4, 0, -0.3).normalized();
  const auto tangent = [&](std::size_t k) {
    const Vec3 link = points[k + 1] - points[k];
    return link.y() / link.dot(across);
  };
  const double first = tangent(1) - tangent(0);
  EXPECT_GT(first, 0);
  for (std::size_t k = 1; k + 2 < points.size(); ++k) {
    EXPECT_NEAR(tangent(k + 1) - tangent(k), first, 1e-9 * std::abs(tangent(0)));
  }
}

TEST(HangingPoints, HeavyBeadsPullTheirPartDown) {
  Connector connector = rope(5);
  connector.particle_mass[2] += 10;  // nearly a V
  const std::vector<Vec3> points =
      hanging_points(connector, Vec3::Zero(), Vec3(0.6, 0, 0), kGravity);
  EXPECT_LT(misfit(connector, points), 1e-12);
  EXPECT_NEAR(points[2].y(), -0.4, 0.4 * 0.3 / 10);  // sides 0.5, half-span 0.3
}

TEST(HangingPoints, NarrowSpansFold) {
  // Three links between one point hang as a triangle, its lowest side pressed together.
  const Connector three = rope(4);
  std::vector<Vec3> points = hanging_points(three, Vec3::Zero(), Vec3::Zero(), kGravity);
  EXPECT_LT(misfit(three, points), 1e-9);
  EXPECT_NEAR(points[1].y(), -std::sqrt(3) / 6, 1e-9);
  EXPECT_NEAR(points[2].y(), points[1].y(), 1e-9);
  const Connector forty = rope(41);
  points = hanging_points(forty, Vec3::Zero(), Vec3::Zero(), kGravity);
  EXPECT_LT(misfit(forty, points), 1e-6);
  EXPECT_NEAR(points[20].y(), -0.5, 1e-6);
}

TEST(HangingPoints, TautOrWeightlessOnesAreFine) {
  const Connector connector = rope(7);
  const Vec3 to(0.6, 0.8, 0);
  EXPECT_LT(misfit(connector, hanging_points(connector, Vec3::Zero(), to, kGravity)), 1e-12);
  EXPECT_LT(misfit(connector, hanging_points(connector, Vec3::Zero(), 0.7 * to, Vec3::Zero())),
            1e-9);
}

}  // namespace
}  // namespace taut::connector_test
