#include "sim/methods/direct/sparse_system.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/methods/direct/system/vector.h"

namespace taut::direct {
namespace {

/// A band wider than that goes to the sparse factorisation, which keeps zeros.
constexpr std::size_t kWidest = 96;
/// Rows are swapped where the diagonal entry is below that share of the largest one of its column.
constexpr double kSmallPivot = 0.1;

struct Band {
  std::size_t n = 0, below = 0, height = 0;
  double* values = nullptr;
  std::uint32_t* pivots = nullptr;
  std::size_t above = 0;  // entries of a column of the upper factor, without the diagonal
};

/// LU by columns. Loops have the length `below`, a multiple of kLanes: entries beyond the last row
/// are zero.
template <std::size_t kBelow>
[[gnu::always_inline]] inline bool factorise(Band& band) {
  const std::size_t below = kBelow > 0 ? kBelow : band.below, diagonal = 2 * below;
  const std::size_t n = band.n, height = band.height;
  std::size_t reach = 0;  // the last column that row swaps have filled
  band.above = 0;
  for (std::size_t j = 0; j < n; ++j) {
    double* __restrict column = band.values + j * height + diagonal;
    const double own = std::abs(column[0]), most = largest(below, column + 1);
    std::size_t pivot = 0;
    if (!(own >= kSmallPivot * most)) {
      for (std::size_t i = 1; pivot == 0 && i <= below; ++i) {
        if (std::abs(column[i]) == most) pivot = i;
      }
    }
    if (!(std::max(own, most) > 0)) return false;
    band.pivots[j] = static_cast<std::uint32_t>(j + pivot);
    reach = std::max(reach, std::min(j + below + pivot, n - 1));
    band.above = std::max(band.above, reach - j);
    if (pivot > 0) {
      for (std::size_t k = j; k <= reach; ++k) {
        double* at = band.values + k * height + diagonal + j - k;
        std::swap(at[0], at[pivot]);
      }
    }
    column[0] = 1 / column[0];
    for (std::size_t i = 1; i <= below; ++i) column[i] *= column[0];
    for (std::size_t k = j + 1; k <= reach; ++k) {
      double* __restrict at = band.values + k * height + diagonal + j - k;
      const double factor = at[0];
      if (factor == 0) continue;
      for (std::size_t i = 1; i <= below; ++i) at[i] -= factor * column[i];
    }
  }
  return true;
}

/// Replaces the right side by the solution. Before and behind it there are zeros.
template <std::size_t kBelow>
[[gnu::always_inline]] inline void solve(const Band& band, double* __restrict right) {
  const std::size_t below = kBelow > 0 ? kBelow : band.below, diagonal = 2 * below;
  const std::size_t n = band.n, height = band.height, above = band.above;
  for (std::size_t j = 0; j < n; ++j) {
    std::swap(right[j], right[band.pivots[j]]);
    const double value = right[j];
    if (value == 0) continue;
    const double* __restrict column = band.values + j * height + diagonal;
    double* __restrict at = right + j;
    for (std::size_t i = 1; i <= below; ++i) at[i] -= value * column[i];
  }
  for (std::size_t j = n; j-- > 0;) {
    const double* __restrict column = band.values + j * height + diagonal;
    const double value = right[j] *= column[0];
    if (value == 0) continue;
    double* __restrict at = right + j - above;
    column -= above;
    for (std::size_t i = 0; i < above; ++i) at[i] -= value * column[i];
  }
}

TAUT_VECTOR_CLONES bool factorise_any(Band& band) {
  switch (band.below) {
    case 8:
      return factorise<8>(band);
    case 12:
      return factorise<12>(band);
    case 16:
      return factorise<16>(band);
    case 20:
      return factorise<20>(band);
    default:
      return factorise<0>(band);
  }
}

TAUT_VECTOR_CLONES void solve_any(const Band& band, double* right) {
  switch (band.below) {
    case 8:
      return solve<8>(band, right);
    case 12:
      return solve<12>(band, right);
    case 16:
      return solve<16>(band, right);
    case 20:
      return solve<20>(band, right);
    default:
      return solve<0>(band, right);
  }
}

}  // namespace

void SparseSystem::reshape(std::span<const std::uint32_t> groups) {
  groups_.assign(groups.begin(), groups.end());
  recording_ = true;
  places_.clear();
  recorded_.clear();
}

void SparseSystem::clear() {
  next_ = 0;
  if (recording_) {
    places_.clear();
    recorded_.clear();
  } else {
    std::ranges::fill(values_, 0.0);
  }
}

/// Numbers the unknowns by groups, these by reverse Cuthill-McKee from an end of each component.
void SparseSystem::order() {
  const std::size_t count =
      groups_.empty() ? 0 : std::size_t{*std::ranges::max_element(groups_)} + 1;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::uint32_t last_row = 0, last_column = 0;  // entries of a block follow each other
  for (const Place& place : places_) {
    const std::uint32_t a = groups_[place.row], b = groups_[place.column];
    if (a == b || (a == last_row && b == last_column)) continue;
    last_row = a;
    last_column = b;
    edges.emplace_back(a, b);
    edges.emplace_back(b, a);
  }
  std::vector<std::uint32_t> first(count + 1, 0);
  for (const auto& edge : edges) ++first[edge.first + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<std::uint32_t> neighbours(edges.size()), end(first.begin(), first.end() - 1);
  for (const auto& edge : edges) neighbours[end[edge.first]++] = edge.second;
  for (std::size_t g = 0; g < count; ++g) {  // each once
    const auto begin = neighbours.begin() + first[g];
    std::sort(begin, neighbours.begin() + end[g]);
    end[g] = static_cast<std::uint32_t>(std::unique(begin, neighbours.begin() + end[g]) -
                                        neighbours.begin());
  }
  const auto degree = [&](std::uint32_t g) { return end[g] - first[g]; };
  constexpr std::uint32_t kUnseen = 0xffffffff;
  std::vector<std::uint32_t> level(count, kUnseen), queue;
  /// Appends the component of `from` in breadth-first order; neighbours of low degree first.
  const auto search = [&](std::uint32_t from, std::vector<std::uint32_t>& found) {
    const std::size_t begin = found.size();
    found.push_back(from);
    level[from] = 0;
    for (std::size_t i = begin; i < found.size(); ++i) {
      const std::uint32_t at = found[i];
      const std::size_t added = found.size();
      for (std::uint32_t e = first[at]; e < end[at]; ++e) {
        const std::uint32_t next = neighbours[e];
        if (level[next] != kUnseen) continue;
        level[next] = level[at] + 1;
        found.push_back(next);
      }
      std::ranges::stable_sort(found.begin() + static_cast<std::ptrdiff_t>(added), found.end(), {},
                               degree);
    }
  };
  std::vector<std::uint32_t> sequence;
  for (std::uint32_t g = 0; g < count; ++g) {
    if (level[g] != kUnseen) continue;
    std::uint32_t from = g;
    std::uint32_t depth = 0;
    for (int sweep = 0; sweep < 4; ++sweep) {  // towards an end of the component
      queue.clear();
      search(from, queue);
      const std::uint32_t last = queue.back(), reached = level[last];
      for (const std::uint32_t seen : queue) level[seen] = kUnseen;
      if (sweep > 0 && reached <= depth) break;
      depth = reached;
      from = last;
    }
    search(from, sequence);
  }
  std::ranges::reverse(sequence);
  std::vector<std::uint32_t> rank(count);
  for (std::uint32_t i = 0; i < sequence.size(); ++i) rank[sequence[i]] = i;
  std::vector<std::uint32_t> unknowns(groups_.size());
  std::iota(unknowns.begin(), unknowns.end(), 0u);
  std::ranges::stable_sort(unknowns, {}, [&](std::uint32_t u) { return rank[groups_[u]]; });
  position_.resize(groups_.size());
  for (std::uint32_t i = 0; i < unknowns.size(); ++i) position_[unknowns[i]] = i;
}

void SparseSystem::analyse() {
  order();
  const std::size_t n = size();
  below_ = 0;
  for (const Place& place : places_) {
    const std::size_t i = position_[place.row], j = position_[place.column];
    below_ = std::max(below_, i > j ? i - j : j - i);
  }
  banded_ = below_ <= kWidest;
  slots_.resize(places_.size());
  if (banded_) {
    below_ = std::max((below_ + kLanes - 1) / kLanes * kLanes, 2 * kLanes);
    height_ = 3 * below_ + 1;  // pivoting fills as much again above
    values_.assign(n * height_, 0.0);
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const std::size_t i = position_[places_[k].row], j = position_[places_[k].column];
      slots_[k] = j * height_ + (2 * below_ + i - j);
    }
    pivots_.resize(n);
  } else {
    std::vector<Eigen::Triplet<double, int>> all;
    all.reserve(places_.size());
    for (const Place& place : places_) {
      all.emplace_back(static_cast<int>(place.row), static_cast<int>(place.column), 1.0);
    }
    matrix_.resize(static_cast<int>(n), static_cast<int>(n));
    matrix_.setFromTriplets(all.begin(), all.end());
    matrix_.makeCompressed();
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const int* begin = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[places_[k].column];
      const int* end = matrix_.innerIndexPtr() + matrix_.outerIndexPtr()[places_[k].column + 1];
      const int* at = std::lower_bound(begin, end, static_cast<int>(places_[k].row));
      slots_[k] = static_cast<std::size_t>(at - matrix_.innerIndexPtr());
    }
    values_.assign(static_cast<std::size_t>(matrix_.nonZeros()), 0.0);
    sparse_.analyzePattern(matrix_);
  }
  for (std::size_t k = 0; k < places_.size(); ++k) values_[slots_[k]] += recorded_[k];
  recording_ = false;
  if (banded_) work_.assign(n + 3 * below_, 0.0);
}

bool SparseSystem::factorise() {
  if (recording_) analyse();
  ++factorisations_;
  if (size() == 0) return true;
  if (banded_) return factorise_band();
  std::ranges::copy(values_, matrix_.valuePtr());
  sparse_.factorize(matrix_);
  return sparse_.info() == Eigen::Success;
}

/// The factors stand as LAPACK's dgbtrf has them: the entry (i, j) in column j at 2 below + i - j,
/// with the inverses of the diagonal.
bool SparseSystem::factorise_band() {
  Band band{size(), below_, height_, values_.data(), pivots_.data()};
  if (!factorise_any(band)) return false;
  above_ = (band.above + kLanes - 1) / kLanes * kLanes;
  return true;
}

void SparseSystem::solve_band() {
  Band band{size(), below_, height_, values_.data(), pivots_.data()};
  band.above = above_;
  solve_any(band, work_.data() + 2 * below_);
}

void SparseSystem::solve(std::span<double> right) {
  if (size() == 0) return;
  if (banded_) {
    double* work = work_.data() + 2 * below_;
    for (std::size_t u = 0; u < size(); ++u) work[position_[u]] = right[u];
    solve_band();
    for (std::size_t u = 0; u < size(); ++u) right[u] = work[position_[u]];
    return;
  }
  Eigen::Map<Eigen::VectorXd> at(right.data(), static_cast<Eigen::Index>(right.size()));
  const Eigen::VectorXd solved = sparse_.solve(at);
  at = solved;
}

}  // namespace taut::direct
