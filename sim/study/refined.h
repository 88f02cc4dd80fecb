// How far a chain of particles is from the continuous rope that it stands for.
#pragma once

#include <limits>
#include <optional>

#include "sim/evaluation/compared_run.h"

namespace taut::study {

/// The largest distance of any of the reference solution's points in the frames that can be
/// compared, for a world that models the same in another way; infinite where it cannot be run that
/// far. Throws OverLimit where that takes more than `cpu_cap` (s).
double distance_between(const ReferenceSolution& reference, const World& world,
                        const Timeline& timeline, const MethodChoice& candidate,
                        const Distance& distance,
                        double cpu_cap = std::numeric_limits<double>::infinity());

/// Where chains of n, 2n, 4n links tend to, from how far the second (`twice`) and the third
/// (`four`) are from the first: with errors that shrink by the same factor r each time, these are
/// (1 - r) and (1 - r^2) times the first one's. None where they do not shrink.
std::optional<double> error_of_chain(double twice, double four);

}  // namespace taut::study
