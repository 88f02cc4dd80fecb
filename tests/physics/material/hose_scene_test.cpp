// scenes/materials/hose.toml: where the hose has come to rest it is an elastica under its own
// weight.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>
#include <string>
#include <vector>

#include "heavy_elastica.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::heavy_hose_test {
namespace {

using material_worlds::HeavyElastica;

/// The curvature and force at the first end that a chain at rest tells by the bends of its links.
Vec3 guess(const HeavyElastica& hose, const std::vector<double>& angle, double link) {
  const std::size_t n = angle.size();
  Eigen::MatrixXd matrix(n - 2, 2);
  Eigen::VectorXd right(n - 2);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const auto row = static_cast<Eigen::Index>(k - 1);
    const double s = (static_cast<double>(k) + 0.5) * link;
    matrix.row(row) << std::sin(angle[k]), -std::cos(angle[k]);
    right[row] = hose.stiffness * (angle[k + 1] - 2 * angle[k] + angle[k - 1]) / (link * link) +
                 hose.weight * s * std::cos(angle[k]);
  }
  const Eigen::Vector2d force = matrix.colPivHouseholderQr().solve(right);
  return {(angle[0] - hose.slope) / (link / 2), force.x(), force.y()};
}

/// Newton's method on the place and direction of the last end, by differences.
Vec3 solved(const HeavyElastica& hose, Vec3 unknown, const Vec3& end) {
  for (int i = 0; i < 12; ++i) {
    const Vec3 miss = hose.end(unknown) - end;
    Mat3 jacobian;
    for (int k = 0; k < 3; ++k) {
      const double step = 1e-6 * std::max(1.0, std::abs(unknown[k]));
      jacobian.col(k) = (hose.end(unknown + step * Vec3::Unit(k)) - end - miss) / step;
    }
    unknown -= jacobian.partialPivLu().solve(miss);
  }
  EXPECT_LT((hose.end(unknown) - end).norm(), 1e-9);
  return unknown;
}

/// The largest distance from the elastica of a hose of so many links that has come to rest.
double off(std::size_t links) {
  const scenes::Scene scene = scenes::load_scene(
      std::string(TAUT_SOURCE_DIR) + "/scenes/materials/hose.toml", false,
      {{"connectors.hose.particles", std::to_string(links + 1)}, {"duration", "40"}});
  Simulation simulation(scene.world, make_method("direct", {{"tolerance", 1e-4}}));
  simulation.advance_to(40);
  const Connector& rope = simulation.world().connectors[0];
  const double link = rope.length / static_cast<double>(links);
  // Particles share the mass evenly: between them it is that of a link.
  HeavyElastica hose{rope.sections[0].bending_stiffness, 9.81 * rope.particle_mass[1] / link,
                     rope.length, 0};
  std::vector<double> angle;
  for (std::size_t k = 0; k < links; ++k) {
    const Vec3 way = rope.position[k + 1] - rope.position[k];
    EXPECT_LT(std::abs(rope.position[k + 1].z()), 1e-5);
    double turn = std::atan2(way.y(), way.x());
    const double before = angle.empty() ? 0 : angle.back();
    turn += 2 * std::numbers::pi * std::round((before - turn) / (2 * std::numbers::pi));
    angle.push_back(turn);
  }
  const Vec3 place = rope.position.back() - rope.position.front();
  const double upright = std::numbers::pi / 2;  // as the hand holds it, after whole turns
  const double turns = std::round((angle.back() - upright) / (2 * std::numbers::pi));
  const Vec3 unknown = solved(hose, guess(hose, angle, link),
                              {place.x(), place.y(), upright + 2 * std::numbers::pi * turns});
  double most = 0;
  const int every = HeavyElastica::kSteps / static_cast<int>(links);
  hose.follow(unknown, [&](int step, const HeavyElastica::State& at) {
    if (step % every != 0) return;
    const Vec3 chain = rope.position[static_cast<std::size_t>(step / every)] - rope.position[0];
    most = std::max(most, (chain - Vec3(at[2], at[3], 0)).norm());
  });
  return most;
}

// Of second order in the links, as the elastica of a weight at the end.
TEST(HeavyHose, ComesToRestAsAHeavyElastica) {
  const double coarse = off(44), fine = off(88);
  EXPECT_LT(coarse, 1e-3 * 2.2);
  EXPECT_NEAR(coarse / fine, 4, 0.4);
}

}  // namespace
}  // namespace taut::heavy_hose_test
