#include "sim/material/sections.h"

#include <algorithm>
#include <numbers>

namespace taut::material {
namespace {

double area(double diameter) {
  return std::numbers::pi * diameter * diameter / 4;
}

/// The share of its diameter that a connector has in the middle of a link.
double taper_at(std::span<const double> taper, const Connector& connector, std::size_t link) {
  if (taper.empty()) return 1;
  const double share = (static_cast<double>(link) + 0.5) / static_cast<double>(connector.links());
  const double place = share * static_cast<double>(taper.size() - 1);
  const std::size_t before = std::min(static_cast<std::size_t>(place), taper.size() - 2);
  const double ahead = place - static_cast<double>(before);
  return (1 - ahead) * taper[before] + ahead * taper[before + 1];
}

}  // namespace

double RoundRod::mass(double length) const {
  return density * area(diameter) * length;
}

Section RoundRod::section(Section other) const {
  other.diameter = diameter;
  other.axial_stiffness = youngs_modulus * area(diameter);
  other.bending_stiffness = other.axial_stiffness * diameter * diameter / 16;  // pi d^4 / 64
  other.twisting_stiffness =  // E / 2 (1 + nu) times twice the area's second moment
      other.bending_stiffness / (1 + poissons_ratio);
  return other;
}

void give_sections(Connector& connector, const Section& section, std::span<const double> taper) {
  connector.sections.assign(connector.links(), section);
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double thick = taper_at(taper, connector, k), squared = thick * thick;
    Section& own = connector.sections[k];
    own.axial_stiffness *= squared;
    own.axial_damping *= squared;
    own.bending_stiffness *= squared * squared;
    own.bending_damping *= squared * squared;
    own.twisting_stiffness *= squared * squared;
    own.twisting_damping *= squared * squared;
    own.diameter *= thick;
  }
}

void weigh_by_links(Connector& connector, std::span<const double> taper) {
  std::vector<double> weight;
  double sum = 0;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double thick = taper_at(taper, connector, k);
    weight.push_back(thick * thick * (connector.rest[k] / connector.rest[0]));
    sum += weight.back();
  }
  std::ranges::fill(connector.particle_mass, 0.0);
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double half = connector.mass * weight[k] / sum / 2;
    connector.particle_mass[k] += half;
    connector.particle_mass[k + 1] += half;
  }
}

}  // namespace taut::material
