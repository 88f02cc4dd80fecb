// Joints in a world: what may be joined, and which particle stands for all.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "sim/world/state.h"

namespace taut {

/// The flaw of a world's joints, in words that end a sentence about it; empty: none.
std::string joint_flaw(const World& world);

/// The particle of a joint that stands for all: the one that is held, or else the first.
const Joint::Particle& leader(const World& world, const Joint& joint);

/// The joint that the particle belongs to, or null.
const Joint* find_joint(const World& world, std::size_t connector, std::size_t particle);

/// The mass (kg) at a particle, with those that are joined with it.
double joined_mass(const World& world, std::size_t connector, std::size_t particle);
/// The mass (kg) of all that a joint joins.
double joined_mass(const World& world, const Joint& joint);

/// For every particle, connector by connector, the number of the one that stands for it.
void find_leaders(const World& world, std::vector<std::uint32_t>& leaders);

/// Takes joined particles, all or those of one joint, to where that is which stands for them.
void place_joined(World& world);
void place_joined(World& world, const Joint& joint);

}  // namespace taut
