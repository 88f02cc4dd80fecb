// How a run went, in one word: the classes of a stability map.
#pragma once

#include <limits>
#include <span>
#include <string_view>

#include "sim/evaluation/run.h"
#include "sim/truth/truth.h"

namespace taut::study {

/// The first that fits, in this order.
enum class MotionClass {
  over_cap,     // it was stopped at its CPU cap before it showed any other failure
  failed,       // diverged, not finite, or gained energy
  stretched,    // a link is too long or too short
  over_damped,  // lost energy
  accurate,     // near the reference, where there is one
  plausible,    // nothing wrong that needs no reference to be seen
};

struct ClassLimits {
  double gain = 0.1;       // of the available energy
  double stretch = 0.01;   // of a link's rest length
  double loss = 0.1;       // of the available energy
  double accurate = 0.01;  // RMS, of the connectors' length, within the horizon
};

struct Classification {
  MotionClass motion_class = MotionClass::plausible;
  double gain = 0, loss = 0;  // of the available energy
  double stretch = 0;         // of a link's length; beyond its material's
  double error = std::numeric_limits<double>::quiet_NaN();  // RMS, of the length
};

/// The unit of relative errors: the length (m) of all connectors together; of joints alone
/// length_scale().
double total_length(const World& world);

/// The energy (J) that the world can turn into motion: its energy, less that of everything at rest
/// below the holds. Without holds: its kinetic energy, and that of a fall by total_length(). At
/// least a thousandth of that fall, so that a world at rest has a scale as well.
double available_energy(const World& world);

/// Judges a run of `problem`. Energies count only where nothing is driven. `reference` may be null.
Classification classify(const Problem& problem, const Run& run, const truth::Reference* reference,
                        const ClassLimits& limits = {});

/// A word or two for tables and legends.
std::string_view name_of(MotionClass motion_class);

}  // namespace taut::study
