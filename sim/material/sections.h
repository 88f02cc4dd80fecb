// Sections of connectors from materials and tapers.
#pragma once

#include <span>

#include "sim/world/connector.h"

namespace taut::material {

/// A solid round rod of one material.
struct RoundRod {
  double youngs_modulus = 0;    // Pa
  double diameter = 0;          // m
  double density = 0;           // kg/m^3
  double poissons_ratio = 0.3;  // of most metals; rubber has nearly 0.5

  double mass(double length) const;  // kg
  /// `other` with the stiffnesses and the diameter of the rod.
  Section section(Section other = {}) const;
};

/// Gives all links of a connector a section. `taper` has diameters along it, evenly spaced and
/// linear between, as shares of the section's: stiffness goes with the fourth power in bending and
/// twist and the second in stretch, mass with the second. Empty: none.
void give_sections(Connector& connector, const Section& section,
                   std::span<const double> taper = {});

/// Half of each link's mass at either end; links of a tapered connector that is as heavy as before.
void weigh_by_links(Connector& connector, std::span<const double> taper);

}  // namespace taut::material
