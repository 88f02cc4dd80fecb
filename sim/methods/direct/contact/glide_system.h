// Newton's equations of the first stage of a step at obstacles.
#pragma once

#include <span>
#include <vector>

#include "sim/contact/band_system.h"
#include "sim/contact/body_mobility.h"
#include "sim/links/dense.h"
#include "sim/links/mechanism.h"

namespace taut::direct {

/// How the points and rows of a mechanism respond to small changes of the points' velocities v
/// (m/s, mean over the step) and the rows' impulses (N s). Ordered by points (a point's velocity,
/// then the rows that begin there) the system has a narrow band. Bodies that rows meet in several
/// points couple these, by Woodbury's identity.
class GlideSystem {
 public:
  /// The terms of the equations, per point and per row.
  struct Terms {
    double h = 0;                     // s
    std::span<const Mat3> mobility;   // 1/kg: of a point to what pulls it
    std::span<const Mat3> bend;       // 1: to its own displacement over h, as surfaces curve
    std::span<const Mat3> turn;       // N s/m: of a row's impulse with the way from a to b
    std::span<const Vec3> along, to;  // of the row's pull; in which its length grows
    /// Of bodies to what pulls them; null: freely.
    const contact::BodyMobility* bodies = nullptr;
  };

  /// `together`: see contact::ends_that_meet().
  void rebuild(const Mechanism& mechanism, std::span<const std::uint32_t> together = {});
  void assemble(const Mechanism& mechanism, const Terms& terms);
  /// In: by how much each point is slower than its response, and each row grows too slowly (m/s).
  /// Out: what to add to velocities and impulses.
  void solve(std::span<Vec3> velocity, std::span<double> impulse);

 private:
  void add_row(const Mechanism& mechanism, const Terms& terms, std::size_t row);
  void add_bodies(const Mechanism& mechanism, const Terms& terms);

  std::vector<std::size_t> first_;  // per point: its velocity's first unknown
  std::vector<std::size_t> row_;    // per row: its unknown
  std::size_t size_ = 0, half_ = 0;
  contact::BandSystem band_;
  std::vector<double> values_;
  std::vector<std::size_t> border_, border_rows_;  // ends of rows at bodies that have several
  std::vector<double> columns_;  // what a pull along each of those rows does through others
  LinearSystem decomposed_;
  Eigen::VectorXd found_, share_;
};

}  // namespace taut::direct
