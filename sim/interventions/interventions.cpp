#include "sim/interventions/interventions.h"

#include <algorithm>
#include <cmath>

#include "sim/interventions/renumber.h"
#include "sim/links/projection.h"
#include "sim/world/places.h"
#include "sim/world/room.h"
#include "sim/world/rotation.h"

namespace taut {
namespace {

bool on(const Connector& connector, double along) {
  return along >= 0 && along <= connector.length * (1 + kSamePlace);
}

/// The point of the way from `start` to `end` that is nearest to `to`.
Vec3 nearest(const Vec3& start, const Vec3& end, const Vec3& to) {
  const Vec3 way = end - start;
  const double length = way.squaredNorm();
  const double part = length > 0 ? std::clamp((to - start).dot(way) / length, 0.0, 1.0) : 0;
  return start + part * way;
}

/// Where a particle will be once it is drawn to what holds it, as far as that is known.
Vec3 goal(const World& world, const Attachment& to, double arrival) {
  return hold_motion(world, to, std::max(world.time, arrival)).position;
}

/// Where a place is to go, and whether it is drawn there.
struct Move {
  Vec3 now, target;
  bool drawn;
  double same;  // m
};

/// Whether one hold lets it. As far and as near as it is already is never too much: methods leave
/// links a little too long.
Outcome allowed(const World& world, const Connector& connector, const Hold& hold,
                const DistanceRange& range, const Move& move) {
  if (move.drawn && !is_prescribed(world, hold.to)) return Outcome::done;
  const Vec3& there = connector.position[hold.particle];
  const double present = (move.now - there).norm();
  for (const Vec3& from : {there, goal(world, hold.to, hold.to.approach.arrival)}) {
    const double apart = (move.target - from).norm();
    const double nearing =
        move.drawn ? (nearest(move.now, move.target, from) - from).norm() : apart;
    if (apart > std::max(range.most, present) + move.same) return Outcome::out_of_reach;
    if (nearing < std::min(range.least, present) - move.same) return Outcome::too_near;
  }
  return Outcome::done;
}

/// Whether what holds the connector elsewhere, where it is and where it is being drawn to, lets the
/// place go to `target` or, `drawn`, straight there; then free bodies follow. One pass over the
/// links, from the place to the first hold on either side that does not give way: the links beyond
/// it begin there.
Outcome reachable(const World& world, const Connector& connector, const Place& place,
                  const Vec3& target, bool drawn) {
  if (connector.stretches()) return Outcome::done;
  const auto [particle, fraction] = place;
  const Move move{between(connector.position, place), target, drawn, kSamePlace * connector.length};
  double length = 0, longest = 0;
  const auto pass = [&](double piece) {
    length += piece;
    longest = std::max(longest, piece);
  };
  const auto look = [&](const Hold& hold) {
    const double least = connector.pulls ? 0 : std::max(0.0, 2 * longest - length);
    return allowed(world, connector, hold, {least, length}, move);
  };
  const std::vector<Hold>& holds = connector.holds;
  const auto behind = std::ranges::upper_bound(holds, particle, {}, &Hold::particle);
  if (fraction > 0) pass(fraction * connector.rest[particle]);
  std::size_t k = particle;
  for (auto hold = behind; hold != holds.begin();) {
    --hold;
    for (; k > hold->particle; --k) pass(connector.rest[k - 1]);
    if (hold->particle == particle && fraction == 0) continue;
    const Outcome outcome = look(*hold);
    if (outcome != Outcome::done) return outcome;
    if (is_prescribed(world, hold->to)) break;
  }
  length = longest = 0;
  k = particle;
  if (fraction > 0) pass((1 - fraction) * connector.rest[k++]);
  for (auto hold = behind; hold != holds.end(); ++hold) {
    for (; k < hold->particle; ++k) pass(connector.rest[k]);
    const Outcome outcome = look(*hold);
    if (outcome != Outcome::done) return outcome;
    if (is_prescribed(world, hold->to)) break;
  }
  return Outcome::done;
}

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

/// Lets the hold take its particle to `to`, over a time.
void attach(World& world, Ties& ties, Connector& connector, Hold& hold, const Attachment& to,
            double over) {
  const auto index = static_cast<std::size_t>(&connector - world.connectors.data());
  Vec3& position = connector.position[hold.particle];
  Vec3& velocity = connector.velocity[hold.particle];
  hold.to = to;
  hold.to.approach = {};
  if (on_free_body(world, to)) {
    ties.held(index, to.body);
    const double mass = ties.joined_mass(world, index, hold.particle);
    if (mass > 0) load(world, ties, to.body, mass, position, velocity);
  } else if (over > 0) {
    hold.to.approach = {position - hold_motion(world, to, world.time).position, world.time,
                        world.time + over};
  }
  const PointMotion motion = hold_motion(world, hold.to, world.time);
  position = motion.position;
  velocity = motion.velocity;
  ties.place_joined(world, index, hold.particle);
}

/// How far the span around a particle that was added can go once the links beside it are one.
enum class Joined { straightens, needs_a_body, bent };

/// Holds on either side may be nearer than the links between them fold; then a free body among them
/// must give way.
Joined join(const World& world, const Connector& connector, std::size_t added) {
  std::size_t first = added, last = added;
  double length = 0, longest = connector.rest[added - 1] + connector.rest[added];
  const auto pass = [&](std::size_t link) {
    length += connector.rest[link];
    if (link != added && link + 1 != added) longest = std::max(longest, connector.rest[link]);
  };
  do pass(--first);
  while (first > 0 && !holds(connector, first));
  do pass(last++);
  while (last < connector.links() && !holds(connector, last));
  const double apart = (connector.position[last] - connector.position[first]).norm();
  const bool folds = apart >= 2 * longest - length - kSamePlace * connector.length;
  bool gives_way = false;
  for (const std::size_t end : {first, last}) {
    const auto hold = std::ranges::find(connector.holds, end, &Hold::particle);
    if (hold == connector.holds.end()) return Joined::straightens;
    gives_way |= !is_prescribed(world, hold->to);
  }
  if (folds) return Joined::straightens;
  return gives_way ? Joined::needs_a_body : Joined::bent;
}

struct PinnedHold {
  Connector* connector = nullptr;
  std::size_t hold = 0;
};

bool is_held(const World& world, const Joint& joint) {
  const Joint::Particle& leads = leader(world, joint);
  return holds(world.connectors[leads.connector], leads.particle);
}

PinnedHold find_pin(Connector& connector, std::uint64_t pin) {
  for (std::size_t h = 0; h < connector.holds.size(); ++h) {
    if (connector.holds[h].pin.number == pin) return {&connector, h};
  }
  return {};
}

/// Looks at the connector `first` before the others.
PinnedHold find_pin(World& world, std::uint64_t pin, std::size_t first) {
  if (pin == 0) return {};
  if (first < world.connectors.size()) {
    if (const PinnedHold found = find_pin(world.connectors[first], pin); found.connector) {
      return found;
    }
  }
  for (Connector& connector : world.connectors) {
    if (const PinnedHold found = find_pin(connector, pin); found.connector) return found;
  }
  return {};
}

}  // namespace

bool exists(const World& world, const Attachment& to) {
  if (!to.point.allFinite()) return false;
  if (to.kind == Attachment::Kind::path) return to.path != nullptr;
  return to.kind != Attachment::Kind::body || to.body < world.bodies.size();
}

std::string_view words(Outcome outcome) {
  switch (outcome) {
    case Outcome::done:
      return "done";
    case Outcome::no_connector:
      return "there is no such connector";
    case Outcome::outside:
      return "the place is not on the connector";
    case Outcome::no_target:
      return "what should hold it does not exist";
    case Outcome::held_there:
      return "the connector is held there already";
    case Outcome::joined_there:
      return "the connector is joined there, expected a place beside the joint";
    case Outcome::out_of_reach:
      return "it is farther from another hold than the connector is long between them";
    case Outcome::too_near:
      return "it is nearer to another hold than the links between them can fold";
    case Outcome::no_pin:
      return "there is no such pin, or it is released already";
  }
  return "";
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
  ties_.reserve(world, world.connectors.size() + cuts, pins * world.connectors.size());
  world.connectors.reserve(world.connectors.size() + cuts);
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

Pinned Interventions::pin(World& world, std::size_t index, double along) {
  if (index >= world.connectors.size()) return {Outcome::no_connector, 0};
  if (!on(world.connectors[index], along)) return {Outcome::outside, 0};
  Attachment here;
  here.point = material_point(world.connectors[index], along).position;
  return pin(world, index, along, here);
}

Pinned Interventions::pin(World& world, std::size_t index, double along, const Attachment& to,
                          double over) {
  if (index >= world.connectors.size()) return {Outcome::no_connector, 0};
  Connector& connector = world.connectors[index];
  if (!on(connector, along)) return {Outcome::outside, 0};
  if (!exists(world, to)) return {Outcome::no_target, 0};
  ties_.follow(world);
  const Place place = locate(connector, along);
  if (place.fraction == 0) {
    const auto there = hold_at(connector, place.particle);
    if (there != connector.holds.end() && there->particle == place.particle) {
      return {Outcome::held_there, 0};
    }
    const Joint* joint = ties_.find_joint(world, index, place.particle);
    if (joint && is_held(world, *joint)) return {Outcome::held_there, 0};
  }
  const Vec3 target = goal(world, to, world.time + over);
  const Outcome outcome = reachable(world, connector, place, target, over > 0);
  if (outcome != Outcome::done) return {outcome, 0};
  world.topology -= structure_of_connector(world, index);
  Hold hold;
  hold.particle = place.particle;
  if (place.fraction > 0) {
    hold.pin = add_particle(connector, place);
    ties_.particle_added(world, index, hold.particle);
    ++hold.particle;
  }
  hold.pin.number = ++world.pins;
  hold.pin.since = world.time;
  hold.pin.position = connector.position[hold.particle];
  hold.pin.velocity = connector.velocity[hold.particle];
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
  const Outcome outcome = reachable(world, *connector, {hold.particle, 0}, target, over > 0);
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

Outcome Interventions::release(World& world, std::uint64_t pin, std::size_t at) {
  ties_.follow(world);
  const auto [connector, h] = find_pin(world, pin, at);
  if (connector == nullptr) return Outcome::no_pin;
  const Hold hold = connector->holds[h];
  const PinRecord& record = hold.pin;
  const bool at_once = record.since == world.time;
  const bool last = record.topology == world.topology;
  const bool was_added = record.fraction > 0;
  const Joined span = was_added && !at_once && !connector->stretches()
                          ? join(world, *connector, hold.particle)
                          : Joined::straightens;
  if (span == Joined::bent) return Outcome::too_near;
  const auto index = static_cast<std::size_t>(connector - world.connectors.data());
  world.topology -= structure_of_connector(world, index);
  connector->holds.erase(connector->holds.begin() + static_cast<std::ptrdiff_t>(h));
  let_go(world, index, hold.to);
  if (at_once) {
    connector->position[hold.particle] = record.position;
    connector->velocity[hold.particle] = record.velocity;
    if (last && on_free_body(world, hold.to)) {
      Body& body = world.bodies[hold.to.body];
      body.position = record.body_position;
      body.velocity = record.body_velocity;
      body.spin = record.body_spin;
    }
  }
  if (was_added) {
    remove_particle(*connector, hold.particle, record.link_rest);
    ties_.particle_removed(world, index, hold.particle);
  } else {
    ties_.place_joined(world, index, hold.particle);
  }
  const bool joined = was_added && !at_once && !world.joints.empty() && !connector->stretches();
  if (span == Joined::needs_a_body || joined) {
    restore_lengths(world);
  } else if (was_added && !at_once && !connector->stretches()) {
    restorer_.restore(*connector, hold.particle - 1);
  }
  world.topology += structure_of_connector(world, index);
  ties_.followed(world);
  return Outcome::done;
}

}  // namespace taut
