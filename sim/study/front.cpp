#include "sim/study/front.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace taut::study {

std::vector<std::size_t> pareto_front(std::span<const CostAndError> points) {
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, [&](std::size_t a, std::size_t b) {
    return points[a].cost != points[b].cost ? points[a].cost < points[b].cost
                                            : points[a].error < points[b].error;
  });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order) {
    if (!(points[i].error < best)) continue;
    best = points[i].error;
    front.push_back(i);
  }
  return front;
}

std::optional<std::size_t> cheapest(std::span<const CostAndError> points, double error) {
  std::optional<std::size_t> found;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(points[i].error <= error)) continue;
    if (!found || points[i].cost < points[*found].cost) found = i;
  }
  return found;
}

std::optional<double> cost_at(std::span<const CostAndError> points, double error) {
  const std::vector<std::size_t> front = pareto_front(points);
  for (std::size_t i = 0; i < front.size(); ++i) {
    const CostAndError& fine = points[front[i]];
    if (fine.error > error) continue;
    if (i == 0 || fine.error == error) return fine.cost;
    const CostAndError& coarse = points[front[i - 1]];
    const double share = std::log(coarse.error / error) / std::log(coarse.error / fine.error);
    return coarse.cost * std::pow(fine.cost / coarse.cost, share);
  }
  return std::nullopt;
}

Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::ranges::sort(values);
  const auto quantile = [&](double share) {
    const double place = share * static_cast<double>(values.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return values[below] + (place - std::floor(place)) * (values[above] - values[below]);
  };
  return {values.front(), quantile(0.25), quantile(0.5), quantile(0.75), values.back()};
}

}  // namespace taut::study
