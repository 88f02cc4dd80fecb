#include "sim/world/winched.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace taut {
namespace {

bool at_end(const Connector& connector, const Hold& hold) {
  return hold.particle == 0 || hold.particle + 1 == connector.particles();
}

std::string flaw_of(const World& world, std::size_t index) {
  const Connector& connector = world.connectors[index];
  for (const Section& section : connector.sections) {
    if (std::isfinite(section.axial_stiffness)) return "stretches";
    if (section.twisting_stiffness > 0) return "resists twist";
    if (section.bending_damping > 0) return "damps its bending";
    if (!section.rest_curvature.isZero(0)) return "is curved at rest";
    if (section.bending_stiffness != connector.sections[0].bending_stiffness) return "has a taper";
  }
  if (connector.pulls) return "is of strings";
  if (connector.model == ConnectorModel::span) return "is a massless span";
  for (const Hold& hold : connector.holds) {
    if (!at_end(connector, hold)) return "is held between its ends";
  }
  for (const Joint& joint : world.joints) {
    for (const Joint::Particle& at : joint.particles) {
      if (at.connector == index) return "is joined";
    }
  }
  for (const std::size_t end : {0u, 1u}) {
    if (!connector.winch->paths[end]) continue;
    const std::size_t particle = end == 0 ? 0 : connector.particles() - 1;
    const auto held = [&](const Hold& hold) {
      return hold.particle == particle && is_prescribed(world, hold.to);
    };
    if (!std::ranges::any_of(connector.holds, held)) {
      return "has a winch at an end whose motion is not known beforehand";
    }
  }
  return {};
}

}  // namespace

void add_winches(const World& world, Connector& connector, std::shared_ptr<const Path> first,
                 std::shared_ptr<const Path> last) {
  Winch winch;
  winch.paths = {std::move(first), std::move(last)};
  winch.length = connector.length;
  winch.mass = connector.mass;
  winch.rest = connector.rest;
  winch.particle_mass = connector.particle_mass;
  const auto links = static_cast<double>(connector.links());
  winch.density =
      connector.mass / static_cast<double>(connector.particles()) / (connector.length / links);
  std::size_t from = 0, until = connector.links();  // the links that change
  for (const Hold& hold : connector.holds) {
    if (is_prescribed(world, hold.to)) continue;
    if (hold.particle == 0) from = 1;
    if (hold.particle == connector.links()) --until;
  }
  if (until <= from) {
    throw std::invalid_argument("the connector " + connector.name +
                                " has a winch and needs a link that no free body holds");
  }
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    winch.before.push_back(static_cast<double>(std::clamp(i, from, until) - from) /
                           static_cast<double>(until - from));
  }
  connector.winch = std::make_shared<const Winch>(std::move(winch));
}

std::string winch_flaw(const World& world) {
  if (!has_winches(world)) return {};
  if (has_contact(world)) return "there are winches, and something touches";
  if (has_strings(world)) return "there are winches, and links that only pull";
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (connector.model == ConnectorModel::span) return "there are winches, and a massless span";
    if (!connector.winch) continue;
    const std::string what = flaw_of(world, c);
    if (!what.empty()) return "the connector " + connector.name + " has a winch and " + what;
  }
  return {};
}

void set_lengths(Connector& connector, double time) {
  const Winch& winch = *connector.winch;
  const double longer = winch.longer(time).length;
  connector.length = winch.length + longer;
  connector.mass = winch.mass + winch.density * longer;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    connector.rest[k] = winch.rest[k] + winch.share(k) * longer;
  }
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    connector.particle_mass[i] =
        winch.particle_mass[i] + winch.density * winch.share_at(i) * longer;
  }
}

}  // namespace taut
