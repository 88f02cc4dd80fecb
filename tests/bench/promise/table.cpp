#include "tests/bench/promise/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace taut::promise {
namespace {

template <typename Value>
double quantile(const std::vector<Score>& scores, double share, Value value) {
  std::vector<double> values;
  for (const Score& score : scores) values.push_back(value(score));
  std::ranges::sort(values);
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(0.0, rank - 1))];
}

std::string row(std::string_view tolerance, std::string_view kind,
                const std::vector<Score>& scores) {
  if (scores.empty()) return {};
  const auto error = [](const Score& score) { return score.error; };
  const auto within = [&](double most) {
    const auto count =
        std::ranges::count_if(scores, [most](const Score& score) { return score.error <= most; });
    return 100 * static_cast<double>(count) / static_cast<double>(scores.size());
  };
  const Score& last = *std::ranges::max_element(scores, {}, error);
  return fmt::format(
      "{:>9} {:>8} {:>6} {:>6.1f} {:>6.1f} {:>8.3g} {:>8.3g} {:>8.3g} {:>6} {:>8.0f} "
      "{:>8.3g} {:>8}\n",
      tolerance, kind, scores.size(), within(1), within(3), quantile(scores, 0.5, error),
      quantile(scores, 0.95, error), last.error, last.seed,
      quantile(scores, 0.5, [](const Score& s) { return s.solves; }),
      quantile(scores, 0.5, [](const Score& s) { return s.ms; }),
      std::ranges::count_if(scores, &Score::diverged));
}

}  // namespace

std::string table(const std::vector<Score>& scores) {
  std::set<double, std::greater<>> tolerances;
  for (const Score& score : scores) tolerances.insert(score.tolerance);
  std::string text =
      fmt::format("{:>9} {:>8} {:>6} {:>6} {:>6} {:>8} {:>8} {:>8} {:>6} {:>8} {:>8} {:>8}\n",
                  "tolerance", "kind", "scenes", "<=1 %", "<=3 %", "median", "95 %", "worst",
                  "seed", "solves", "ms", "diverged");
  const auto rows = [&](std::string_view name, const std::vector<Score>& some) {
    for (std::size_t kind = 0; kind < kKinds.size(); ++kind) {
      std::vector<Score> of_kind;
      std::ranges::copy_if(some, std::back_inserter(of_kind),
                           [kind](const Score& score) { return score.kind == kind; });
      text += row(name, kKinds[kind], of_kind);
    }
    text += row(name, "all", some);
  };
  for (const double tolerance : tolerances) {
    std::vector<Score> some;
    std::ranges::copy_if(scores, std::back_inserter(some),
                         [tolerance](const Score& score) { return score.tolerance == tolerance; });
    rows(fmt::format("{:g} L", tolerance), some);
  }
  rows("any", scores);
  return text;
}

std::string estimates(const std::vector<Score>& scores) {
  std::set<double, std::greater<>> tolerances;
  for (const Score& score : scores) tolerances.insert(score.tolerance);
  std::string text = fmt::format("{:>9} {:>6} {:>6} {:>8} {:>8} {:>8} {:>8}\n", "tolerance",
                                 "scenes", "near %", "5 %", "median", "95 %", "cost");
  const auto row = [&](const std::string& name, const std::vector<Score>& some) {
    const auto near_ones = std::ranges::count_if(some, near);
    text += fmt::format("{:>9} {:>6} {:>6.1f}", name, some.size(),
                        100 * static_cast<double>(near_ones) / static_cast<double>(some.size()));
    for (const double share : {0.05, 0.5, 0.95}) {
      text +=
          fmt::format(" {:>8.3g}", quantile(some, share, [](const Score& s) { return s.told(); }));
    }
    text += fmt::format(" {:>8.3g}\n",
                        quantile(some, 0.5, [](const Score& s) { return s.estimating; }));
  };
  for (const double tolerance : tolerances) {
    std::vector<Score> some;
    std::ranges::copy_if(scores, std::back_inserter(some),
                         [tolerance](const Score& score) { return score.tolerance == tolerance; });
    row(fmt::format("{:g} L", tolerance), some);
  }
  row("any", scores);
  return text;
}

std::string worst(std::vector<Score> scores, std::size_t count) {
  std::ranges::stable_sort(scores, std::ranges::greater(), &Score::error);
  scores.resize(std::min(count, scores.size()));
  std::string text;
  for (const Score& s : scores) {
    text += fmt::format(
        "seed {:>5} {:>8} {:>4} particles, load {:>8.3g}, {:>6g} L: error {:>8.3g}, "
        "horizon {:.3f} s, growth {:.3g}\n",
        s.seed, kKinds[s.kind], s.particles, s.ratio, s.tolerance, s.error, s.horizon, s.growth);
  }
  return text;
}

std::string csv(const std::vector<Score>& scores) {
  std::string text =
      "seed,kind,particles,ratio,tolerance_of_length,error_in_tolerances,horizon,solves,rejected,"
      "ms,growth,diverged,estimate,estimating\n";
  for (const Score& s : scores) {
    text += fmt::format(
        "{},{},{},{:.6g},{:g},{:.6g},{:.6g},{:.0f},{:.0f},{:.6g},{:.4g},{:d},{:.6g},{:.4g}\n",
        s.seed, kKinds[s.kind], s.particles, s.ratio, s.tolerance, s.error, s.horizon, s.solves,
        s.rejected, s.ms, s.growth, s.diverged, s.estimate, s.estimating);
  }
  return text;
}

}  // namespace taut::promise
