#include "sim/features/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/interventions/interventions.h"
#include "sim/world/held.h"
#include "sim/world/state.h"

namespace taut {
namespace {

constexpr std::array<std::string_view, kFeatureCount> kNames{
    "stretch",
    "bending",
    "bending damping",
    "rest curvature",
    "twist",
    "air drag",
    "taper",
    "clamps",
    "turning clamps",
    "clamps on free bodies",
    "materials that hold free bodies",
    "applied forces",
    "strings",
    "restitution of strings",
    "obstacles",
    "moving obstacles",
    "capsule links",
    "contact of bodies with obstacles",
    "contact between bodies",
    "contact of beads with bodies",
    "contact between connectors",
    "contact of a connector with itself",
    "friction",
    "restitution",
    "joints",
    "closed loops",
    "joints where rope flows",
    "winches",
    "pulleys",
    "sheaves with inertia",
    "pulley friction",
    "massless spans",
    "hinges of length 0",
    "free bodies",
    "pins",
    "cuts",
};
static_assert(static_cast<std::size_t>(Feature::cut) + 1 == kFeatureCount);

/// Visits the uses of a connector's own features, each once.
void connector_uses(const World& world, std::size_t index, auto&& visit) {
  const Connector& connector = world.connectors[index];
  const auto use_if = [&](bool used, Feature feature) {
    if (used) visit(Use{feature, Use::At::connector, index});
  };
  Features own;
  if (!connector.sections.empty()) {
    const Section& first = connector.sections.front();
    for (const Section& section : connector.sections) {
      if (std::isfinite(section.axial_stiffness)) own |= Feature::stretch;
      if (section.bending_stiffness > 0) own |= Feature::bending;
      if (section.bending_damping > 0) own |= Feature::bending_damping;
      if (!section.rest_curvature.isZero(0)) own |= Feature::rest_curvature;
      if (section.twisting_stiffness > 0) own |= Feature::twist;
      const bool same = section.axial_stiffness == first.axial_stiffness &&
                        section.bending_stiffness == first.bending_stiffness &&
                        section.diameter == first.diameter;
      if (!same) own |= Feature::taper;
    }
    if (connector.drag.across > 0 || connector.drag.along > 0) own |= Feature::air;
  }
  for (const Hold& hold : connector.holds) {
    const bool free = !is_prescribed(world, hold.to);
    if (hold.pin.number > 0) own |= Feature::pin;
    if (free && connector.length == 0 && connector.model == ConnectorModel::links) {
      own |= Feature::hinge;
    }
    if (connector.sections.empty()) continue;
    if (free) own |= Feature::material_on_body;
    if (!hold.clamp.isZero(0)) own |= free ? Feature::clamp_on_body : Feature::clamp;
    if (hold.turn) own |= Feature::turning_clamp;
  }
  if (connector.applied_force) own |= Feature::applied_force;
  if (connector.pulls) own |= Feature::strings;
  if (connector.pulls && connector.restitution > 0) own |= Feature::string_rebound;
  if (connector.links_touch && !world.obstacles.empty()) own |= Feature::links_touch;
  if (connector.model == ConnectorModel::span) own |= Feature::span;
  if (connector.winch && (connector.winch->paths[0] || connector.winch->paths[1])) {
    own |= Feature::winch;
  }
  if (own.empty()) return;
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    use_if(own.has(static_cast<Feature>(f)), static_cast<Feature>(f));
  }
}

bool closes_loop(const Joint& joint) {
  for (std::size_t i = 1; i < joint.particles.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (joint.particles[i].connector == joint.particles[k].connector) return true;
    }
  }
  return false;
}

/// Whether a winch or a pulley moves rope past a particle.
bool flows_past(const World& world, const Joint::Particle& at) {
  const Connector& connector = world.connectors[at.connector];
  if (!connector.winch) return false;
  const auto of = [&](std::size_t Pulley::*rope) {
    return std::ranges::find(world.pulleys, at.connector, rope) != world.pulleys.end();
  };
  const Winch& winch = *connector.winch;
  const double before = winch.before[at.particle];
  return (before < 1 && (winch.paths[0] || of(&Pulley::to))) ||
         (before > 0 && (winch.paths[1] || of(&Pulley::from)));
}

/// Visits every use; the only place that knows where features stand in a world.
void each_use(const World& world, const Timeline* timeline, auto&& visit) {
  const auto at = [&](Use::At list, std::size_t index) {
    return [&visit, list, index](bool used, Feature feature) {
      if (used) visit(Use{feature, list, index});
    };
  };
  for (std::size_t c = 0; c < world.connectors.size(); ++c) connector_uses(world, c, visit);
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const Body& body = world.bodies[b];
    if (body.driven()) continue;
    const auto use_if = at(Use::At::body, b);
    use_if(body.capsule.touches() && !world.obstacles.empty(), Feature::body_contact);
    use_if(true, Feature::free_body);
  }
  const auto surfaces = [](const auto& touching, const auto& use_if) {
    use_if(touching.static_friction > 0 || touching.kinetic_friction > 0, Feature::friction);
    use_if(touching.restitution > 0, Feature::restitution);
  };
  for (std::size_t o = 0; o < world.obstacles.size(); ++o) {
    const auto use_if = at(Use::At::obstacle, o);
    use_if(true, Feature::obstacle);
    use_if(world.obstacles[o].path != nullptr, Feature::moving_obstacle);
    surfaces(world.obstacles[o], use_if);
  }
  for (std::size_t p = 0; p < world.pairs.size(); ++p) {
    const auto use_if = at(Use::At::body_pair, p);
    use_if(true, Feature::body_pairs);
    surfaces(world.pairs[p], use_if);
  }
  for (std::size_t p = 0; p < world.bead_pairs.size(); ++p) {
    const auto use_if = at(Use::At::bead_pair, p);
    use_if(true, Feature::bead_pairs);
    surfaces(world.bead_pairs[p], use_if);
  }
  for (std::size_t p = 0; p < world.connector_pairs.size(); ++p) {
    const auto use_if = at(Use::At::connector_pair, p);
    const bool itself = world.connector_pairs[p].a == world.connector_pairs[p].b;
    use_if(!itself, Feature::connector_pairs);
    use_if(itself, Feature::self_contact);
    surfaces(world.connector_pairs[p], use_if);
  }
  for (std::size_t j = 0; j < world.joints.size(); ++j) {
    const auto use_if = at(Use::At::joint, j);
    use_if(true, Feature::joint);
    use_if(closes_loop(world.joints[j]), Feature::loop);
    use_if(std::ranges::any_of(world.joints[j].particles,
                               [&](const auto& particle) { return flows_past(world, particle); }),
           Feature::joint_in_flow);
  }
  for (std::size_t p = 0; p < world.pulleys.size(); ++p) {
    const auto use_if = at(Use::At::pulley, p);
    use_if(true, Feature::pulley);
    use_if(world.pulleys[p].inertia > 0, Feature::sheave);
    use_if(world.pulleys[p].has_friction(), Feature::pulley_friction);
  }
  if (!timeline) return;
  for (std::size_t i = 0; i < timeline->pins.size(); ++i) at(Use::At::pin, i)(true, Feature::pin);
  for (std::size_t i = 0; i < timeline->cuts.size(); ++i) at(Use::At::cut, i)(true, Feature::cut);
}

Features features(const World& world, const Timeline* timeline) {
  Features all;
  each_use(world, timeline, [&](const Use& use) { all |= use.feature; });
  return all;
}

/// Whether a use concerns a connector.
bool is_on(const World& world, const Use& use, std::size_t connector, const Timeline* timeline) {
  switch (use.at) {
    case Use::At::connector:
      return use.index == connector;
    case Use::At::joint:
      return std::ranges::any_of(world.joints[use.index].particles, [&](const auto& particle) {
        return particle.connector == connector;
      });
    case Use::At::pulley:
      return world.pulleys[use.index].from == connector || world.pulleys[use.index].to == connector;
    case Use::At::bead_pair:
      return world.bead_pairs[use.index].connector == connector;
    case Use::At::connector_pair:
      return world.connector_pairs[use.index].a == connector ||
             world.connector_pairs[use.index].b == connector;
    case Use::At::pin:
      return timeline->pins[use.index].connector == connector;
    case Use::At::cut:
      return timeline->cuts[use.index].connector == connector;
    default:
      return false;
  }
}

/// The first two uses of these features within what `within` says.
std::optional<Refusal> first_pair(const World& world, const std::vector<Use>& all, Feature a,
                                  Feature b, const Apart& apart, const Timeline* timeline) {
  const auto first = [&](Feature feature, std::optional<std::size_t> connector) {
    return std::ranges::find_if(all, [&](const Use& use) {
      return use.feature == feature && (!connector || is_on(world, use, *connector, timeline));
    });
  };
  if (apart.within == Apart::Within::world) {
    return Refusal{*first(a, {}), *first(b, {}), apart.reason};
  }
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const auto one = first(a, c), other = first(b, c);
    if (one != all.end() && other != all.end()) return Refusal{*one, *other, apart.reason};
  }
  return std::nullopt;
}

/// The first pair of features of `used` in an entry for which `take` returns something.
auto find_pair(const Apart& apart, Features used, auto&& take)
    -> decltype(take(Feature{}, Feature{})) {
  const Features one = apart.one & used, other = apart.other & used;
  if (one.empty() || other.empty()) return {};
  for (std::size_t i = 0; i < kFeatureCount; ++i) {
    const auto a = static_cast<Feature>(i);
    if (!one.has(a)) continue;
    for (std::size_t k = 0; k < kFeatureCount; ++k) {
      const auto b = static_cast<Feature>(k);
      if (a == b || !other.has(b)) continue;
      if (auto found = take(a, b)) return found;
    }
  }
  return {};
}

}  // namespace

std::string_view name(Feature feature) {
  return kNames[static_cast<std::size_t>(feature)];
}

Features features(const World& world) {
  return features(world, nullptr);
}

Features features(const World& world, const Timeline& timeline) {
  return features(world, &timeline);
}

std::vector<Use> uses(const World& world, const Timeline* timeline) {
  std::vector<Use> all;
  each_use(world, timeline, [&](const Use& use) { all.push_back(use); });
  return all;
}

std::string where(const World& world, const Use& use) {
  const auto list_entry = [&](const char* list) {
    return std::string(list) + "[" + std::to_string(use.index) + "]";
  };
  const auto both = [](const std::string& a, const std::string& b) { return a + " and " + b; };
  switch (use.at) {
    case Use::At::connector:
      return "connector " + world.connectors[use.index].name;
    case Use::At::body:
      return "body " + world.bodies[use.index].name;
    case Use::At::obstacle:
      return "obstacle " + world.obstacles[use.index].name;
    case Use::At::pulley:
      return "pulley " + world.pulleys[use.index].name;
    case Use::At::body_pair: {
      const BodyPair& pair = world.pairs[use.index];
      return "bodies " + both(world.bodies[pair.a].name, world.bodies[pair.b].name);
    }
    case Use::At::bead_pair: {
      const BeadPair& pair = world.bead_pairs[use.index];
      return both("connector " + world.connectors[pair.connector].name,
                  "body " + world.bodies[pair.body].name);
    }
    case Use::At::connector_pair: {
      const ConnectorPair& pair = world.connector_pairs[use.index];
      const std::string &a = world.connectors[pair.a].name, &b = world.connectors[pair.b].name;
      return pair.a == pair.b ? "connector " + a : "connectors " + both(a, b);
    }
    case Use::At::joint: {
      const Joint& joint = world.joints[use.index];
      const auto connector = [&](const Joint::Particle& at) {
        return world.connectors[at.connector].name;
      };
      const std::string first = connector(joint.particles.front());
      const std::string last = connector(joint.particles.back());
      return first == last ? "connector " + first : "connectors " + both(first, last);
    }
    case Use::At::pin:
      return list_entry("pins");
    case Use::At::cut:
      return list_entry("cuts");
  }
  return {};
}

const Apart* Abilities::find_apart(Feature a, Feature b) const {
  const auto found = std::ranges::find_if(apart, [&](const Apart& entry) {
    return (entry.one.has(a) && entry.other.has(b)) || (entry.one.has(b) && entry.other.has(a));
  });
  return found == apart.end() || a == b ? nullptr : &*found;
}

std::optional<Refusal> find_refusal(const Abilities& abilities, const World& world,
                                    const Timeline* timeline) {
  const Features used = features(world, timeline), unknown = used - abilities.follows;
  const auto stands_in = [&](const Apart& apart) {
    return find_pair(apart, used, [](Feature, Feature) { return true; });
  };
  if (unknown.empty() && std::ranges::none_of(abilities.apart, stands_in)) return std::nullopt;
  const std::vector<Use> all = uses(world, timeline);
  for (std::size_t f = 0; f < kFeatureCount; ++f) {
    if (!unknown.has(static_cast<Feature>(f))) continue;
    return Refusal{*std::ranges::find(all, static_cast<Feature>(f), &Use::feature)};
  }
  for (const Apart& apart : abilities.apart) {
    const auto found = find_pair(apart, used, [&](Feature a, Feature b) {
      return first_pair(world, all, a, b, apart, timeline);
    });
    if (found) return found;
  }
  return std::nullopt;
}

std::string words(const World& world, const Refusal& refusal) {
  const auto shown = [&](const Use& use) {
    return std::string(name(use.feature)) + " (" + where(world, use) + ")";
  };
  std::string line = "does not follow " + shown(refusal.one);
  if (refusal.other) line += " together with " + shown(*refusal.other);
  if (!refusal.reason.empty()) line += ": " + std::string(refusal.reason);
  return line;
}

}  // namespace taut
