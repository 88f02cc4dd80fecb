// Recorded states, from which pictures and files are made.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/world/world.h"

namespace taut {

/// The visible state at one time: particles of every connector, the own frame of every body.
struct Snapshot {
  double time = 0;
  std::vector<std::vector<Vec3>> connectors;  // [connector][particle], m
  std::vector<Pose> bodies;                   // own frames, not centres of mass
  std::vector<double> passed = {};            // [pulley] m
};

Snapshot snapshot(const World& world);

/// A 64-bit FNV-1a hash of the world's dynamic state (time, bodies, particles), bit for bit.
std::uint64_t state_hash(const World& world);

}  // namespace taut
