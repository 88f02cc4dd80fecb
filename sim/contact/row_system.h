// The linear systems of the rows of links whose particles respond to pulls in ways of their own,
// and ones whose matrix has a narrow band.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sim/contact/body_touch.h"
#include "sim/links/linear_systems.h"
#include "sim/links/mechanism.h"

namespace taut::contact {

/// The ends of rows at free bodies that rows meet in several points; indices into row_ends().
/// `together`, per body: the number of those that may touch each other and count as one; empty:
/// each by itself.
std::vector<std::size_t> ends_that_meet(const Mechanism& mechanism,
                                        std::span<const std::uint32_t> together = {});

/// A x = b over the rows of a mechanism, where A(r, s) says by how much row r stays shorter under a
/// pull along row s. Particle p moves by mobility[p] times what pulls it (1/kg): a multiple of the
/// identity where it is free; less across a surface; not symmetric where it slides with friction.
/// Rows pull along `right` and are measured along `left`, unit vectors. Body b responds to what
/// pulls it, and what pulls those that it touches, as `bodies` says, or freely for null.
///
/// Linear time: elimination along the connectors, and by Woodbury's identity a dense system for the
/// rows that meet in free bodies which have several. A row that nothing can change, or that its
/// neighbours determine already, is left out: its x is zero.
class RowSystem {
 public:
  void rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together = {});

  void assemble(const Mechanism& mechanism, std::span<const Mat3> mobility,
                std::span<const Vec3> left, std::span<const Vec3> right,
                const BodyMobility* bodies = nullptr);
  /// In place.
  void solve(std::span<double> x) const;
  bool left_out(std::size_t row) const { return inverse_pivot_[row] == 0; }

 private:
  void add_bodies(const Mechanism& mechanism, std::span<const Vec3> left,
                  std::span<const Vec3> right, const BodyMobility* bodies);
  void eliminate();
  void sweep(std::span<double> x) const;

  std::vector<double> diagonal_, lower_, upper_, inverse_pivot_;  // 1/kg, kg
  std::vector<double> scale_;                      // 1/kg, of the row's ends as they respond
  std::vector<std::size_t> border_, border_rows_;  // ends of rows at bodies that have several
  std::vector<double> columns_;  // what a pull along each of those rows would take, A without them
  Eigen::MatrixXd coupling_;
  LinearSystem decomposed_;
  mutable Eigen::VectorXd share_, given_;
};

}  // namespace taut::contact
