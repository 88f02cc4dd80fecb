#include "sim/world/connector.h"

#include <algorithm>
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

void weigh_by_links(Connector& connector) {
  const double each = connector.mass / static_cast<double>(connector.particles());
  for (double& mass : connector.particle_mass) mass -= each;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double half = connector.mass / static_cast<double>(connector.links()) / 2;
    connector.particle_mass[k] += half;
    connector.particle_mass[k + 1] += half;
  }
}

PaidOut Winch::paid_out(std::size_t end, double time) const {
  if (!paths[end]) return {};
  const FrameMotion at = paths[end]->at(time);
  return {at.position.x(), at.velocity.x(), at.acceleration.x()};
}

double Winch::share_at(std::size_t particle) const {
  const std::size_t left = particle > 0 ? particle - 1 : 0;
  const std::size_t right = std::min(particle + 1, before.size() - 1);
  return (before[right] - before[left]) / 2;
}

Winch::Flow Winch::flow(std::size_t particle, const PaidOut& first, const PaidOut& last) const {
  const double behind = 1 - before[particle];
  return {behind * first.rate - before[particle] * last.rate,
          behind * first.acceleration - before[particle] * last.acceleration};
}

double Winch::least() const {
  // Between two keys a path is a polynomial of degree five: at so many places beside one another
  // its least value is near the least of them.
  constexpr int kPlaces = 64, kHalvings = 40;
  std::vector<double> times;
  for (const auto& path : paths) {
    if (!path) continue;
    for (const PathKey& key : path->keys()) times.push_back(key.time);
  }
  std::ranges::sort(times);
  double least = longer(times.front()).length, at = times.front(), step = 0;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const double apart = (times[i] - times[i - 1]) / kPlaces;
    for (int k = 1; k <= kPlaces; ++k) {
      const double time = times[i - 1] + k * apart, more = longer(time).length;
      if (more >= least) continue;
      least = more;
      at = time;
      step = apart;
    }
  }
  for (int i = 0; i < kHalvings; ++i, step /= 2) {
    for (const double aside : {at - step, at + step}) {
      const double time = std::clamp(aside, times.front(), times.back());
      const double more = longer(time).length;
      if (more >= least) continue;
      least = more;
      at = time;
    }
  }
  return least;
}

bool Winch::rests() const {
  return std::ranges::all_of(paths, [](const auto& path) {
    return !path || (path->keys().size() == 1 && path->keys().front().velocity.isZero(0));
  });
}

}  // namespace taut
