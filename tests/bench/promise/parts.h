// What all kinds of scenes are made of.
#pragma once

#include "sim/world.h"
#include "tests/bench/promise/dice.h"
#include "tests/bench/promise/shapes.h"

namespace taut::promise {

constexpr double kGravity = 9.81;  // m/s^2, World's own

/// What every scene has: a chain and how heavy its load is.
struct Sizes {
  std::size_t links = 0;
  double length = 0;  // m
  double mass = 0;    // kg, of the chain
  double load = 0;    // kg
};

inline Attachment at(const Vec3& point) {
  Attachment to;
  to.point = point;
  return to;
}

inline Attachment on_body(std::size_t body, const Vec3& point) {
  Attachment to;
  to.kind = Attachment::Kind::body;
  to.body = body;
  to.point = point;
  return to;
}

// The kinds whose scenes take more than a line to draw.
World driven(Dice& dice, const Sizes& sizes);
World pinned(Dice& dice, const Sizes& sizes);
World bodies(Dice& dice, const Sizes& sizes);

}  // namespace taut::promise
