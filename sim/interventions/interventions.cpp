#include "sim/interventions/interventions.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/interventions/feasible.h"
#include "sim/interventions/pinned.h"
#include "sim/interventions/renumber.h"
#include "sim/motion/rotation.h"
#include "sim/topology/room.h"
#include "sim/world/places.h"

namespace taut {
namespace {

bool on_free_body(const World& world, const Attachment& to) {
  return !is_prescribed(world, to);
}

/// Gives the body the mass of a particle that it has begun to hold: both keep their momentum.
void load(World& world, const Ties& ties, std::size_t index, double mass, const Vec3& position,
          const Vec3& velocity) {
  Body& body = world.bodies[index];
  const Vec3 linear = body.mass_properties.mass * body.velocity + mass * velocity;
  Vec3 angular = body.mass_properties.mass * body.position.cross(body.velocity) +
                 body.world_inertia() * body.spin + mass * position.cross(velocity);
  reweigh_and_renumber(world, ties, index);
  body.velocity = linear / body.mass_properties.mass;
  angular -= body.position.cross(linear);
  body.spin = FreeRotation(body.mass_properties.inertia).inverse_inertia(body.rotation) * angular;
}

/// Makes the hold a new pin, before it takes its particle anywhere.
void record(World& world, const Connector& connector, Hold& hold) {
  hold.pin.number = ++world.pins;
  hold.pin.since = world.time;
  hold.pin.position = connector.position[hold.particle];
  hold.pin.velocity = connector.velocity[hold.particle];
}

/// Lets a hold that is prescribed, or of a free body, take its particle there, over a time.
void take(const World& world, Connector& connector, Hold& hold, double over) {
  Vec3& position = connector.position[hold.particle];
  hold.to.approach = {};
  if (over > 0 && is_prescribed(world, hold.to)) {
    const Vec3 lag = position - hold_motion(world, hold.to, world.time).position;
    hold.to.approach = {lag, world.time, world.time + over};
  }
  const PointMotion motion = hold_motion(world, hold.to, world.time);
  position = motion.position;
  connector.velocity[hold.particle] = motion.velocity;
}

/// Lets the hold take its particle to `to`, over a time.
void attach(World& world, Ties& ties, Connector& connector, Hold& hold, const Attachment& to,
            double over) {
  const auto index = static_cast<std::size_t>(&connector - world.connectors.data());
  hold.to = to;
  if (on_free_body(world, to)) {
    ties.held(index, to.body);
    const double mass = ties.joined_mass(world, index, hold.particle);
    const std::size_t i = hold.particle;
    if (mass > 0) load(world, ties, to.body, mass, connector.position[i], connector.velocity[i]);
  }
  take(world, connector, hold, over);
  ties.place_joined(world, index, hold.particle);
}

}  // namespace

bool exists(const World& world, const Attachment& to) {
  if (!to.point.allFinite()) return false;
  if (to.kind == Attachment::Kind::path) return to.path != nullptr;
  return to.kind != Attachment::Kind::body || to.body < world.bodies.size();
}

PointMotion material_point(const Connector& connector, double along) {
  const Place place = locate(connector, along);
  return {between(connector.position, place), between(connector.velocity, place), Vec3::Zero()};
}

void Interventions::reserve(World& world, std::size_t pins, std::size_t cuts) {
  const auto make_room = [](Connector& connector, std::size_t particles, std::size_t holds) {
    connector.position.reserve(particles);
    connector.velocity.reserve(particles);
    connector.particle_mass.reserve(particles);
    connector.rest.reserve(particles);
    if (!connector.sections.empty()) connector.sections.reserve(particles);
    connector.holds.reserve(holds);
  };
  std::size_t particles = 0;
  for (const Connector& connector : world.connectors) particles += connector.particles();
  const double added = double(pins) * (double(cuts) + 1) + 2 * double(cuts);
  const double all = double(particles) + double(world.connectors.size()) * added;
  if ((double(pins) + double(cuts)) * all > kMostRoom) return;
  const std::size_t holds = (pins + 2) * (cuts + 1);
  std::size_t most = 0, longest_name = 0;
  for (Connector& connector : world.connectors) {
    // A cut adds a particle where none is, and both parts have one there.
    const std::size_t n = connector.particles() + pins * (cuts + 1) + 2 * cuts;
    make_room(connector, n, holds);
    most = std::max(most, n);
    longest_name = std::max(longest_name, connector.name.size());
  }
  restorer_.reserve(most);
  released_.reserve(1);
  gone_.reserve(1);
  gone_from_.reserve(1);
  ties_.reserve(world, world.connectors.size() + cuts, pins * world.connectors.size());
  world.connectors.reserve(world.connectors.size() + cuts);
  if (!world.bead_pairs.empty()) {
    world.bead_pairs.reserve(world.bead_pairs.size() + cuts * world.bodies.size());
  }
  original_.reserve(world.connectors.size() + cuts);
  cut_off_.reserve(world.connectors.size() + cuts);
  spare_.reserve(cuts);
  while (spare_.size() < cuts) {
    spare_.emplace_back();
    make_room(spare_.back(), most, holds);
    if (has_materials(world)) spare_.back().sections.reserve(most);
    spare_.back().name.reserve(longest_name + cuts);
  }
}

/// Whether something holds the place, or what is joined to it there.
bool Interventions::is_held(const World& world, std::size_t index, const Place& place) const {
  if (place.fraction > 0) return false;
  if (holds(world.connectors[index], place.particle)) return true;
  const Joint* joint = ties_.find_joint(world, index, place.particle);
  if (joint == nullptr) return false;
  const Joint::Particle& leads = leader(world, *joint);
  return holds(world.connectors[leads.connector], leads.particle);
}

Pinned Interventions::pin(World& world, std::size_t index, double along) {
  if (index >= world.connectors.size()) return {Outcome::no_connector, 0};
  if (world.connectors[index].winch) return {Outcome::has_winch, 0};
  if (!on(world.connectors[index], along)) return {Outcome::outside, 0};
  Attachment here;
  here.point = material_point(world.connectors[index], along).position;
  return pin(world, index, along, here);
}

Pinned Interventions::pin(World& world, std::size_t index, double along, const Attachment& to,
                          double over) {
  if (index >= world.connectors.size()) return {Outcome::no_connector, 0};
  Connector& connector = world.connectors[index];
  if (connector.winch) return {Outcome::has_winch, 0};
  if (!on(connector, along)) return {Outcome::outside, 0};
  if (!exists(world, to)) return {Outcome::no_target, 0};
  ties_.follow(world);
  const Place place = locate(connector, along);
  if (is_held(world, index, place)) return {Outcome::held_there, 0};
  const Vec3 target = goal(world, to, world.time + over);
  const Move way{between(connector.position, place), target, over > 0};
  const Outcome outcome = feasible(world, connector, place, way);
  if (outcome != Outcome::done) return {outcome, 0};
  world.topology -= structure_of_connector(world, index);
  Hold hold;
  hold.particle = place.particle;
  if (place.fraction > 0) {
    hold.pin = add_particle(connector, place);
    ties_.particles_added(world, index, {&place, 1});
    ++hold.particle;
  }
  record(world, connector, hold);
  if (on_free_body(world, to)) {
    const Body& body = world.bodies[to.body];
    hold.pin.body_position = body.position;
    hold.pin.body_velocity = body.velocity;
    hold.pin.body_spin = body.spin;
  }
  hold.to = to;  // before attach(): a free body is weighed with all it holds
  connector.holds.insert(hold_at(connector, hold.particle), hold);
  const auto held = hold_at(connector, hold.particle);
  attach(world, ties_, connector, *held, to, over);
  world.topology += structure_of_connector(world, index);
  ties_.followed(world);
  held->pin.topology = world.topology;
  return {Outcome::done, held->pin.number};
}

std::vector<std::uint64_t> Interventions::pin(World& world, std::size_t index,
                                              std::span<const NewPin> pins) {
  if (index >= world.connectors.size()) return {};
  ties_.follow(world);
  Connector& connector = world.connectors[index];
  std::vector<std::size_t> order(pins.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return pins[i].along; });
  std::vector<Hold> added(pins.size());
  std::vector<Place> places;  // of the particles to be added
  Walk walk;
  double last = -INFINITY;  // m
  for (const std::size_t i : order) {
    const NewPin& pin = pins[i];
    if (!on(connector, pin.along) || pin.along - last <= kSamePlace * connector.length) return {};
    last = pin.along;
    const Place place = locate(connector, pin.along, walk);
    if (is_held(world, index, place)) return {};
    Attachment& to = added[i].to;
    if (pin.to) to = *pin.to;
    if (!pin.to) to.point = between(connector.position, place);
    if (!exists(world, to) || !is_prescribed(world, to)) return {};
    if (place.fraction > 0) places.push_back(place);
    added[i].pin.fraction = place.fraction;
    added[i].particle = place.particle + places.size();
  }
  const Connector before = connector;
  const std::uint64_t topology = world.topology, number = world.pins;
  world.topology -= structure_of_connector(world, index);
  std::vector<PinRecord> records(places.size());
  add_particles(connector, places, records);
  ties_.particles_added(world, index, places);
  std::vector<std::size_t> particles;  // that were added
  for (const std::size_t i : order) {
    if (added[i].pin.fraction == 0) continue;
    added[i].pin = records[particles.size()];
    particles.push_back(added[i].particle);
  }
  for (std::size_t i = 0; i < pins.size(); ++i) {
    record(world, connector, added[i]);
    take(world, connector, added[i], pins[i].over);
  }
  for (const std::size_t i : order) connector.holds.push_back(added[i]);
  std::ranges::inplace_merge(connector.holds, connector.holds.begin() + std::ssize(before.holds),
                             {}, &Hold::particle);
  for (std::size_t i = 0; i < pins.size(); ++i) {
    const double arrival = world.time + pins[i].over;
    const Move way{added[i].pin.position, goal(world, added[i].to, arrival), pins[i].over > 0};
    if (feasible(world, connector, {added[i].particle, 0}, way) == Outcome::done) continue;
    ties_.particles_removed(world, index, particles);
    connector = before;
    world.topology = topology;
    world.pins = number;
    return {};
  }
  for (const Hold& hold : added) {
    if (hold.pin.fraction == 0) ties_.place_joined(world, index, hold.particle);
  }
  world.topology += structure_of_connector(world, index);
  ties_.followed(world);
  std::vector<std::uint64_t> numbers;
  for (const Hold& hold : added) numbers.push_back(hold.pin.number);
  for (Hold& hold : connector.holds) {
    if (hold.pin.number > number) hold.pin.topology = world.topology;
  }
  return numbers;
}

/// Weighs a free body that holds the connector no more at a place.
void Interventions::let_go(World& world, std::size_t connector, const Attachment& by) {
  if (is_prescribed(world, by)) return;
  ties_.let_go(connector, by.body);
  reweigh_and_renumber(world, ties_, by.body);
}

Outcome Interventions::move(World& world, std::uint64_t pin, const Attachment& to, double over) {
  ties_.follow(world);
  const auto [connector, h] = find_pin(world, pin, 0);
  if (connector == nullptr) return Outcome::no_pin;
  if (!exists(world, to)) return Outcome::no_target;
  Hold& hold = connector->holds[h];
  const Vec3 target = goal(world, to, world.time + over);
  const Move way{connector->position[hold.particle], target, over > 0};
  const Outcome outcome = feasible(world, *connector, {hold.particle, 0}, way);
  if (outcome != Outcome::done) return outcome;
  const auto index = static_cast<std::size_t>(connector - world.connectors.data());
  world.topology -= structure_of_connector(world, index);
  const Attachment from = hold.to;
  hold.to = {};
  let_go(world, index, from);
  attach(world, ties_, *connector, hold, to, over);
  hold.pin.since = -INFINITY;  // what was before the pin is not what was before the move
  world.topology += structure_of_connector(world, index);
  ties_.followed(world);
  return Outcome::done;
}

}  // namespace taut
