// Which scheme of the method direct takes which steps.
#pragma once

#include <iosfwd>
#include <span>

#include "tests/bench/promise/draw.h"

namespace taut::promise {

/// The columns of write_schemes().
constexpr std::string_view kSchemeColumns =
    "seed,kind,tolerance_of_length,waves_rad_per_s,step_s,limit,scheme";

/// Follows the scene with each of the tolerances (shares of the length), and writes a line for the
/// last step before each frame of each component.
void write_schemes(const Drawn& drawn, std::span<const double> tolerances, std::ostream& out);

}  // namespace taut::promise
