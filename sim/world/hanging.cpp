// The catenary of a discrete chain.
#include "sim/world/hanging.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/world/places.h"

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

namespace {

/// Lays links of a span that nothing holds at one end in the directions that they have, each at its
/// length: from the end that is held, or so that the centre of mass stays.
void lay(Connector& connector, std::size_t first, std::size_t last) {
  std::vector<Vec3>& p = connector.position;
  const bool forth = holds(connector, first), back = !forth && holds(connector, last);
  Vec3 next = back ? p[last] : p[first], moment = Vec3::Zero();
  double mass = 0;
  const auto place = [&](std::size_t i, const Vec3& there) {
    moment += connector.particle_mass[i] * (there - p[i]);
    mass += connector.particle_mass[i];
    p[i] = there;
  };
  for (std::size_t step = 0; step < last - first; ++step) {
    const std::size_t i = back ? last - step : first + step, beyond = back ? i - 1 : i + 1;
    const Vec3 gap = p[beyond] - p[i];
    place(i, next);
    next += connector.rest[back ? beyond : i] / gap.norm() * gap;
  }
  place(back ? first : last, next);
  if (forth || back) return;
  for (std::size_t i = first; i <= last; ++i) p[i] -= moment / mass;
}

}  // namespace

/// How far off a link's squared length is, as a share, of the links from `first` to `last`.
double LinkRestorer::measure(const Connector& connector, std::size_t first, std::size_t last) {
  double worst = 0;
  for (std::size_t k = first; k < last; ++k) {
    Row& row = rows_[k];
    row.gap = connector.position[k + 1] - connector.position[k];
    row.value = (row.gap.squaredNorm() - row.squared) / 2;
    worst = std::max(worst, std::abs(row.value) / row.squared);
  }
  return worst;
}

/// Link k: (w_k + w_k+1) d.d m_k - w_k d.d' m_k-1 - w_k+1 d.d'' m_k+1 = (d.d - rest^2) / 2.
bool LinkRestorer::solve(std::size_t first, std::size_t last) {
  double before = 0, upper = 0, value = 0;  // of the link before
  for (std::size_t k = first; k < last; ++k) {
    Row& row = rows_[k];
    const double pivot =
        (row.inverse_mass + rows_[k + 1].inverse_mass) * row.gap.squaredNorm() - before * upper;
    if (!(pivot > 0)) return false;
    const double inverse = 1 / pivot;
    value = (row.value - before * value) * inverse;
    before = -rows_[k + 1].inverse_mass * row.gap.dot(rows_[k + 1].gap);
    upper = before * inverse;
    row.value = value;
    row.upper = upper;
  }
  for (std::size_t k = last - 1; k-- > first;)
    rows_[k].value -= rows_[k].upper * rows_[k + 1].value;
  return true;
}

std::size_t LinkRestorer::restore(Connector& connector, std::size_t link) {
  std::size_t first = link, last = link + 1;
  while (first > 0 && !holds(connector, first)) --first;
  while (last < connector.links() && !holds(connector, last)) ++last;
  std::vector<Vec3>& p = connector.position;
  rows_.resize(std::max(rows_.size(), connector.particles()));
  for (std::size_t i = first; i <= last; ++i) {
    const bool held = (i == first || i == last) && holds(connector, i);
    const double mass = connector.particle_mass[i];
    rows_[i].before = p[i];
    rows_[i].inverse_mass = held ? 0 : mass > 0 ? 1 / mass : 1;
    rows_[i].squared = i < last ? connector.rest[i] * connector.rest[i] : 0;
  }
  rows_[last].gap = Vec3::Zero();

  constexpr int kIterations = 20;
  constexpr double kRestored = 1e-10;
  const bool both = holds(connector, first) && holds(connector, last);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (measure(connector, first, last) <= kRestored) return last;
    if (!solve(first, last)) break;
    Vec3 before = Vec3::Zero();  // the pull of the link before
    for (std::size_t i = first; i <= last; ++i) {
      const Vec3 pull = i < last ? Vec3(rows_[i].value * rows_[i].gap) : Vec3::Zero();
      p[i] += rows_[i].inverse_mass * (pull - before);
      before = pull;
    }
    if (!both) lay(connector, first, last);  // what is left is of second order
  }
  for (std::size_t i = first; i <= last; ++i) p[i] = rows_[i].before;
  return last;
}

}  // namespace taut
