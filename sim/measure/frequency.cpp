#include "sim/measure/frequency.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "sim/measure/measure.h"

namespace taut {
namespace {

double mass_of(const World& world, const Connector& connector, std::size_t particle) {
  for (const Hold& hold : connector.holds) {
    if (hold.particle != particle || is_prescribed(world, hold.to)) continue;
    return world.bodies[hold.to.body].mass_properties.mass;
  }
  return connector.particle_mass[particle];
}

/// The load below the first held particle, from the top down.
class HangingLoad {
 public:
  HangingLoad(const World& world, const Connector& connector)
      : world_(world), connector_(connector) {
    const auto hold = std::ranges::find_if(
        connector.holds, [&](const Hold& h) { return is_prescribed(world, h.to); });
    if (hold == connector.holds.end()) return;
    backwards_ = hold->particle > 0;  // hangs from its last particle, or from a pin
    size_ = backwards_ ? hold->particle : connector.particles() - 1;
  }

  std::size_t size() const { return size_; }
  double mass(std::size_t i) const { return mass_of(world_, connector_, particle(i)); }  // kg
  /// How freely it moves (1/kg); not at all where something else holds it.
  double mobility(std::size_t i) const {
    const bool held = std::ranges::any_of(connector_.holds, [&](const Hold& h) {
      return h.particle == particle(i) && is_prescribed(world_, h.to);
    });
    return held ? 0 : 1 / mass(i);
  }
  /// Of the link above (m).
  double rest(std::size_t i) const { return connector_.rest[backwards_ ? particle(i) : i]; }

 private:
  std::size_t particle(std::size_t i) const { return backwards_ ? size_ - 1 - i : i + 1; }

  const World& world_;
  const Connector& connector_;
  bool backwards_ = false;
  std::size_t size_ = 0;
};

/// The same as arrays: masses, mobilities and links.
struct Chain {
  std::vector<double> mass, mobility, rest;
};

Chain below_hold(const World& world, const Connector& connector) {
  const HangingLoad hanging(world, connector);
  Chain chain;
  for (std::size_t i = 0; i < hanging.size(); ++i) {
    chain.mass.push_back(hanging.mass(i));
    chain.mobility.push_back(hanging.mobility(i));
    chain.rest.push_back(hanging.rest(i));
  }
  return chain;
}

/// The square of the highest frequency of m_i x_i'' = k_i (x_{i-1} - x_i) + k_{i+1} (x_{i+1} -
/// x_i), particle 0 fixed; k (N/m) per link.
double highest_squared(const std::vector<double>& mobility, const std::vector<double>& k) {
  const auto n = static_cast<Eigen::Index>(mobility.size());
  if (n == 0) return 0;
  Eigen::VectorXd diagonal(n), off_diagonal(n - 1);
  for (Eigen::Index row = 0; row < n; ++row) {
    const auto i = static_cast<std::size_t>(row);
    const double below = i + 1 < k.size() ? k[i + 1] : 0;
    diagonal[row] = (k[i] + below) * mobility[i];
    if (row + 1 < n) off_diagonal[row] = -below * std::sqrt(mobility[i] * mobility[i + 1]);
  }
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, off_diagonal, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().maxCoeff();
}

/// The highest frequency of all connectors, with the stiffnesses that `k_of` makes of a chain.
template <class Stiffness>
double highest_frequency(const World& world, Stiffness k_of) {
  double squared = 0;
  for (const Connector& connector : world.connectors) {
    const Chain chain = below_hold(world, connector);
    squared = std::max(squared, highest_squared(chain.mobility, k_of(chain)));
  }
  return std::sqrt(squared);
}

/// The weight (N) of all that moves, where something holds it.
double whole_weight(const World& world) {
  const bool hangs = std::ranges::any_of(world.connectors, [&](const Connector& connector) {
    return std::ranges::any_of(connector.holds,
                               [&](const Hold& hold) { return is_prescribed(world, hold.to); });
  });
  return hangs ? moving_mass(world) * world.gravity.norm() : 0;
}

/// Calls visit(link, ends' points) for all links of joined connectors that have a length, by the
/// points that stand for theirs.
template <class Visit>
void each_joined_link(const World& world, Visit visit) {
  std::vector<std::uint32_t> leaders;
  find_leaders(world, leaders);
  std::size_t first = 0;
  for (const Connector& connector : world.connectors) {
    for (std::size_t k = 0; k < connector.links(); ++k) {
      if (connector.rest[k] > 0) {
        visit(connector.rest[k], leaders[first + k], leaders[first + k + 1]);
      }
    }
    first += connector.particles();
  }
}

/// 1/kg, by the points that stand for particles; a free body as the point mass that it is at least.
std::vector<double> joined_mobility(const World& world) {
  std::vector<std::uint32_t> leaders;
  find_leaders(world, leaders);
  std::vector<double> mass(leaders.size());
  std::size_t point = 0;
  for (const Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i, ++point) {
      mass[leaders[point]] += connector.particle_mass[i];
    }
  }
  point = 0;
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      mass[point + hold.particle] =
          is_prescribed(world, hold.to) ? INFINITY : mass_of(world, connector, hold.particle);
    }
    point += connector.particles();
  }
  for (double& each : mass) each = each > 0 ? 1 / each : 0;
  return mass;
}

/// Gershgorin's bound on the frequency of links of stiffness k(rest), N/m.
template <class Stiffness>
double highest_joined_frequency(const World& world, Stiffness k) {
  const std::vector<double> mobility = joined_mobility(world);
  std::vector<double> sum(mobility.size());
  each_joined_link(world, [&](double rest, std::size_t a, std::size_t b) {
    sum[a] += 2 * k(rest);
    sum[b] += 2 * k(rest);
  });
  double squared = 0;
  for (std::size_t p = 0; p < sum.size(); ++p) squared = std::max(squared, mobility[p] * sum[p]);
  return std::sqrt(squared);
}

}  // namespace

double highest_swing_frequency(const World& world) {
  if (!world.joints.empty()) {
    const double weight = whole_weight(world);
    return highest_joined_frequency(world, [&](double rest) { return weight / rest; });
  }
  return highest_frequency(world, [&](const Chain& chain) {
    std::vector<double> k(chain.rest.size());  // T_i / l_i, T_i the weight below link i
    double tension = 0;
    for (std::size_t i = k.size(); i-- > 0;) {
      tension += chain.mass[i] * world.gravity.norm();
      k[i] = chain.rest[i] > 0 ? tension / chain.rest[i] : 0;
    }
    return k;
  });
}

namespace {

/// Calls visit(tension, length, mobility) for each link that is not of length 0: N at rest, m, and
/// 1/kg of the lighter of the masses that it joins. Of joined connectors each link bears all
/// weight.
template <class Visit>
void each_loaded_link(const World& world, Visit visit) {
  if (!world.joints.empty()) {
    const double weight = whole_weight(world);
    const std::vector<double> mobility = joined_mobility(world);
    each_joined_link(world, [&](double rest, std::size_t a, std::size_t b) {
      visit(weight, rest, std::max(mobility[a], mobility[b]));
    });
    return;
  }
  for (const Connector& connector : world.connectors) {
    const HangingLoad chain(world, connector);
    double tension = 0;
    for (std::size_t i = chain.size(); i-- > 0;) {
      tension += chain.mass(i) * world.gravity.norm();
      const double mobility = std::max(chain.mobility(i), i > 0 ? chain.mobility(i - 1) : 0);
      if (chain.rest(i) > 0) visit(tension, chain.rest(i), mobility);
    }
  }
}

}  // namespace

double heaviest_link(const World& world) {
  double most = 0;
  each_loaded_link(world, [&](double tension, double length, double mobility) {
    most = std::max(most, tension * mobility / length);
  });
  return most;
}

double heaviest_bend(const World& world) {
  double most = 0;
  for (const Connector& connector : world.connectors) {
    const double mass =
        std::accumulate(connector.particle_mass.begin(), connector.particle_mass.end(), 0.0);
    const double hangs = mass * world.gravity.norm() * connector.length / 2;  // N m
    for (std::size_t k = 0; k < connector.sections.size(); ++k) {
      const double length = connector.rest[k];
      const double half_turn = std::numbers::pi * connector.sections[k].bending_stiffness / length;
      const double sum = std::min(hangs * static_cast<double>(connector.links()), half_turn);
      const double lighter =
          std::min(mass_of(world, connector, k), mass_of(world, connector, k + 1));
      if (sum > 0 && lighter > 0) most = std::max(most, sum / (lighter * length * length));
    }
  }
  return most;
}

double tightest_link(const World& world) {
  double most = 0;
  for (const Connector& connector : world.connectors) {
    for (std::size_t k = 0; k < connector.sections.size(); ++k) {
      const double length = connector.rest[k];
      const double longer = (connector.position[k + 1] - connector.position[k]).norm() - length;
      const double lighter =
          std::min(mass_of(world, connector, k), mass_of(world, connector, k + 1));
      const double tension = connector.sections[k].axial_stiffness * longer / length;
      if (tension > 0 && std::isfinite(tension) && lighter > 0)
        most = std::max(most, tension / (lighter * length));
    }
  }
  return most;
}

double strongest_pull(const World& world) {
  double most = 0;
  each_loaded_link(world, [&](double tension, double length, double) {
    most = std::max(most, tension / length);
  });
  return most;
}

double highest_stretch_frequency(const World& world, double stiffness) {
  if (!world.joints.empty()) {
    return highest_joined_frequency(
        world, [&](double) { return whole_weight(world) > 0 ? stiffness : 0; });
  }
  return highest_frequency(
      world, [&](const Chain& chain) { return std::vector<double>(chain.rest.size(), stiffness); });
}

}  // namespace taut
