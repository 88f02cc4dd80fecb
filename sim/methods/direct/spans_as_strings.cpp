#include "sim/methods/direct/spans_as_strings.h"

#include <algorithm>
#include <limits>

#include "sim/methods/direct/spans.h"
#include "sim/topology/components.h"
#include "sim/world/held.h"

namespace taut::direct {
namespace {

constexpr double kNoMass = 1e-6;  // of the lightest thing

double lightest(const World& world) {
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](double mass) {
    if (mass > 0) least = std::min(least, mass);
  };
  for (const Body& body : world.bodies) take(body.mass_properties.mass);
  for (const Connector& connector : world.connectors) {
    for (const double mass : connector.particle_mass) take(mass);
  }
  return std::isfinite(least) ? least : 1;
}

}  // namespace

void SpansAsStrings::rebuild(const World& world) {
  strings_ = world;
  places_.clear();
  const double no_mass = kNoMass * lightest(world);
  std::vector<Span> spans;
  divide(world, {}, spans);
  for (const Span& span : spans) {
    const Connector& connector = world.connectors[span.connector];
    if (connector.model == ConnectorModel::links) continue;
    Connector string =
        straight_connector(connector.name.c_str(), span.length, 0, 2, Vec3::Zero(), Vec3::UnitX());
    string.pulls = true;
    string.restitution = connector.restitution;
    string.radius = connector.radius;
    string.category = connector.category;
    const std::size_t ends[] = {span.a.particle, span.b.particle};
    for (std::size_t end = 0; end < 2; ++end) {
      string.particle_mass[end] = connector.particle_mass[ends[end]];
      if (const Hold* hold = find_hold(connector, ends[end])) {
        string.holds.push_back(*hold);
        string.holds.back().particle = end;
      } else if (string.particle_mass[end] == 0) {
        string.particle_mass[end] = no_mass;
      }
    }
    std::size_t index = span.connector;
    if (span.index == 0) {
      strings_.connectors[index] = string;
    } else {
      index = strings_.connectors.size();
      strings_.connectors.push_back(string);
    }
    places_.push_back({span, index});
  }
  for (Joint& joint : strings_.joints) {
    for (Joint::Particle& at : joint.particles) {
      const Connector& connector = world.connectors[at.connector];
      if (connector.model == ConnectorModel::links || at.particle == 0) continue;
      at.particle = 1;
    }
  }
  strings_.topology = structure(strings_);
}

void SpansAsStrings::read(const World& world) {
  strings_.time = world.time;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) strings_.bodies[b] = world.bodies[b];
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    if (world.connectors[c].model != ConnectorModel::links) continue;
    strings_.connectors[c] = world.connectors[c];
  }
  for (const Place& place : places_) {
    const Connector& from = world.connectors[place.span.connector];
    Connector& to = strings_.connectors[place.string];
    to.position = {from.position[place.span.a.particle], from.position[place.span.b.particle]};
    to.velocity = {from.velocity[place.span.a.particle], from.velocity[place.span.b.particle]};
  }
}

void SpansAsStrings::write(World& world) {
  world.time = strings_.time;
  for (std::size_t b = 0; b < world.bodies.size(); ++b) world.bodies[b] = strings_.bodies[b];
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    if (world.connectors[c].model != ConnectorModel::links) continue;
    world.connectors[c] = strings_.connectors[c];
  }
  for (const Place& place : places_) {
    const Connector& from = strings_.connectors[place.string];
    Connector& to = world.connectors[place.span.connector];
    to.position[place.span.a.particle] = from.position[0];
    to.position[place.span.b.particle] = from.position[1];
    to.velocity[place.span.a.particle] = from.velocity[0];
    to.velocity[place.span.b.particle] = from.velocity[1];
  }
  place_held(world, world.time);
  for (const Place& place : places_) {
    lay_span(hanging_, world.connectors[place.span.connector], place.span, world.gravity);
  }
}

}  // namespace taut::direct
