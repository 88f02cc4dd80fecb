// The tensions of connectors that are joined.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/links/sparse_ldlt.h"

namespace taut {

/// TensionSystem's A = J M^-1 J^T where rows of many connectors meet: sparse, in time that is
/// linear in the number of rows of a tree and about its power 1.5 in a net.
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
  /// The share in values_[value] of two rows with a common particle, or two ends at a free body.
  struct PointTerm {
    std::uint32_t row = 0, other = 0, value = 0, point = 0;
    double sign = 0;
  };
  struct BodyTerm {
    std::uint32_t end = 0, other = 0, value = 0;
    double times = 1;
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

}  // namespace taut
