#include "sim/evaluation/statistics.h"

#include <algorithm>
#include <cmath>

namespace taut::study {
namespace {

/// By how much the share of `a` below some value exceeds that of `b` below a `same` larger one.
double excess(std::span<const double> a, std::span<const double> b, double same) {
  double largest = 0;
  std::size_t below = 0;  // of b
  for (std::size_t i = 0; i < a.size(); ++i) {
    while (below < b.size() && b[below] <= a[i] + same) ++below;
    const double more = static_cast<double>(i + 1) / static_cast<double>(a.size()) -
                        static_cast<double>(below) / static_cast<double>(b.size());
    largest = std::max(largest, more);
  }
  return largest;
}

}  // namespace

void Speeds::add(const std::vector<Vec3>& points, double dt) {
  for (std::size_t i = 0; i < last_.size(); ++i) {
    speeds_.push_back((points[i] - last_[i]).norm() / dt);
  }
  last_ = points;
}

std::vector<double> Speeds::sorted() const {
  std::vector<double> all = speeds_;
  std::ranges::sort(all);
  return all;
}

void EnergyDifference::add(double more) {
  if (!(std::abs(more) <= largest_)) largest_ = std::abs(more);  // keeps what is no number, too
  sum_ += more;
  ++frames_;
}

double EnergyDifference::of_means() const {
  return frames_ > 0 ? std::abs(sum_) / static_cast<double>(frames_) : 0;
}

double distribution_distance(std::span<const double> a, std::span<const double> b, double same) {
  if (a.empty() || b.empty()) return a.empty() == b.empty() ? 0 : 1;
  return std::max(excess(a, b, same), excess(b, a, same));
}

}  // namespace taut::study
