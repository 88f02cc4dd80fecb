// The catenary of a discrete chain.
#include "sim/world/hanging.h"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace taut {
namespace {

using Vec2 = Eigen::Vector2d;

/// A chain at rest in its vertical plane (x along the span, y up). The links pull along themselves
/// with a common horizontal part, and the vertical parts of neighbours differ by the weight of the
/// particle between them. The lowest link has the direction (1, slope), whatever its pull: negative
/// where the span is so narrow that the rest of the chain presses it together.
struct Hanging {
  std::span<const double> rest;    // m
  std::span<const double> before;  // weight of the particles before link k, of the whole chain's
  std::size_t lowest = 0;

  Vec2 pull(std::size_t k, double horizontal, double slope) const {
    return {horizontal, horizontal * slope + before[k] - before[lowest]};
  }
  Vec2 direction(std::size_t k, double horizontal, double slope) const {
    return k == lowest ? Vec2(1, slope).normalized() : pull(k, horizontal, slope).normalized();
  }
  Vec2 end(double horizontal, double slope) const {
    Vec2 sum = Vec2::Zero();
    for (std::size_t k = 0; k < rest.size(); ++k) sum += rest[k] * direction(k, horizontal, slope);
    return sum;
  }
  /// Derivatives of end() by its arguments, in columns.
  Eigen::Matrix2d slopes(double horizontal, double slope) const {
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const Vec2 along = k == lowest ? Vec2(1, slope) : pull(k, horizontal, slope);
      const Vec2 d = along.normalized();
      const Eigen::Matrix2d turn =
          rest[k] / along.norm() * (Eigen::Matrix2d::Identity() - d * d.transpose());
      if (k != lowest) sum.col(0) += turn * Vec2(1, slope);
      sum.col(1) += turn * Vec2(0, k == lowest ? 1 : horizontal);
    }
    return sum;
  }
};

/// The zero of a rising function in [low, high], to the last bit that counts.
template <typename Function>
double bisect(double low, double high, Function f) {
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    if (middle <= low || middle >= high) break;
    (f(middle) < 0 ? low : high) = middle;
  }
  return (low + high) / 2;
}

constexpr double kLeastPull = 1e-8, kMostPull = 1e9;  // horizontal, of the chain's weight
constexpr double kClosed = 1e-6;  // of the length: the chain ends where it should

/// The slope of the first link with which a chain of given horizontal pull rises by `rise`.
double slope_for(const Hanging& chain, double horizontal, double rise) {
  const auto excess = [&](double slope) { return chain.end(horizontal, slope).y() - rise; };
  double bound = 2 + 2 / horizontal;
  while (excess(-bound) > 0 || excess(bound) < 0) bound *= 2;
  return bisect(-bound, bound, excess);
}

/// Horizontal pull and slope of a chain that ends at `to`: both by bisection where every link is
/// pulled; where that leaves the chain too wide, Newton's method follows it inwards.
Vec2 solve(Hanging& chain, const Vec2& to) {
  const double pull = std::exp(bisect(std::log(kLeastPull), std::log(kMostPull), [&](double log) {
    return chain.end(std::exp(log), slope_for(chain, std::exp(log), to.y())).x() - to.x();
  }));
  Vec2 state(pull, slope_for(chain, pull, to.y()));
  const Vec2 widest = chain.end(state.x(), state.y());
  double length = 0;
  for (const double rest : chain.rest) length += rest;
  if ((widest - to).norm() <= kClosed * length) return state;

  double least = INFINITY;
  std::size_t lowest = 0;
  for (std::size_t k = 0; k < chain.rest.size(); ++k) {
    const double vertical = chain.pull(k, state.x(), state.y()).y();
    if (std::abs(vertical) >= least) continue;
    least = std::abs(vertical);
    lowest = k;
  }
  state.y() = chain.pull(lowest, state.x(), state.y()).y() / state.x();
  chain.lowest = lowest;
  constexpr int kStages = 16, kIterations = 20;
  for (int stage = 1; stage <= kStages; ++stage) {
    const Vec2 target = widest + stage / static_cast<double>(kStages) * (to - widest);
    for (int i = 0; i < kIterations; ++i) {
      state -=
          chain.slopes(state.x(), state.y()).inverse() * (chain.end(state.x(), state.y()) - target);
    }
  }
  return state;
}

}  // namespace

void HangingChain::place(const Links& links, const Vec3& from, const Vec3& to, const Vec3& gravity,
                         std::span<Vec3> points) {
  const std::size_t count = links.rest.size();
  const Vec3 span = to - from;
  points.front() = from;
  points.back() = to;
  if (count == 1) return;
  if (span.norm() >= links.length * (1 - 1e-12)) {  // straight
    double along = 0;
    for (std::size_t k = 0; k + 1 < count; ++k) {
      along += links.rest[k];
      points[k + 1] = from + along / links.length * span;
    }
    return;
  }
  const Vec3 up = gravity.norm() > 0 ? Vec3(-gravity.normalized()) : Vec3::UnitY();
  const double rise = span.dot(up);
  Vec3 across = span - rise * up;
  const double run = across.norm();
  across = run > kClosed * links.length ? Vec3(across / run) : up.unitOrthogonal();

  // Only the ratios of the weights shape the chain: the whole chain weighs 1.
  before_.assign(count, 0.0);
  for (std::size_t k = 1; k < count; ++k) {
    const double weight =
        links.mass > 0 ? links.particle_mass[k] / links.mass : 1 / static_cast<double>(count);
    before_[k] = before_[k - 1] + weight;
  }
  Hanging chain{links.rest, before_};
  const Vec2 state = solve(chain, {run, rise});
  if (!((chain.end(state.x(), state.y()) - Vec2(run, rise)).norm() <= kClosed * links.length)) {
    throw std::invalid_argument("the chain cannot hang at rest between these points");
  }
  // A chain folded to a line ends as far beside `to` as the least pull widens it: all links share
  // it.
  Vec3 last = from;
  for (std::size_t k = 0; k < count; ++k) {
    const Vec2 along = chain.rest[k] * chain.direction(k, state.x(), state.y());
    last += along.x() * across + along.y() * up;
    points[k + 1] = last;
  }
  const Vec3 rest_of_gap = (to - last) / static_cast<double>(count);
  for (std::size_t k = 1; k <= count; ++k) points[k] += static_cast<double>(k) * rest_of_gap;
  points.back() = to;
}

std::vector<Vec3> hanging_points(const Connector& connector, const Vec3& from, const Vec3& to,
                                 const Vec3& gravity) {
  std::vector<Vec3> points(connector.links() + 1);
  HangingChain().place({connector.rest, connector.particle_mass, connector.length, connector.mass},
                       from, to, gravity, points);
  return points;
}

}  // namespace taut
