// Connectors that stretch, bend and meet the air, with answers known beforehand.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "sim/measure/measure.h"
#include "sim/run/simulation.h"
#include "tests/physics/worlds.h"

namespace taut::material_worlds {

inline Section section(double axial, double bending) {
  Section made;
  made.axial_stiffness = axial;
  made.bending_stiffness = bending;
  made.diameter = 0.01;
  return made;
}

constexpr double kRigid = std::numeric_limits<double>::infinity();

/// A metre of rope along x from the origin, whose first particle is fixed, and clamped along x
/// where `clamped`. Each link gives half of its mass to either end, as a continuous rope does.
inline World rope(std::size_t links, double mass, const Section& made, bool clamped) {
  World world;
  Connector connector = straight_connector("rope", 1, mass, links + 1, Vec3::Zero(), Vec3::UnitX());
  connector.particle_mass.assign(links + 1, mass / static_cast<double>(links));
  connector.particle_mass.front() /= 2;
  connector.particle_mass.back() /= 2;
  connector.sections.assign(links, made);
  Hold hold;
  if (clamped) hold.clamp = Vec3::UnitX();
  connector.holds = {hold};
  world.connectors = {connector};
  finish(world);
  return world;
}

/// `world` after so long (s), by a method.
inline World after(const World& start, double time, const char* method, const Settings& settings) {
  Simulation simulation(start, make_method(method, settings));
  simulation.advance_to(time);
  return simulation.world();
}

inline World after(const World& start, double time, double tolerance) {
  return after(start, time, "direct", {{"tolerance", tolerance}});
}

/// RMS distance of the particles of two worlds, m.
inline double apart(const World& a, const World& b) {
  double sum = 0, count = 0;
  for (std::size_t c = 0; c < a.connectors.size(); ++c) {
    for (std::size_t i = 0; i < a.connectors[c].particles(); ++i, ++count) {
      sum += (a.connectors[c].position[i] - b.connectors[c].position[i]).squaredNorm();
    }
  }
  return std::sqrt(sum / count);
}

/// The first zero of 1 + cos(x) cosh(x): the first frequency of a clamped beam of unit length is
/// its square times sqrt(EI / (mass per length)).
inline double first_beam_number() {
  double low = 1, high = 3;
  while (high - low > 1e-14) {
    const double middle = (low + high) / 2;
    (1 + std::cos(middle) * std::cosh(middle) > 0 ? low : high) = middle;
  }
  return low;
}

/// The shape of that mode: the deflection at x, and its slope.
inline std::pair<double, double> beam_shape(double x) {
  const double b = first_beam_number();
  const double s =
      (std::sinh(b) - std::sin(b)) / (std::cosh(b) + std::cos(b));  // shear is zero at the end
  const double shape =
      std::cosh(b * x) - std::cos(b * x) - s * (std::sinh(b * x) - std::sin(b * x));
  const double slope =
      b * (std::sinh(b * x) + std::sin(b * x) - s * (std::cosh(b * x) - std::cos(b * x)));
  return {shape, slope};
}

/// A clamped rope bent by `amplitude` (m) in that shape; its links have their length.
inline World bent_beam(std::size_t links, double mass, const Section& made, double amplitude) {
  World world = rope(links, mass, made, true);
  world.gravity.setZero();
  Connector& beam = world.connectors[0];
  for (std::size_t k = 0; k < links; ++k) {
    const double n = static_cast<double>(links), x = static_cast<double>(k);
    const double rise =
        amplitude / 2 * (beam_shape((x + 1) / n).first - beam_shape(x / n).first) * n;
    beam.position[k + 1] = beam.position[k] + Vec3(std::sqrt(1 - rise * rise), rise, 0) / n;
  }
  return world;
}

/// How much of that shape is in where the particles are, as a share of what is in `start`.
inline double beam_share(const World& world, const World& start) {
  const auto projected = [](const Connector& beam) {
    double sum = 0;
    for (std::size_t i = 1; i < beam.particles(); ++i) {
      const double x = static_cast<double>(i) / static_cast<double>(beam.links());
      sum += beam.particle_mass[i] * beam_shape(x).first * beam.position[i].y();
    }
    return sum;
  };
  return projected(world.connectors[0]) / projected(start.connectors[0]);
}

}  // namespace taut::material_worlds
