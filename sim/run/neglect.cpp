#include "sim/run/neglect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace taut {
namespace {

constexpr std::array kAll = {Physics::air, Physics::twist, Physics::bending, Physics::stretch};
constexpr std::array<std::string_view, kAll.size()> kNames = {"air", "twist", "bending", "stretch"};
constexpr double kRigid = std::numeric_limits<double>::infinity();

bool stretches(const Section& section) {
  return std::isfinite(section.axial_stiffness);
}
bool bends(const Section& section) {
  return section.bending_stiffness > 0 || section.bending_damping > 0;
}
bool twists(const Section& section) {
  return section.twisting_stiffness > 0 || section.twisting_damping > 0;
}

bool has(const World& world, const Connector& connector, Physics physics) {
  switch (physics) {
    case Physics::air:
      return world.air.density > 0 && (connector.drag.across > 0 || connector.drag.along > 0) &&
             !connector.sections.empty();
    case Physics::twist:
      return std::ranges::any_of(connector.sections, twists);
    case Physics::bending:
      return std::ranges::any_of(connector.sections, bends);
    case Physics::stretch:
      return std::ranges::any_of(connector.sections, stretches);
  }
  return false;
}

void neglect(Connector& connector, Physics physics) {
  if (physics == Physics::air) connector.drag = {};
  for (Section& section : connector.sections) {
    if (physics == Physics::stretch) {
      section.axial_stiffness = kRigid;
      section.axial_damping = 0;
    }
    if (physics == Physics::bending) {
      section.bending_stiffness = section.bending_damping = 0;
      section.rest_curvature = Vec3::Zero();
    }
    if (physics == Physics::bending || physics == Physics::twist) {
      section.twisting_stiffness = section.twisting_damping = section.rest_twist = 0;
    }
  }
  if (physics != Physics::bending) return;
  for (Hold& hold : connector.holds) {
    hold.clamp = Vec3::Zero();
    hold.turn = nullptr;
  }
}

}  // namespace

std::string_view name_of(Physics physics) {
  return kNames[static_cast<std::size_t>(physics)];
}

std::vector<std::string_view> names_of(std::span<const Physics> physics) {
  std::vector<std::string_view> names;
  for (const Physics one : physics) names.push_back(name_of(one));
  return names;
}

std::optional<Physics> physics_named(std::string_view name) {
  const auto found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return {};
  return kAll[static_cast<std::size_t>(found - kNames.begin())];
}

std::vector<Physics> physics_of(const World& world) {
  std::vector<Physics> all;
  for (const Physics physics : kAll) {
    const auto has_it = [&](const Connector& one) { return has(world, one, physics); };
    if (std::ranges::any_of(world.connectors, has_it)) all.push_back(physics);
  }
  return all;
}

void neglect(World& world, std::span<const Physics> physics) {
  if (physics.empty()) return;
  for (Connector& connector : world.connectors) {
    for (const Physics one : physics) neglect(connector, one);
    const bool has_more =
        std::ranges::any_of(kAll, [&](Physics one) { return has(world, connector, one); });
    if (!has_more) connector.sections.clear();
  }
  refresh(world);
}

}  // namespace taut
