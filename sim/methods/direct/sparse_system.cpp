#include "sim/methods/direct/sparse_system.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace taut::direct {
namespace {

/// A wider band costs more than fronts do.
constexpr std::size_t kWidest = 32;
/// A pivot is at least that share of the largest entry of its column (Duff and Reid).
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

TAUT_VECTOR_CLONES bool factorise_band(Band& band) {
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

TAUT_VECTOR_CLONES void solve_band(const Band& band, double* right) {
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

/// Fronts that eliminate fewer unknowns are joined with their parents, however many zeros that
/// makes; others up to that share of zeros.
constexpr std::uint32_t kNarrow = 16;
constexpr double kMostZeros = 0.1;

/// A dense matrix by columns, in which the first `complete` rows and columns may be eliminated. A
/// column has `stride` rows, a multiple of kLanes; those beyond `size` are zero.
struct Dense {
  double* values = nullptr;
  std::size_t size = 0, stride = 0, complete = 0;
  std::uint32_t *rows = nullptr, *columns = nullptr;
  double* column(std::size_t k) const { return values + k * stride; }
};

std::size_t stride_of(std::size_t size) {
  return (size + kLanes - 1) / kLanes * kLanes;
}

/// The largest |x| of a column from a row on.
[[gnu::always_inline]] inline double largest_from(const Dense& a, const double* column,
                                                  std::size_t from) {
  double most = 0;
  std::size_t i = from;
  for (; i % kLanes != 0; ++i) most = std::max(most, std::abs(column[i]));
  return std::max(most, largest(a.stride - i, column + i));
}

/// Subtracts what the pivots `from` up to `to` (at most four) take from a column.
[[gnu::always_inline]] inline void apply(const Dense& a, std::size_t from, std::size_t to,
                                         double* __restrict at) {
  for (std::size_t p = from; p < to; ++p) {  // rows of the pivots themselves
    const double factor = at[p];
    if (factor == 0) continue;
    const double* by = a.column(p);
    for (std::size_t i = p + 1; i < to; ++i) at[i] -= by[i] * factor;
  }
  const std::size_t n = a.stride;
  if (to - from == 4) {
    const double f0 = at[from], f1 = at[from + 1], f2 = at[from + 2], f3 = at[from + 3];
    if (f0 == 0 && f1 == 0 && f2 == 0 && f3 == 0) return;
    const double* __restrict b0 = a.column(from), * __restrict b1 = a.column(from + 1), * __restrict b2 = a.column(from + 2), * __restrict b3 = a.column(from + 3);
    for (std::size_t i = to; i < n; ++i) {
      at[i] = at[i] - b0[i] * f0 - b1[i] * f1 - b2[i] * f2 - b3[i] * f3;
    }
    return;
  }
  for (std::size_t p = from; p < to; ++p) {
    const double factor = at[p];
    if (factor == 0) continue;
    const double* __restrict by = a.column(p);
    for (std::size_t i = to; i < n; ++i) at[i] -= by[i] * factor;
  }
}

[[gnu::always_inline]] inline void apply_to_all(const Dense& a, std::size_t from, std::size_t to,
                                                std::size_t first) {
  for (std::size_t k = first; k < a.size; ++k) apply(a, from, to, a.column(k));
}

/// Eliminates as many of the complete columns as have pivots; these come first. Returns how many.
TAUT_VECTOR_CLONES std::size_t eliminate(Dense& a) {
  std::size_t pivots = 0, applied = 0;  // pivots that all columns know
  std::size_t end = a.complete;         // columns that have not been tried in vain
  std::size_t tried = 0;                // pivots at the last vain try
  for (;;) {
    if (pivots == end) {
      apply_to_all(a, applied, pivots, pivots);
      applied = pivots;
      if (end == a.complete || pivots == tried) return pivots;
      end = a.complete;  // others have changed since
      tried = pivots;
    }
    double* column = a.column(pivots);
    apply(a, applied, pivots, column);
    const double least = kSmallPivot * largest_from(a, column, pivots);
    std::size_t at = pivots;
    if (!(std::abs(column[at]) >= least)) {
      for (std::size_t i = pivots + 1; i < a.complete; ++i) {
        if (std::abs(column[i]) > std::abs(column[at])) at = i;
      }
    }
    if (!(std::abs(column[at]) >= least && column[at] != 0)) {  // later
      apply_to_all(a, applied, pivots, pivots + 1);
      applied = pivots;
      --end;
      if (end != pivots) {
        double* other = a.column(end);
        std::swap_ranges(column, column + a.stride, other);
        std::swap(a.columns[pivots], a.columns[end]);
      }
      continue;
    }
    if (at != pivots) {
      for (std::size_t k = 0; k < a.size; ++k) std::swap(a.column(k)[pivots], a.column(k)[at]);
      std::swap(a.rows[pivots], a.rows[at]);
    }
    const double inverse = 1 / column[pivots];
    column[pivots] = inverse;
    for (std::size_t i = pivots + 1; i < a.stride; ++i) column[i] *= inverse;
    ++pivots;
    if (pivots - applied == 4) {
      apply_to_all(a, applied, pivots, pivots);
      applied = pivots;
    }
  }
}

/// Solves with the lower factor: `at` has all rows of a front.
TAUT_VECTOR_CLONES void lower(std::size_t stride, std::size_t pivots, const double* column,
                              double* __restrict at) {
  for (std::size_t p = 0; p < pivots; ++p, column += stride) {
    const double value = at[p];
    if (value == 0) continue;
    const double* __restrict by = column;
    for (std::size_t i = p + 1; i < stride; ++i) at[i] -= by[i] * value;
  }
}

/// Solves with the upper factor, from the values of the other columns; pivots are inverse.
TAUT_VECTOR_CLONES void upper(std::size_t size, std::size_t stride, std::size_t pivots,
                              const double* factors, const double* others, double* __restrict at) {
  const double* __restrict by = factors + pivots * stride;
  for (std::size_t k = pivots; k < size; ++k, by += pivots) {
    const double value = others[k];
    if (value == 0) continue;
    for (std::size_t i = 0; i < pivots; ++i) at[i] -= by[i] * value;
  }
  for (std::size_t k = pivots; k-- > 0;) {
    const double* __restrict own = factors + k * stride;
    const double value = at[k] *= own[k];
    for (std::size_t i = 0; i < k; ++i) at[i] -= own[i] * value;
  }
}

}  // namespace

/// Numbers the unknowns by groups, these by reverse Cuthill-McKee from an end of each component.
void BandLu::order(std::span<const std::uint32_t> groups, std::span<const MatrixPlace> places) {
  const std::size_t count = groups.empty() ? 0 : std::size_t{*std::ranges::max_element(groups)} + 1;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::uint32_t last_row = 0, last_column = 0;  // entries of a block follow each other
  for (const MatrixPlace& place : places) {
    const std::uint32_t a = groups[place.row], b = groups[place.column];
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
  std::vector<std::uint32_t> unknowns(groups.size());
  std::iota(unknowns.begin(), unknowns.end(), 0u);
  std::ranges::stable_sort(unknowns, {}, [&](std::uint32_t u) { return rank[groups[u]]; });
  position_.resize(groups.size());
  for (std::uint32_t i = 0; i < unknowns.size(); ++i) position_[unknowns[i]] = i;
}

void BandLu::analyse(std::span<const std::uint32_t> groups, std::span<const MatrixPlace> places) {
  order(groups, places);
  below_ = 0;
  for (const MatrixPlace& place : places) {
    const std::size_t i = position_[place.row], j = position_[place.column];
    below_ = std::max(below_, i > j ? i - j : j - i);
  }
  if (below_ > kWidest) return;
  below_ = std::max((below_ + kLanes - 1) / kLanes * kLanes, 2 * kLanes);
  height_ = 3 * below_ + 1;  // pivoting fills as much again above
  slots_.resize(places.size());
  for (std::size_t k = 0; k < places.size(); ++k) {
    const std::size_t i = position_[places[k].row], j = position_[places[k].column];
    slots_[k] = j * height_ + (2 * below_ + i - j);
  }
  band_.resize(groups.size() * height_);
  pivots_.resize(groups.size());
  work_.assign(groups.size() + 3 * below_, 0.0);
}

/// The factors stand as LAPACK's dgbtrf has them: the entry (i, j) in column j at 2 below + i - j,
/// with the inverses of the diagonal.
bool BandLu::factorise(std::span<const double> values) {
  std::ranges::fill(band_, 0.0);
  for (std::size_t k = 0; k < values.size(); ++k) band_[slots_[k]] += values[k];
  Band band{position_.size(), below_, height_, band_.data(), pivots_.data()};
  if (!factorise_band(band)) return false;
  above_ = (band.above + kLanes - 1) / kLanes * kLanes;
  return true;
}

void BandLu::solve(std::span<double> right) {
  Band band{position_.size(), below_, height_, band_.data(), pivots_.data()};
  band.above = above_;
  double* work = work_.data() + 2 * below_;
  for (std::size_t u = 0; u < right.size(); ++u) work[position_[u]] = right[u];
  solve_band(band, work);
  for (std::size_t u = 0; u < right.size(); ++u) right[u] = work[position_[u]];
}

/// Orders the groups, finds the fronts, and where each entry goes.
void FrontLu::analyse(std::span<const std::uint32_t> groups, std::span<const MatrixPlace> places) {
  size_ = groups.size();
  const std::size_t n = size_;
  const std::size_t count = n == 0 ? 0 : std::size_t{*std::ranges::max_element(groups)} + 1;
  std::vector<std::vector<std::uint32_t>> members(count), ties(count);
  for (std::uint32_t u = 0; u < n; ++u) members[groups[u]].push_back(u);
  std::uint32_t last_row = 0, last_column = 0;  // entries of a block follow each other
  for (const MatrixPlace& place : places) {
    const std::uint32_t a = groups[place.row], b = groups[place.column];
    if (a == b || (a == last_row && b == last_column)) continue;
    last_row = a;
    last_column = b;
    ties[a].push_back(b);
    ties[b].push_back(a);
  }
  for (auto& of : ties) {
    std::ranges::sort(of);
    const auto again = std::ranges::unique(of);
    of.erase(again.begin(), again.end());
  }
  // The order of elimination.
  std::vector<std::uint32_t> order(count), rank(count);
  {
    Eigen::SparseMatrix<double> graph(static_cast<int>(count), static_cast<int>(count));
    std::vector<Eigen::Triplet<double>> all;
    for (std::uint32_t g = 0; g < count; ++g) {
      all.emplace_back(static_cast<int>(g), static_cast<int>(g), 1.0);
      for (const std::uint32_t other : ties[g]) {
        all.emplace_back(static_cast<int>(g), static_cast<int>(other), 1.0);
      }
    }
    graph.setFromTriplets(all.begin(), all.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> by;
    Eigen::AMDOrdering<int>()(graph, by);
    for (std::size_t i = 0; i < count; ++i) {
      order[i] = static_cast<std::uint32_t>(by.indices()[static_cast<int>(i)]);
      rank[order[i]] = static_cast<std::uint32_t>(i);
    }
  }
  // Groups by rank from here on. Those that a group touches when it is eliminated are the later
  // ones of its ties and of its children's.
  struct Part {
    std::vector<std::uint32_t> own, rest;  // groups
    std::uint32_t own_size = 0, rest_size = 0, parent = kNone;
    std::vector<std::uint32_t> children;
    bool joined = false;
  };
  std::vector<Part> parts(count);
  const auto size_of = [&](std::uint32_t g) {
    return static_cast<std::uint32_t>(members[order[g]].size());
  };
  for (std::uint32_t g = 0; g < count; ++g) {
    Part& part = parts[g];
    for (const std::uint32_t tie : ties[order[g]]) {
      if (rank[tie] > g) part.rest.push_back(rank[tie]);
    }
    for (const std::uint32_t child : part.children) {
      for (const std::uint32_t other : parts[child].rest) {
        if (other > g) part.rest.push_back(other);
      }
    }
    std::ranges::sort(part.rest);
    const auto again = std::ranges::unique(part.rest);
    part.rest.erase(again.begin(), again.end());
    part.own = {g};
    part.own_size = size_of(g);
    for (const std::uint32_t other : part.rest) part.rest_size += size_of(other);
    if (part.rest.empty()) continue;
    part.parent = part.rest.front();
    parts[part.parent].children.push_back(g);
  }
  // A group joins its parent's front where that makes few zeros.
  for (std::uint32_t g = 0; g < count; ++g) {
    Part& part = parts[g];
    if (part.parent == kNone) continue;
    Part& parent = parts[part.parent];
    const double zeros =
        double(part.own_size) * (double(parent.own_size) + parent.rest_size - part.rest_size);
    const double joined = double(part.own_size) + parent.own_size;
    const double all = joined * (joined + 2 * double(parent.rest_size));
    if (joined > kNarrow && 2 * zeros > kMostZeros * all) continue;
    part.joined = true;
    parent.own.insert(parent.own.begin(), part.own.begin(), part.own.end());
    parent.own_size += part.own_size;
    std::erase(parent.children, g);
    parent.children.insert(parent.children.end(), part.children.begin(), part.children.end());
    for (const std::uint32_t child : part.children) parts[child].parent = part.parent;
  }
  // Children before their parents, one subtree after the other.
  fronts_.clear();
  own_.clear();
  rest_.clear();
  in_parent_.clear();
  std::vector<std::uint32_t> front_of(n), place_of(n), made(count, kNone);
  std::vector<std::vector<std::uint32_t>> children_of;  // fronts
  const auto make = [&](std::uint32_t g) {
    const Part& part = parts[g];
    Front front;
    front.children = static_cast<std::uint32_t>(part.children.size());
    front.own = static_cast<std::uint32_t>(own_.size());
    for (const std::uint32_t one : part.own) {
      for (const std::uint32_t u : members[order[one]]) {
        front_of[u] = static_cast<std::uint32_t>(fronts_.size());
        place_of[u] = static_cast<std::uint32_t>(own_.size()) - front.own;
        own_.push_back(u);
      }
    }
    front.own_end = static_cast<std::uint32_t>(own_.size());
    front.rest = static_cast<std::uint32_t>(rest_.size());
    for (const std::uint32_t one : part.rest) {
      rest_.insert(rest_.end(), members[order[one]].begin(), members[order[one]].end());
    }
    front.rest_end = static_cast<std::uint32_t>(rest_.size());
    children_of.emplace_back();
    for (const std::uint32_t child : part.children) {
      fronts_[made[child]].parent = static_cast<std::uint32_t>(fronts_.size());
      children_of.back().push_back(made[child]);
    }
    made[g] = static_cast<std::uint32_t>(fronts_.size());
    fronts_.push_back(front);
  };
  std::vector<std::pair<std::uint32_t, std::size_t>> path;  // a part and its next child
  for (std::uint32_t root = 0; root < count; ++root) {
    if (parts[root].parent != kNone) continue;
    path.emplace_back(root, 0);
    while (!path.empty()) {
      auto& [g, next] = path.back();
      if (next < parts[g].children.size()) {
        path.emplace_back(parts[g].children[next++], 0);
      } else {
        make(g);
        path.pop_back();
      }
    }
  }
  // Places of unknowns in a front: own ones, then the rest.
  std::vector<std::uint32_t> in_rest(n, kNone);
  const auto place_in = [&](std::uint32_t f, std::uint32_t u) {
    return front_of[u] == f ? place_of[u] : fronts_[f].own_size() + in_rest[u];
  };
  const auto front_at = [&](const MatrixPlace& place) {
    return std::min(front_of[place.row], front_of[place.column]);
  };
  std::vector<std::uint32_t> next(fronts_.size() + 1, 0), of_front(places.size());
  for (const MatrixPlace& place : places) ++next[front_at(place) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  for (std::uint32_t f = 0; f < fronts_.size(); ++f) {
    fronts_[f].entry = next[f];
    fronts_[f].entry_end = next[f + 1];
  }
  for (std::uint32_t k = 0; k < places.size(); ++k) of_front[next[front_at(places[k])]++] = k;
  in_parent_.resize(rest_.size());
  entries_.clear();
  for (std::uint32_t f = 0; f < fronts_.size(); ++f) {
    const Front& front = fronts_[f];
    for (std::uint32_t r = front.rest; r < front.rest_end; ++r) in_rest[rest_[r]] = r - front.rest;
    for (const std::uint32_t child : children_of[f]) {
      for (std::uint32_t r = fronts_[child].rest; r < fronts_[child].rest_end; ++r) {
        in_parent_[r] = place_in(f, rest_[r]);
      }
    }
    const std::size_t stride = stride_of(front.own_size() + front.rest_size());
    for (std::uint32_t e = front.entry; e < front.entry_end; ++e) {
      const MatrixPlace& place = places[of_front[e]];
      const std::size_t at = place_in(f, place.column) * stride + place_in(f, place.row);
      entries_.push_back({of_front[e], static_cast<std::uint32_t>(at)});
    }
  }
}

bool FrontLu::factorise(std::span<const double> values) {
  left_.clear();
  left_values_.clear();
  left_rows_.clear();
  left_columns_.clear();
  factors_.clear();
  rows_.clear();
  columns_.clear();
  for (std::uint32_t f = 0; f < fronts_.size(); ++f) {
    Front& front = fronts_[f];
    const std::size_t first_child = left_.size() - front.children;
    std::uint32_t waiting = 0;  // of the children
    for (std::size_t c = first_child; c < left_.size(); ++c) waiting += left_[c].waiting;
    const std::uint32_t own = front.own_size(), rest = front.rest_size();
    const std::uint32_t complete = own + waiting, size = complete + rest;
    // Columns that wait stand between the front's own ones and the rest.
    const auto place = [&](std::uint32_t at) { return at < own ? at : at + waiting; };
    front.index = rows_.size();
    front.factors = factors_.size();
    front.size = size;
    rows_.insert(rows_.end(), own_.begin() + front.own, own_.begin() + front.own_end);
    columns_.insert(columns_.end(), own_.begin() + front.own, own_.begin() + front.own_end);
    const std::size_t stride = stride_of(size);
    factors_.resize(front.factors + size * stride);
    double* const matrix = factors_.data() + front.factors;
    const std::span entries(entries_.data() + front.entry, front.entry_end - front.entry);
    if (waiting == 0) {
      for (const Entry& entry : entries) matrix[entry.at] += values[entry.value];
    } else {
      const auto narrow = static_cast<std::uint32_t>(stride_of(own + rest));
      for (const Entry& entry : entries) {
        const std::uint32_t column = entry.at / narrow, row = entry.at % narrow;
        matrix[place(column) * stride + place(row)] += values[entry.value];
      }
    }
    std::uint32_t next = own;
    for (std::size_t c = first_child; c < left_.size(); ++c) {
      const Left& left = left_[c];
      const Front& child = fronts_[left.front];
      const std::size_t left_size = left.waiting + child.rest_size();
      where_.resize(left_size);
      for (std::uint32_t i = 0; i < left.waiting; ++i) {
        rows_.push_back(left_rows_[left.index + i]);
        columns_.push_back(left_columns_[left.index + i]);
        where_[i] = next++;
      }
      for (std::uint32_t r = 0; r < child.rest_size(); ++r) {
        where_[left.waiting + r] = place(in_parent_[child.rest + r]);
      }
      const double* from = left_values_.data() + left.values;
      for (std::size_t k = 0; k < left_size; ++k, from += left_size) {
        double* to = matrix + where_[k] * stride;
        for (std::size_t i = 0; i < left_size; ++i) to[where_[i]] += from[i];
      }
    }
    if (front.children > 0) {
      left_values_.resize(left_[first_child].values);
      left_rows_.resize(left_[first_child].index);
      left_columns_.resize(left_[first_child].index);
      left_.resize(first_child);
    }
    rows_.insert(rows_.end(), rest_.begin() + front.rest, rest_.begin() + front.rest_end);
    columns_.insert(columns_.end(), rest_.begin() + front.rest, rest_.begin() + front.rest_end);
    Dense dense{
        matrix, size, stride, complete, rows_.data() + front.index, columns_.data() + front.index};
    const std::size_t pivots = eliminate(dense);
    front.pivots = static_cast<std::uint32_t>(pivots);
    if (front.parent == kNone && pivots < complete) return false;
    if (front.parent != kNone) {
      left_.push_back({f, static_cast<std::uint32_t>(complete - pivots), left_values_.size(),
                       left_rows_.size()});
      for (std::size_t k = pivots; k < size; ++k) {
        left_values_.insert(left_values_.end(), dense.column(k) + pivots, dense.column(k) + size);
      }
      left_rows_.insert(left_rows_.end(), dense.rows + pivots, dense.rows + complete);
      left_columns_.insert(left_columns_.end(), dense.columns + pivots, dense.columns + complete);
    }
    double* upper = dense.column(pivots);  // rows of the pivots move up
    for (std::size_t k = pivots; k < size; ++k, upper += pivots) {
      std::copy(dense.column(k), dense.column(k) + pivots, upper);
    }
    factors_.resize(static_cast<std::size_t>(upper - factors_.data()));
  }
  return true;
}

void FrontLu::solve(std::span<double> right) {
  pivot_values_.resize(size_);
  std::size_t first = 0;  // of a front's pivots
  for (const Front& front : fronts_) {
    const std::size_t stride = stride_of(front.size);
    work_.assign(stride, 0.0);
    const std::uint32_t* rows = rows_.data() + front.index;
    const double* column = factors_.data() + front.factors;
    double* work = work_.data();
    for (std::size_t i = 0; i < front.size; ++i) work[i] = right[rows[i]];
    lower(stride, front.pivots, column, work);
    for (std::size_t i = 0; i < front.pivots; ++i) pivot_values_[first + i] = work[i];
    for (std::size_t i = front.pivots; i < front.size; ++i) right[rows[i]] = work[i];
    first += front.pivots;
  }
  for (std::size_t f = fronts_.size(); f-- > 0;) {
    const Front& front = fronts_[f];
    first -= front.pivots;
    work_.resize(front.size);
    const std::uint32_t* columns = columns_.data() + front.index;
    double* values = pivot_values_.data() + first;
    for (std::size_t i = front.pivots; i < front.size; ++i) work_[i] = right[columns[i]];
    upper(front.size, stride_of(front.size), front.pivots, factors_.data() + front.factors,
          work_.data(), values);
    for (std::size_t i = 0; i < front.pivots; ++i) right[columns[i]] = values[i];
  }
}

void SparseSystem::reshape(std::span<const std::uint32_t> groups) {
  groups_.assign(groups.begin(), groups.end());
  recording_ = true;
}

void SparseSystem::clear() {
  next_ = 0;
  if (!recording_) return;
  places_.clear();
  values_.clear();
}

bool SparseSystem::factorise() {
  if (recording_) {
    recording_ = false;
    band_.analyse(groups_, places_);
    banded_ = band_.width() <= kWidest;
    if (!banded_) fronts_.analyse(groups_, places_);
  }
  ++factorisations_;
  if (size() == 0) return true;
  return banded_ ? band_.factorise(values_) : fronts_.factorise(values_);
}

void SparseSystem::solve(std::span<double> right) {
  if (size() == 0) return;
  banded_ ? band_.solve(right) : fronts_.solve(right);
}

}  // namespace taut::direct
