#include "sim/connector.h"

#include <cmath>
#include <stdexcept>

namespace taut {

Connector straight_connector(std::string name, double length, double mass, std::size_t particles,
                             const Vec3& start, const Vec3& direction) {
  if (particles < 2) throw std::invalid_argument("a connector needs at least 2 particles");
  if (!(length >= 0)) throw std::invalid_argument("a connector's length cannot be negative");
  if (!(mass >= 0)) throw std::invalid_argument("a connector's mass cannot be negative");
  if (length > 0 && !(direction.norm() > 0)) {
    throw std::invalid_argument("a connector's direction cannot be zero");
  }
  Connector connector;
  connector.name = std::move(name);
  connector.length = length;
  connector.mass = mass;
  connector.rest.assign(particles - 1, length / static_cast<double>(particles - 1));
  connector.particle_mass.assign(particles, mass / static_cast<double>(particles));
  connector.velocity.assign(particles, Vec3::Zero());
  connector.position.resize(particles);
  const Vec3 unit = direction.stableNormalized();
  for (std::size_t i = 0; i < particles; ++i) {
    const double along = length * static_cast<double>(i) / static_cast<double>(particles - 1);
    connector.position[i] = start + along * unit;
  }
  return connector;
}

namespace {

/// A hanging chain in its vertical plane. Every link pulls along itself and the weights of the
/// particles are the differences of the pulls, so the pull in link k is (pull.x, pull.y + the
/// weight of the particles before it).
struct Hanging {
  const std::vector<double>& rest;
  std::vector<double> before;  // N, weight of the particles between the start and link k

  /// Where the chain ends for a given pull in its first link.
  Eigen::Vector2d end(const Eigen::Vector2d& pull) const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < rest.size(); ++k) {
      const Eigen::Vector2d along(pull.x(), pull.y() + before[k]);
      sum += rest[k] / along.norm() * along;
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

}  // namespace

std::vector<Vec3> hanging_points(const Connector& connector, const Vec3& from, const Vec3& to,
                                 const Vec3& gravity) {
  const std::size_t links = connector.links();
  const Vec3 span = to - from;
  std::vector<Vec3> points(links + 1, from);
  points.back() = to;
  if (span.norm() >= connector.length * (1 - 1e-12)) {  // straight
    double along = 0;
    for (std::size_t k = 0; k + 1 < links; ++k) {
      along += connector.rest[k];
      points[k + 1] = from + along / connector.length * span;
    }
    return points;
  }
  const Vec3 up = gravity.norm() > 0 ? Vec3(-gravity.normalized()) : Vec3::UnitY();
  const double rise = span.dot(up);
  Vec3 across = span - rise * up;
  const double run = across.norm();
  across = run > 1e-12 * connector.length ? Vec3(across / run) : up.unitOrthogonal();

  // Only the ratios of the weights shape the chain: the whole chain weighs 1.
  Hanging chain{connector.rest, std::vector<double>(links, 0.0)};
  for (std::size_t k = 1; k < links; ++k) {
    const double weight = connector.mass > 0 ? connector.particle_mass[k] / connector.mass
                                             : 1 / static_cast<double>(links);
    chain.before[k] = chain.before[k - 1] + weight;
  }
  const auto pull = [&](double horizontal) {
    const auto reach = [&](double vertical) {
      return chain.end({horizontal, vertical}).y() - rise;
    };
    double bound = 2 + 2 * horizontal;
    while (reach(-bound) > 0 || reach(bound) < 0) bound *= 2;
    return Eigen::Vector2d(horizontal, bisect(-bound, bound, reach));
  };
  const double logarithm = bisect(std::log(1e-9), std::log(1e9), [&](double log_pull) {
    return chain.end(pull(std::exp(log_pull))).x() - run;
  });
  const Eigen::Vector2d first = pull(std::exp(logarithm));
  for (std::size_t k = 0; k + 1 < links; ++k) {
    const Eigen::Vector2d along =
        Eigen::Vector2d(first.x(), first.y() + chain.before[k]).normalized();
    points[k + 1] = points[k] + connector.rest[k] * (along.x() * across + along.y() * up);
  }
  return points;
}

}  // namespace taut
