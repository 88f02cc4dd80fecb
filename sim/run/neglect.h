// Worlds with less physics that stand for another.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sim/world/world.h"

namespace taut {

/// Physics beyond rigid links that bend freely in a vacuum.
enum class Physics { air, twist, bending, stretch };

/// "air", "twist", "bending", "stretch".
std::string_view name_of(Physics physics);
std::vector<std::string_view> names_of(std::span<const Physics> physics);
std::optional<Physics> physics_named(std::string_view name);

/// The physics that some connector of the world has, what is least likely to matter first.
std::vector<Physics> physics_of(const World& world);

/// Takes some physics from all connectors; without bending clamps are hinges, and nothing twists.
/// The world is consistent afterwards. Throws like finish().
void neglect(World& world, std::span<const Physics> physics);

}  // namespace taut
