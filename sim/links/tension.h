// Tensions of links: the linear systems of all rows at once, the pull at winches, the projection of
// a state onto its links, and Coulomb friction at pulleys.
#pragma once

#include <Eigen/Cholesky>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "sim/links/linear_systems.h"
#include "sim/links/mechanism.h"
#include "sim/world/world.h"

namespace taut {

/// The share in the number `value` of a system's matrix of two ends, of Mechanism::row_ends(), at
/// one free body.
struct BodyTerm {
  std::uint32_t end = 0, other = 0, value = 0;
  double times = 1;
};

/// The tensions of connectors that are joined: TensionSystem's A = J M^-1 J^T where rows of many
/// connectors meet: sparse, in time that is linear in the number of rows of a tree and about its
/// power 1.5 in a net.
class JoinedTension {
 public:
  void rebuild(const Mechanism& mechanism);
  void assemble(const Mechanism& mechanism);
  /// Solves A x = `right`; rows that depend on others have the tension zero, which moves what all
  /// of them together would where `right` agrees with them. False where there are any.
  bool solve(const std::vector<double>& right, std::vector<double>& x);

  /// The multiplications of one elimination.
  double products() const { return ldlt_.products(); }
  /// The cycles (see Counters::cycles) of assemble() and solve().
  double cycles() const {
    return 25 * static_cast<double>(values_.size()) + 4 * ldlt_.products() +
           8 * static_cast<double>(ldlt_.entries());
  }

 private:
  /// The share in values_[value] of two rows with a common particle.
  struct PointTerm {
    std::uint32_t row = 0, other = 0, value = 0, point = 0;
    double sign = 0;
  };
  void find_point_terms(const Mechanism& mechanism);
  void find_body_terms(const Mechanism& mechanism);
  void find_pattern();

  std::size_t rows_ = 0;
  std::vector<PointTerm> point_terms_;
  std::vector<BodyTerm> body_terms_;
  std::vector<std::uint32_t> row_of_end_;  // of Mechanism::row_ends()
  std::vector<double> values_;             // the rows' diagonal, then their couplings
  SparseLdlt ldlt_;
};

/// A = J M^-1 J^T over the rows of a mechanism, at the instant that the mechanism was updated to
/// last. Under tensions T (N) the second derivatives of the rows' violation are (their value
/// without tensions) - A T.
///
/// Rows of a connector couple with their neighbours alone, so A is tridiagonal, but for a border:
/// links without length, and the rows at a free body that carries more than one point. Where
/// connectors are joined, A is sparse (JoinedTension).
///
/// Pulleys stand in the border, too, with a row of each connector that passes one: with their
/// couplings C and inertia S (Mechanism) the matrix is [A, -C; -C^T, -S], which is not definite,
/// and symmetric without friction; A alone may be singular there (ThresholdElimination).
class TensionSystem {
 public:
  TensionSystem() = default;
  explicit TensionSystem(const Mechanism& mechanism) { rebuild(mechanism); }

  /// Finds out how the rows of `mechanism` couple; makes as much room as that has.
  void rebuild(const Mechanism& mechanism);

  void assemble(const Mechanism& mechanism);

  /// Solves A x = `right` in linear time: elimination along the connectors (Thomas), then a dense
  /// system of the border's rows. False where a pivot vanishes: A is singular and x unusable.
  bool solve_banded(const std::vector<double>& right, std::vector<double>& x);

  /// Solves A x = `right` through a rank-revealing decomposition of the whole matrix, in cubic
  /// time. Where A is singular: the x of least norm among those that come closest.
  void solve_dense(const std::vector<double>& right, std::vector<double>& x);

  /// solve_banded(), or where that cannot, as solve_dense(): each block of rows that couple by
  /// itself, so that one which is singular costs no others anything. True where solve_banded()
  /// solved it. Of joined connectors JoinedTension solves all.
  bool solve(const std::vector<double>& right, std::vector<double>& x);

  /// The cycles (see Counters::cycles) of assemble(), a right side and solve(), in linear time: a
  /// row takes 25 additions and multiplications, two divisions, and in the elimination a division
  /// and seven operations that wait for each other; a border row sweeps a column of its own.
  double cycles() const {
    if (is_joined_) return joined_.cycles();
    const auto rows = static_cast<double>(rows_), border = static_cast<double>(border_.size());
    return 63 * rows + border * (20 * rows + 50) + border * border * border / 3;
  }
  /// Of solve_dense() in place of solve(): 4/3 n^3 additions and multiplications in the
  /// decomposition, whose columns change places.
  double dense_cycles() const {
    const auto rows = static_cast<double>(rows_);
    return rows * (450 + 1.5 * rows * rows);
  }

  /// A as a full matrix, 1/kg.
  const Eigen::MatrixXd& dense();

 private:
  /// An entry of A off its diagonals; `value` and `transposed`, A(other, row), index values_. These
  /// differ in rows of pulleys, where friction may be.
  struct Entry {
    std::uint32_t row = 0, other = 0, value = 0, transposed = 0;
  };
  /// The share in values_[value] of two row ends with a common particle.
  struct PointTerm {
    std::uint32_t row = 0, other = 0, value = 0;
    double weight = 0;  // 1/kg, signed
  };

  // A pivot this small beside what it was made from is rounding: A is singular.
  static constexpr double kSingular = 1e-12;

  std::uint32_t entry(const Mechanism& mechanism, std::size_t row, std::size_t other);
  void find_terms(const Mechanism& mechanism);
  void find_border(const Mechanism& mechanism);
  void add_to_border(std::size_t row);
  void solve_border();
  void find_blocks();
  void solve_blocks(const std::vector<double>& right, std::vector<double>& x);
  void solve_block(std::span<const std::uint32_t> rows, std::span<const std::uint32_t> entries,
                   const std::vector<double>& right, std::vector<double>& x);
  bool eliminate();
  struct RowSpan {
    std::size_t from = 0, until = 0;
    bool has(std::size_t row) const { return row >= from && row < until; }
  };
  void sweep(RowSpan span, double* x) const;
  double next(std::size_t row) const;  // A(row, row + 1), zero at the border

  std::size_t rows_ = 0;     // pulleys behind them
  std::size_t pulleys_ = 0;  // of these
  bool is_joined_ = false;
  JoinedTension joined_;
  // Into values_: as Mechanism::couplings(), and pairs of pulleys, row by row.
  std::vector<std::uint32_t> couplings_, pulley_pairs_;
  std::vector<double> values_;  // [ diagonal | A(r, r+1) | entries ], 1/kg
  std::vector<Entry> entries_;
  std::map<std::pair<std::size_t, std::size_t>, std::uint32_t> entry_at_;  // by row and other
  std::vector<PointTerm> point_terms_;
  std::vector<BodyTerm> body_terms_;

  static constexpr std::uint32_t kInside = 0xffffffff;
  std::vector<std::uint32_t> border_index_;  // per row: its place in the border, or kInside
  std::vector<std::uint32_t> border_;        // rows
  std::vector<Entry> border_entries_;        // every entry of a border row

  std::vector<std::uint32_t> block_;               // per row: the first of its block
  std::vector<std::uint32_t> block_rows_, place_;  // sorted by blocks; of a row in its block
  std::vector<std::uint32_t> block_entries_;       // indices into entries_, sorted by blocks
  std::vector<double> inverse_pivot_, factor_;
  std::vector<double> columns_;        // one of rows_ numbers per border row
  std::vector<RowSpan> column_spans_;  // per border row: where its column is not zero
  Eigen::MatrixXd schur_, dense_;
  Eigen::VectorXd border_x_, dense_right_;
  Eigen::LDLT<Eigen::MatrixXd> border_solver_;
  ThresholdElimination pulley_solver_;  // of the border where there are pulleys, as scaled
  Eigen::VectorXd scale_, scaled_right_, residual_;
  LeastSquares dense_solver_;
};

// The pull of a rope at the winch that pays it out.

/// The tension (N) at the drum of the winch at a connector's first (0) or last (1) end, with the
/// world's motion as it is: the load of the drum's brake or motor, the inertia of the drum and of
/// rope still wound on it aside. Solves for all tensions of the world. Positive where the rope
/// pulls. sim/winch/README.md has the equation. Throws std::invalid_argument without such a winch.
double winch_tension(const World& world, std::size_t connector, std::size_t end);

// Putting a state onto its links: positions so that all have their lengths, velocities so that none
// changes it.

/// Projects states of one mechanism along M^-1 J^T, which moves as little as it takes, all masses
/// counted. Both change linear momentum only by what holds give, which act at their points.
class Projection {
 public:
  /// Lengths that stay off by more (m) cannot be kept.
  static constexpr double kKept = 1e-8;

  /// The remaining violation of the rows; not finite where the state was not.
  struct Left {
    double violation = 0;  // m, the largest
    std::size_t row = 0;   // where that is
  };

  Projection() = default;
  explicit Projection(const Mechanism& mechanism) { rebuild(mechanism); }

  /// Makes room for the mechanism, and as much as that has.
  void rebuild(const Mechanism& mechanism);

  /// Newton's method on the lengths, to rounding where they can be kept.
  Left lengths(Mechanism& mechanism, double time, std::vector<double>& state);

  /// The impulses that stop all links from changing their length.
  void rates(Mechanism& mechanism, double time, std::vector<double>& state);

 private:
  const std::vector<double>& right_side(const std::vector<double>& rows);

  TensionSystem system_;
  std::vector<double> multiplier_;  // per row: kg m or N s
  std::vector<double> right_;       // where there are pulleys
};

/// Gives all links of `world` their lengths, whatever moves for it: particles and free bodies.
/// False, and nothing has changed, where holds do not let them.
bool restore_lengths(World& world);

/// Whether velocities change the length of some link by more than rounding; held particles are
/// where they are placed.
bool stretches(const World& world);

/// Changes the velocities of a world by the impulses that stop all links from changing their
/// length, as when a moving particle is pinned. Keeps its workspace.
class VelocityProjection {
 public:
  void stop(World& world);

 private:
  Mechanism mechanism_;
  Projection projection_;
  std::vector<double> state_;
};

// Coulomb's friction at pulleys: at which of them rope slides, and when that changes.

/// An integrator decides at a state what each pulley does, keeps that through a step, and measures
/// how far the next change is at its end. A step that goes beyond one is to be tried again,
/// shorter, until it ends within kNear of it. Rope that stays has a speed of exactly zero.
class PulleyFriction {
 public:
  /// Makes as much room as `mechanism` has.
  void rebuild(const Mechanism& mechanism);
  /// Whether any pulley has friction.
  bool any() const { return any_; }

  /// Lets rope stay, slide or push where it does from this state on; sets speeds within kNear of
  /// zero to zero.
  void decide(Mechanism& mechanism, TensionSystem& system, double time, std::vector<double>& state);
  /// The distance to the nearest change: m/s of a rope that slides, or of tensions as shares of
  /// their sum. Below zero: beyond it.
  double distance(Mechanism& mechanism, TensionSystem& system, double time,
                  std::vector<double>& state);
  /// The share of a step after which to look for the change that lies between these distances.
  static double share(double before, double behind);

  static constexpr double kNear = 1e-10;

 private:
  void solve(Mechanism& mechanism, TensionSystem& system, double time, std::vector<double>& state);

  bool any_ = false;
  std::vector<double> right_, tension_;
};

}  // namespace taut
