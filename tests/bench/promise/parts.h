// The common parts of all kinds of scenes.
#pragma once

#include "sim/world/world.h"
#include "tests/bench/promise/shapes.h"
#include "tests/physics/worlds.h"
#include "tests/support/dice.h"

namespace taut::promise {

using worlds::fixed_at;
using worlds::kGravity;
using worlds::on_body;

/// The sizes of every scene: of its chain and of the load.
struct Sizes {
  std::size_t links = 0;
  double length = 0;  // m
  double mass = 0;    // kg, of the chain
  double load = 0;    // kg
};

/// A unit vector up to `highest` degrees from straight down, turned anyhow about the vertical.
inline Vec3 tilted(Dice& dice, double highest) {
  const double azimuth = dice.radians(0, 360);
  return from_down(dice.radians(0, highest), azimuth);
}

// The kinds whose scenes take more than a line to draw.
World driven(Dice& dice, const Sizes& sizes);
World pinned(Dice& dice, const Sizes& sizes);
World bodies(Dice& dice, const Sizes& sizes);

}  // namespace taut::promise
