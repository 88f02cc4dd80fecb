// Solutions of sparse systems beside dense ones.
#include "sim/methods/direct/sparse_system.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "tests/support/dice.h"

namespace taut::direct::sparse_system_test {
namespace {

/// Particles and constraints between them, whose diagonal is zero. The force of a constraint is of
/// the group of its second particle.
struct Constrained {
  std::vector<std::uint32_t> groups;
  struct Entry {
    std::size_t row, column;
    double value;
  };
  std::vector<Entry> entries;
  std::size_t size() const { return groups.size(); }
};

Constrained particles(std::uint32_t count, Dice& dice) {
  Constrained made;
  for (std::uint32_t p = 0; p < count; ++p) {
    for (std::size_t i = 0; i < 3; ++i) {
      made.groups.push_back(p);
      made.entries.push_back({3 * p + i, 3 * p + i, dice.scale(0.01, 100)});
    }
  }
  return made;
}

void link(std::uint32_t a, std::uint32_t b, const Vec3& way, Dice& dice, Constrained& to) {
  const std::size_t at = to.groups.size();
  to.groups.push_back(b);
  for (std::size_t i = 0; i < 3; ++i) {
    const double by = way[static_cast<int>(i)];
    for (const auto& [end, sign] : {std::pair{a, -1.0}, std::pair{b, 1.0}}) {
      to.entries.push_back({at, 3 * end + i, sign * by});
      to.entries.push_back({3 * end + i, at, -sign * by * dice.between(0.5, 1.5)});
    }
  }
}

Constrained grid(std::uint32_t wide, std::uint32_t high, unsigned seed) {
  Dice dice(seed);
  Constrained made = particles(wide * high, dice);
  for (std::uint32_t j = 0; j < high; ++j) {
    for (std::uint32_t i = 0; i < wide; ++i) {
      const std::uint32_t at = j * wide + i;
      if (i > 0) link(at - 1, at, dice.within(1), dice, made);
      if (j > 0) link(at - wide, at, dice.within(1), dice, made);
    }
  }
  return made;
}

void add(const Constrained& of, double scale, SparseSystem& system) {
  system.clear();
  for (const Constrained::Entry& entry : of.entries) {
    system.add(entry.row, entry.column, scale * entry.value / 2);
    system.add(entry.row, entry.column, scale * entry.value / 2);
  }
}

/// How far the solution is from a dense one, as a share of it.
double error(const Constrained& of, SparseSystem& system, double scale, unsigned seed) {
  const auto n = static_cast<Eigen::Index>(of.size());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  for (const Constrained::Entry& entry : of.entries) {
    dense(static_cast<Eigen::Index>(entry.row), static_cast<Eigen::Index>(entry.column)) +=
        scale * entry.value;
  }
  Dice dice(seed);
  Eigen::VectorXd right(n);
  for (Eigen::Index i = 0; i < n; ++i) right[i] = dice.between(-1, 1);
  const Eigen::VectorXd expected = dense.partialPivLu().solve(right);
  Eigen::VectorXd found = right;
  system.solve({found.data(), of.size()});
  return (found - expected).norm() / expected.norm();
}

TEST(SparseSystem, SolvesChainsAndNetsAsADenseOneDoes) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    for (const auto& [wide, high] : {std::pair{1, 1}, {30, 1}, {4, 4}, {12, 9}, {15, 15}}) {
      const Constrained made =
          grid(static_cast<std::uint32_t>(wide), static_cast<std::uint32_t>(high), seed);
      SparseSystem system;
      system.reshape(made.groups);
      for (const double scale : {1.0, 1e-6, 3.0}) {  // the first assembly finds the places
        add(made, scale, system);
        ASSERT_TRUE(system.factorise()) << seed << ' ' << wide << ' ' << high;
        ASSERT_LT(error(made, system, scale, seed), 1e-9) << seed << ' ' << wide << ' ' << high;
        ASSERT_LT(error(made, system, scale, seed + 1), 1e-9) << "a second right side";
      }
    }
  }
}

TEST(SparseSystem, PivotsThatAreZeroInTheirOwnGroupWait) {
  // Arms of a star: every second particle has two links in one direction, which are alike until
  // the particles at their other ends are eliminated.
  Dice dice(7);
  constexpr std::uint32_t kArms = 60, kLong = 4;
  Constrained made = particles(1 + kArms * kLong, dice);
  for (std::uint32_t arm = 0; arm < kArms; ++arm) {
    const std::uint32_t first = 1 + arm * kLong;
    link(0, first, Vec3::UnitX(), dice, made);
    link(first + 1, first, Vec3::UnitX(), dice, made);
    link(first + 1, first + 2, Vec3::UnitX(), dice, made);
    link(first + 3, first + 2, Vec3::UnitX(), dice, made);
  }
  SparseSystem system;
  system.reshape(made.groups);
  add(made, 1, system);
  ASSERT_TRUE(system.factorise());
  EXPECT_LT(error(made, system, 1, 3), 1e-9);
}

TEST(SparseSystem, TellsSingularMatrices) {
  for (const std::uint32_t high : {1u, 12u}) {
    Constrained made = grid(12, high, 3);
    for (Constrained::Entry& entry : made.entries) {
      if (entry.row == made.size() - 1) entry.value = 0;
    }
    SparseSystem system;
    system.reshape(made.groups);
    add(made, 1, system);
    EXPECT_FALSE(system.factorise());
    add(grid(12, high, 3), 1, system);  // and goes on with others
    EXPECT_TRUE(system.factorise());
  }
}

}  // namespace
}  // namespace taut::direct::sparse_system_test
