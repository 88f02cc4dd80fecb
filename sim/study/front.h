// Cost against error: which settings are worth their price.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace taut::study {

struct CostAndError {
  double cost = 0;   // CPU seconds per simulated second
  double error = 0;  // not finite: the run gave none
};

/// The points that no other beats in both, by rising cost.
std::vector<std::size_t> pareto_front(std::span<const CostAndError> points);

/// The cheapest point whose error is at most `error`.
std::optional<std::size_t> cheapest(std::span<const CostAndError> points, double error);

/// The cost of an error of `error` along the front: between the two points on either side of it, on
/// a straight line of their logarithms. Where even the cheapest is nearer: its cost. None where the
/// front does not reach it.
std::optional<double> cost_at(std::span<const CostAndError> points, double error);

/// Median of `values`, the quartiles around it and the ends; zero where there are none.
struct Spread {
  double least = 0, low = 0, median = 0, high = 0, most = 0;
};
Spread spread(std::vector<double> values);

}  // namespace taut::study
