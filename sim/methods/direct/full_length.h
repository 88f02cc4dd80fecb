// Why no step is small enough: links at their full length between two holds.
#pragma once

#include <optional>
#include <string>

#include "sim/links/mechanism.h"
#include "sim/run/method.h"
#include "sim/topology/components.h"

namespace taut::direct {

/// The link, or massless span, between two places that are held, as is known beforehand, which the
/// world's state stretches or, a link, compresses: says so. Empty where there is none. No part has
/// such a link. Connectors that stretch, bend or meet the air are left out.
struct LedAway {
  std::size_t connector = 0, link = 0;
  std::string what;
};
std::optional<LedAway> led_away(const World& world);

/// Where links of the part have no slack left between two places that are held, as is known
/// beforehand, and so have nowhere to go: says so. Empty where there is none.
std::string full_length(const World& world, const Component& part, double time);

/// What to throw where no step leads on from a state of the world's mechanism at `time` (s), after
/// so many steps. Names the connector that is pressed together or at its full length, else the
/// fastest particle.
Diverged no_step(const World& world, const Mechanism& mechanism, const double* state, double time,
                 std::uint64_t steps);

}  // namespace taut::direct
