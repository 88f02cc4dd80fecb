// Where a scene file asks for the features of its world, for refusals.
#include "sim/features/features.h"

#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>

#include "scenes/reader/reader.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {
namespace {

using Keys = std::initializer_list<std::string_view>;

/// The first member that a table has, or the table itself.
const Value& member(const Value& table, Keys keys) {
  for (const std::string_view key : keys) {
    if (const Value* found = table.find(key)) return *found;
  }
  return table;
}

/// The first of a connector's ends that has the member, its member; or the table itself.
const Value& end_member(const Value& connector, Keys keys) {
  for (const char* end : {"from", "to"}) {
    const Value* table = connector.find(end);  // cords of nets have none
    if (!table) continue;
    const Value& found = member(*table, keys);
    if (&found != table) return found;
  }
  return connector;
}

const Value& key_of_connector(const Value& connector, Feature feature) {
  switch (feature) {
    case Feature::stretch:
      return member(connector, {"axial_stiffness", "material"});
    case Feature::bending:
      return member(connector, {"bending_stiffness", "material"});
    case Feature::bending_damping:
      return member(connector, {"bending_damping"});
    case Feature::rest_curvature:
      return member(connector, {"rest_curvature"});
    case Feature::twist:
      return member(connector, {"twisting_stiffness", "material"});
    case Feature::air:
      return member(connector, {"drag"});
    case Feature::taper:
      return member(connector, {"taper"});
    case Feature::clamp:
    case Feature::clamp_on_body:
      return end_member(connector, {"clamp"});
    case Feature::turning_clamp:
      return end_member(connector, {"turn"});
    case Feature::material_on_body:
    case Feature::hinge:
      return end_member(connector, {"body"});
    case Feature::strings:
      return member(connector, {"cords", "links"});
    case Feature::string_rebound:
      return member(connector, {"restitution"});
    case Feature::links_touch:
      return member(connector, {"contact"});
    case Feature::span:
      return member(connector, {"model"});
    case Feature::winch: {
      const Value& winch = end_member(connector, {"winch"});
      return &winch == &connector ? member(connector, {"over"}) : winch;
    }
    case Feature::pulley:
      return member(connector, {"over"});
    case Feature::joint:
    case Feature::loop:
    case Feature::joint_in_flow:
      return end_member(connector, {"connector"});
    default:
      return connector;
  }
}

const Value& key_of_surface(const Value& table, Feature feature) {
  if (feature == Feature::friction) return member(table, {"friction", "static_friction"});
  if (feature == Feature::restitution) return member(table, {"restitution"});
  return table;
}

bool names(const Value* list, std::string_view name) {
  return list && std::ranges::find(list->children, name, &Value::text) != list->children.end();
}

/// The table of `touching` that names a body and another body or a connector.
const Value& touching(const Document& document, std::string_view body, const char* list,
                      std::string_view other) {
  const Value& table = *document.root.find("touching");
  const auto both = [&](const Value& value) {
    return names(value.find("bodies"), body) && names(value.find(list), other);
  };
  return *std::ranges::find_if(table.children, both);
}

const Value& key_of(const Document& document, const World& world, const Use& use) {
  const auto named = [&](const char* table, const std::string& name) -> const Value& {
    return *document.root.find(table)->find(name);
  };
  const auto of_connector = [&](std::size_t connector) -> const Value& {
    return key_of_connector(connector_value(document, world.connectors[connector]), use.feature);
  };
  switch (use.at) {
    case Use::At::connector:
      return of_connector(use.index);
    case Use::At::body:
      return member(named("bodies", world.bodies[use.index].name), {"contact"});
    case Use::At::obstacle: {
      const Value& obstacle = named("obstacles", world.obstacles[use.index].name);
      if (use.feature == Feature::moving_obstacle)
        return member(obstacle, {"path", "body", "bone"});
      return key_of_surface(obstacle, use.feature);
    }
    case Use::At::joint: {
      // The end that names another connector is of any of the particles.
      const Joint& joint = world.joints[use.index];
      for (const Joint::Particle& at : joint.particles) {
        const Value& table = connector_value(document, world.connectors[at.connector]);
        const Value& key = key_of_connector(table, use.feature);
        if (&key != &table) return key;
      }
      return of_connector(joint.particles.front().connector);
    }
    case Use::At::pulley: {
      const Pulley& pulley = world.pulleys[use.index];
      if (use.feature == Feature::pulley) return of_connector(pulley.from);
      return member(named("pulleys", pulley.name),
                    use.feature == Feature::sheave ? Keys{"inertia"} : Keys{"friction", "bearing"});
    }
    case Use::At::body_pair: {
      const BodyPair& pair = world.pairs[use.index];
      return key_of_surface(
          touching(document, world.bodies[pair.a].name, "bodies", world.bodies[pair.b].name),
          use.feature);
    }
    case Use::At::bead_pair: {
      const BeadPair& pair = world.bead_pairs[use.index];
      const Value& table = touching(document, world.bodies[pair.body].name, "connectors",
                                    written_name(world.connectors[pair.connector].name));
      return use.feature == Feature::bead_pairs ? *table.find("connectors")
                                                : key_of_surface(table, use.feature);
    }
    case Use::At::connector_pair: {
      const ConnectorPair& pair = world.connector_pairs[use.index];
      const Value& first = connector_value(document, world.connectors[pair.a]);
      const Value& other = connector_value(document, world.connectors[pair.b]);
      if (first.name == other.name) {
        return use.feature == Feature::self_contact || use.feature == Feature::connector_pairs
                   ? member(first, {"touches_itself"})
                   : key_of_surface(first, use.feature);
      }
      const auto both = [&](const Value& value) {
        return names(value.find("connectors"), first.name) &&
               names(value.find("connectors"), other.name);
      };
      const Value& table = *std::ranges::find_if(document.root.find("touching")->children, both);
      return use.feature == Feature::connector_pairs ? *table.find("connectors")
                                                     : key_of_surface(table, use.feature);
    }
    case Use::At::pin:
      return document.root.find("pins")->children[use.index];
    case Use::At::cut:
      return document.root.find("cuts")->children[use.index];
  }
  return document.root;
}

std::string place_of(const Document& document, const Value& value) {
  const std::string file = value.inherited ? document.base.string() + " " : "";
  return fmt::format("{}, {}line {}", value.path, file, value.key_place.line);
}

}  // namespace

void refuse_unfollowed(const Document& document, const Scene& scene) {
  const MethodInfo& method = *find_method(scene.method.name);
  const auto refusal = find_refusal(method.abilities, scene.world, &scene.timeline);
  if (!refusal) return;
  const Value& key = key_of(document, scene.world, refusal->one);
  std::string what =
      fmt::format("the method {} does not follow {}", method.name, name(refusal->one.feature));
  if (refusal->other) {
    what += fmt::format(" together with {} ({})", name(refusal->other->feature),
                        place_of(document, key_of(document, scene.world, *refusal->other)));
  }
  if (!refusal->reason.empty()) what += fmt::format(": {}", refusal->reason);
  const std::string able = methods_that_follow(scene.world);
  document.fail_at_key(key, what + (able.empty() ? "; no method follows all of this scene"
                                                 : ", expected one of: " + able));
}

}  // namespace taut::scenes
