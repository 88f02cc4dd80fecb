#include "sim/interventions/interventions.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <sstream>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/links/tension.h"
#include "sim/motion/printable.h"
#include "sim/motion/rotation.h"
#include "sim/topology/components.h"
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
    case Outcome::has_winch:
      return "the connector has a winch or passes a pulley, expected one that keeps its length";
  }
  return "";
}

// Cutting a connector in two.

namespace {

/// Where a link ends at the particle `end` that was added to cut it there, pins that stand on its
/// parts stand on links of their own now. `cut` is what a pin at the cut would have recorded.
void rebase_pins(Connector& connector, std::size_t end, const PinRecord& cut) {
  for (std::size_t i = end; i-- > 0;) {
    PinRecord* pin = added_for(connector, i);
    if (pin == nullptr) break;
    pin->fraction /= cut.fraction;
    pin->link_rest *= cut.fraction;
  }
  for (std::size_t i = end + 1; i < connector.particles(); ++i) {
    PinRecord* pin = added_for(connector, i);
    if (pin == nullptr) break;
    pin->fraction = (pin->fraction - cut.fraction) / (1 - cut.fraction);
    pin->link_rest *= 1 - cut.fraction;
  }
}

/// The particle nearest to `start` that has mass, going by `way` (1 or -1); `start` where none has.
std::size_t massive(const Connector& connector, std::size_t start, std::ptrdiff_t way) {
  const auto count = static_cast<std::ptrdiff_t>(connector.particles());
  for (auto i = static_cast<std::ptrdiff_t>(start); i >= 0 && i < count; i += way) {
    const auto particle = static_cast<std::size_t>(i);
    if (connector.particle_mass[particle] > 0) return particle;
  }
  return start;
}

/// Gives a particle that was added without mass a part of its neighbours', at most half of it: as
/// much from either as keeps their centre. It takes their velocity with it, so that momentum stays.
/// Pins that were added have no mass to give: then a neighbour that has gives alone, as one that is
/// free does beside one that is held.
void share_mass(World& world, const Ties& ties, Connector& connector, std::size_t added) {
  const std::size_t before = massive(connector, added - 1, -1);
  const std::size_t after = massive(connector, added + 1, 1);
  const bool near_before = before + 1 == added, near_after = after == added + 1;
  const bool free_before = !holds(connector, before), free_after = !holds(connector, after);
  double part = connector.rest[added - 1] / (connector.rest[added - 1] + connector.rest[added]);
  if (near_before != near_after) {
    part = near_after ? 1 : 0;
  } else if (free_before != free_after) {
    part = free_after ? 1 : 0;
  }
  std::vector<double>& mass = connector.particle_mass;
  double most = INFINITY;
  if (part < 1) most = std::min(most, mass[before]);
  if (part > 0) most = std::min(most, mass[after]);
  mass[added] = most / 2;
  mass[before] -= (1 - part) * mass[added];
  mass[after] -= part * mass[added];
  connector.velocity[added] = (1 - part) * connector.velocity[before];
  connector.velocity[added] += part * connector.velocity[after];
  for (const Hold& hold : connector.holds) {
    if (hold.particle != before && hold.particle != after) continue;
    if (!is_prescribed(world, hold.to)) reweigh_and_renumber(world, ties, hold.to.body);
  }
}

/// The name of the k-th part that is cut off: NAME', NAME'', NAME''', NAME'4 and so on.
void add_mark(std::string& name, std::size_t k) {
  constexpr std::size_t kMarks = 3;
  if (k <= kMarks) return void(name.append(k, '\''));
  char digits[24];
  const auto end = std::to_chars(digits, digits + sizeof digits, k).ptr;
  name += '\'';
  name.append(digits, end);
}

}  // namespace

void Interventions::follow_parts(std::vector<std::size_t> originals) {
  original_ = std::move(originals);
  cut_off_.assign(original_.size(), 0);
  for (std::size_t c = 0; c < original_.size(); ++c) {
    if (original_[c] != c) ++cut_off_[original_[c]];
  }
}

/// Why the connector cannot be cut at the place, `along` (m) it.
Outcome Interventions::why_not_cut(const World& world, std::size_t index, double along,
                                   const Place& place) {
  const Connector& connector = world.connectors[index];
  const double end = kSamePlace * connector.length;
  if (!(along > end && along < connector.length - end)) return Outcome::outside;
  if (place.fraction > 0) return Outcome::done;
  if (holds(connector, place.particle)) return Outcome::held_there;
  return ties_.find_joint(world, index, place.particle) ? Outcome::joined_there : Outcome::done;
}

/// Adds an empty connector for what is cut off.
void Interventions::add_part(World& world, std::size_t index) {
  const bool has_room = !spare_.empty();
  if (!has_room) spare_.emplace_back();
  world.connectors.push_back(std::move(spare_.back()));
  spare_.pop_back();
  while (original_.size() + 1 < world.connectors.size()) {
    original_.push_back(original_.size());
    cut_off_.push_back(0);
  }
  const std::size_t original = original_[index];
  original_.push_back(original);
  cut_off_.push_back(0);
  Connector& second = world.connectors.back();
  second.name = world.connectors[original].name;
  add_mark(second.name, ++cut_off_[original]);
  ties_.connector_added();
  for (std::size_t p = 0, pairs = world.bead_pairs.size(); p < pairs; ++p) {
    if (world.bead_pairs[p].connector != index) continue;
    world.bead_pairs.push_back(world.bead_pairs[p]);
    world.bead_pairs.back().connector = world.connectors.size() - 1;
    world.topology += structure_of_bead_pair(world, world.bead_pairs.size() - 1);
  }
  const auto pair_connectors = [&](ConnectorPair pair, std::size_t a, std::size_t b) {
    pair.a = a;
    pair.b = b;
    world.connector_pairs.push_back(pair);
    world.topology += structure_of_connector_pair(world, world.connector_pairs.size() - 1);
  };
  const std::size_t made = world.connectors.size() - 1;
  for (std::size_t p = 0, pairs = world.connector_pairs.size(); p < pairs; ++p) {
    const ConnectorPair pair = world.connector_pairs[p];
    if (pair.a == index) pair_connectors(pair, made, pair.b);
    if (pair.b == index) pair_connectors(pair, pair.a == index ? made : pair.a, made);
  }
}

Divided Interventions::cut(World& world, std::size_t index, double along) {
  if (index >= world.connectors.size()) return {Outcome::no_connector, 0};
  if (world.connectors[index].winch) return {Outcome::has_winch, 0};
  ties_.follow(world);
  const Place place = locate(world.connectors[index], along);
  const Outcome outcome = why_not_cut(world, index, along, place);
  if (outcome != Outcome::done) return {outcome, 0};
  const std::size_t added = world.connectors.size();
  add_part(world, index);
  divide(world, index, along, added);
  ties_.followed(world);
  return {Outcome::done, added};
}

bool Interventions::cut(World& world, std::size_t index, std::span<const double> along) {
  if (index >= world.connectors.size()) return false;
  ties_.follow(world);
  std::vector<std::size_t> order(along.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t i) { return along[i]; });
  const Connector& connector = world.connectors[index];
  Walk walk;
  double last = 0;
  for (const std::size_t i : order) {
    const Place place = locate(connector, along[i], walk);
    if (why_not_cut(world, index, along[i], place) != Outcome::done) return false;
    if (along[i] - std::exchange(last, along[i]) <= kSamePlace * connector.length) return false;
  }
  const std::size_t parts = world.connectors.size();
  for (std::size_t i = 0; i < along.size(); ++i) add_part(world, index);
  divide(world, index, 0, parts, along, order);
  ties_.followed(world);
  return true;
}

/// Divides a part that begins at `start` (m) at places in their order: in the middle first, so that
/// few cuts move much. The part cut off at the k-th becomes connector `parts` + k.
void Interventions::divide(World& world, std::size_t index, double start, std::size_t parts,
                           std::span<const double> along, std::span<const std::size_t> order) {
  if (order.empty()) return;
  const std::size_t middle = order.size() / 2, k = order[middle];
  divide(world, index, along[k] - start, parts + k);
  divide(world, index, start, parts, along, order.first(middle));
  divide(world, parts + k, along[k], parts, along, order.subspan(middle + 1));
}

/// Moves what is behind `along` (m) to the empty connector `part`.
void Interventions::divide(World& world, std::size_t index, double along, std::size_t part) {
  world.topology -= structure_of_connector(world, index);
  Connector& first = world.connectors[index];
  Connector& second = world.connectors[part];
  const bool has_room = second.position.capacity() > 0;
  const Place place = locate(first, along);
  std::size_t at = place.particle;
  if (place.fraction > 0) {
    at = place.particle + 1;
    rebase_pins(first, at, add_particle(first, place));
    ties_.particles_added(world, index, {&place, 1});
    share_mass(world, ties_, first, at);
  }
  first.particle_mass[at] /= 2;
  second.end_place = {++world.end_places, first.end_place[1]};
  first.end_place[1] = world.end_places;
  second.restitution = first.restitution;
  second.model = first.model;
  second.pulls = first.pulls;
  // The longer part keeps the arrays: many cuts, one behind the other, take no more room.
  const bool head_is_shorter = 2 * at < first.particles();
  const auto move_tail = [&](auto& from, auto& to, std::size_t start) {
    const auto middle = from.begin() + static_cast<std::ptrdiff_t>(start);
    if (head_is_shorter && to.capacity() < from.size()) {
      to.assign(from.begin(), middle);
      from.erase(from.begin(), middle);
      std::swap(from, to);
    } else {
      to.assign(middle, from.end());
      from.resize(start);
    }
  };
  move_tail(first.rest, second.rest, at);
  second.radius = first.radius;
  second.category = first.category;
  second.links_touch = first.links_touch;
  second.drag = first.drag;
  second.applied_force = first.applied_force;
  second.breaks_at = first.breaks_at;
  if (!first.sections.empty()) move_tail(first.sections, second.sections, at);
  move_tail(first.position, second.position, at);
  move_tail(first.velocity, second.velocity, at);
  move_tail(first.particle_mass, second.particle_mass, at);
  first.position.push_back(second.position.front());
  first.velocity.push_back(second.velocity.front());
  first.particle_mass.push_back(second.particle_mass.front());
  const auto tail = hold_at(first, at);
  second.holds.assign(tail, first.holds.end());
  first.holds.erase(tail, first.holds.end());
  for (Hold& hold : second.holds) hold.particle -= at;
  ties_.connector_divided(world, index, at, part);
  second.length = first.length - along;
  second.mass = first.mass * second.length / first.length;
  first.mass -= second.mass;
  first.length = along;
  if (!has_room) {
    fit(first);
    fit(second);
  }
  world.topology += structure_of_connector(world, index) + structure_of_connector(world, part);
}

// Releasing pins.

namespace {

const Hold* find_in(std::span<const Hold> holds, std::size_t particle) {
  const auto hold = std::ranges::lower_bound(holds, particle, {}, &Hold::particle);
  return hold != holds.end() && hold->particle == particle ? &*hold : nullptr;
}

/// The span around a particle as it will be once what holds `released` (rising) is gone, and the
/// particles that were added for it.
JoinedSpan span_around(const Connector& connector, std::size_t particle,
                       std::span<const Hold> released) {
  const auto stays = [&](std::size_t i) { return holds(connector, i) && !find_in(released, i); };
  JoinedSpan span{particle, particle, 0, 0};
  while (span.first > 0 && !stays(span.first)) --span.first;
  while (span.last < connector.links() && !stays(span.last)) ++span.last;
  double link = 0;  // m, of what will be one
  for (std::size_t k = span.first; k < span.last; ++k) {
    span.length += connector.rest[k];
    link += connector.rest[k];
    const Hold* next = find_in(released, k + 1);
    if (next && next->pin.fraction > 0) continue;
    span.longest = std::max(span.longest, link);
    link = 0;
  }
  return span;
}

/// Marks all connectors and free bodies that are tied to those that are marked.
void mark_tied(const World& world, std::vector<char>& connectors, std::vector<char>& bodies) {
  bool more = true;
  const auto mark = [&](char& tied) { more |= std::exchange(tied, 1) == 0; };
  while (std::exchange(more, false)) {
    for (std::size_t c = 0; c < connectors.size(); ++c) {
      for (const Hold& hold : world.connectors[c].holds) {
        if (is_prescribed(world, hold.to)) continue;
        if (connectors[c]) mark(bodies[hold.to.body]);
        if (bodies[hold.to.body]) mark(connectors[c]);
      }
    }
    for (const Joint& joint : world.joints) {
      const bool any = std::ranges::any_of(joint.particles, [&](const Joint::Particle& at) {
        return connectors[at.connector] != 0;
      });
      for (const Joint::Particle& at : joint.particles) {
        if (any) mark(connectors[at.connector]);
      }
    }
    for (const Pulley& pulley : world.pulleys) {
      if (connectors[pulley.from]) mark(connectors[pulley.to]);
      if (connectors[pulley.to]) mark(connectors[pulley.from]);
    }
  }
}

/// restore_lengths() of everything tied to a connector: the rest may stand at an earlier time
/// (Islands).
void restore_tied(World& world, std::size_t connector) {
  std::vector<char> connectors(world.connectors.size(), 0), bodies(world.bodies.size(), 0);
  connectors[connector] = 1;
  mark_tied(world, connectors, bodies);
  World part;
  part.time = world.time;
  part.bodies = world.bodies;
  std::vector<std::size_t> own(connectors.size());  // index in the part
  for (std::size_t c = 0; c < connectors.size(); ++c) {
    if (!connectors[c]) continue;
    own[c] = part.connectors.size();
    part.connectors.push_back(world.connectors[c]);
  }
  for (const Joint& joint : world.joints) {
    if (!connectors[joint.particles[0].connector]) continue;
    for (Joint::Particle& at : part.joints.emplace_back(joint).particles) {
      at.connector = own[at.connector];
    }
  }
  for (const Pulley& pulley : world.pulleys) {
    if (!connectors[pulley.from]) continue;
    Pulley& made = part.pulleys.emplace_back(pulley);
    made.from = own[pulley.from];
    made.to = own[pulley.to];
  }
  if (!restore_lengths(part)) return;
  for (std::size_t c = 0; c < connectors.size(); ++c) {
    if (connectors[c]) world.connectors[c].position = part.connectors[own[c]].position;
  }
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!bodies[b]) continue;
    world.bodies[b].position = part.bodies[b].position;
    world.bodies[b].rotation = part.bodies[b].rotation;
  }
}

}  // namespace

Outcome Interventions::release(World& world, std::uint64_t pin, std::size_t at) {
  ties_.follow(world);
  const auto [connector, h] = find_pin(world, pin, at);
  if (connector == nullptr) return Outcome::no_pin;
  released_.assign(1, connector->holds[h]);
  return drop(world, static_cast<std::size_t>(connector - world.connectors.data()));
}

Outcome Interventions::release(World& world, std::size_t index,
                               std::span<const std::uint64_t> pins) {
  if (index >= world.connectors.size()) return Outcome::no_connector;
  ties_.follow(world);
  std::vector<std::uint64_t> numbers(pins.begin(), pins.end());
  std::ranges::sort(numbers);
  released_.clear();
  for (const Hold& hold : world.connectors[index].holds) {
    const std::uint64_t number = hold.pin.number;
    if (number > 0 && std::ranges::binary_search(numbers, number)) released_.push_back(hold);
  }
  return released_.size() == pins.size() ? drop(world, index) : Outcome::no_pin;
}

/// Lets go the holds of the connector that are in released_.
Outcome Interventions::drop(World& world, std::size_t index) {
  Connector& connector = world.connectors[index];
  const auto left_links = [&](const Hold& hold) {  // that are not what they were before it
    return hold.pin.fraction > 0 && hold.pin.since != world.time && !connector.stretches() &&
           !connector.pulls;
  };
  bool needs_a_body = false;
  std::size_t seen = 0;
  for (const Hold& hold : released_) {
    if (!left_links(hold) || hold.particle < seen) continue;
    const JoinedSpan span = span_around(connector, hold.particle, released_);
    seen = span.last;
    const Joined joined = join(world, connector, span);
    if (joined == Joined::bent) return Outcome::too_near;
    needs_a_body |= joined == Joined::needs_a_body || !world.joints.empty();
  }
  const std::uint64_t topology = world.topology;
  world.topology -= structure_of_connector(world, index);
  std::erase_if(connector.holds,
                [&](const Hold& hold) { return find_in(released_, hold.particle); });
  gone_.clear();
  gone_from_.clear();
  for (const Hold& hold : released_) {
    let_go(world, index, hold.to);
    const PinRecord& record = hold.pin;
    if (record.since == world.time) {
      connector.position[hold.particle] = record.position;
      connector.velocity[hold.particle] = record.velocity;
      if (record.topology == topology && !is_prescribed(world, hold.to)) {
        Body& body = world.bodies[hold.to.body];
        body.position = record.body_position;
        body.velocity = record.body_velocity;
        body.spin = record.body_spin;
      }
    }
    if (record.fraction > 0) {
      gone_.push_back(hold.particle);
      gone_from_.push_back(record.link_rest);
    }
  }
  remove_particles(connector, gone_, gone_from_);
  ties_.particles_removed(world, index, gone_);
  std::size_t gone = 0;
  seen = 0;
  for (const Hold& hold : released_) {
    const std::size_t there = hold.particle - gone;
    if (hold.pin.fraction == 0) {
      ties_.place_joined(world, index, there);
      continue;
    }
    ++gone;
    if (needs_a_body || !left_links(hold) || there - 1 < seen) continue;
    seen = restorer_.restore(connector, there - 1);
  }
  if (needs_a_body) restore_tied(world, index);
  world.topology += structure_of_connector(world, index);
  ties_.followed(world);
  return Outcome::done;
}

namespace {

/// The point of the way from `start` to `end` that is nearest to `to`.
Vec3 nearest(const Vec3& start, const Vec3& end, const Vec3& to) {
  const Vec3 way = end - start;
  const double length = way.squaredNorm();
  const double part = length > 0 ? std::clamp((to - start).dot(way) / length, 0.0, 1.0) : 0;
  return start + part * way;
}

/// Whether one hold lets it. As far and as near as it is already is never too much: methods leave
/// links a little too long.
Outcome allowed(const World& world, const Connector& connector, const Hold& hold,
                const DistanceRange& range, const Move& move) {
  const double same = kSamePlace * connector.length;
  if (move.drawn && !is_prescribed(world, hold.to)) return Outcome::done;
  const Vec3& there = connector.position[hold.particle];
  const double present = (move.now - there).norm();
  for (const Vec3& from : {there, goal(world, hold.to, hold.to.approach.arrival)}) {
    const double apart = (move.target - from).norm();
    const double nearing =
        move.drawn ? (nearest(move.now, move.target, from) - from).norm() : apart;
    if (apart > std::max(range.most, present) + same) return Outcome::out_of_reach;
    if (nearing < std::min(range.least, present) - same) return Outcome::too_near;
  }
  return Outcome::done;
}

}  // namespace

bool on(const Connector& connector, double along) {
  return along >= 0 && along <= connector.length * (1 + kSamePlace);
}

Vec3 goal(const World& world, const Attachment& to, double arrival) {
  return hold_motion(world, to, std::max(world.time, arrival)).position;
}

Outcome feasible(const World& world, const Connector& connector, const Place& place,
                 const Move& move) {
  if (connector.stretches()) return Outcome::done;
  const auto [particle, fraction] = place;
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

Joined join(const World& world, const Connector& connector, const JoinedSpan& span) {
  const double apart = (connector.position[span.last] - connector.position[span.first]).norm();
  const bool folds = apart >= 2 * span.longest - span.length - kSamePlace * connector.length;
  bool gives_way = false;
  for (const std::size_t end : {span.first, span.last}) {
    const Hold* hold = find_hold(connector, end);
    if (hold == nullptr) return Joined::straightens;
    gives_way |= !is_prescribed(world, hold->to);
  }
  if (folds) return Joined::straightens;
  return gives_way ? Joined::needs_a_body : Joined::bent;
}

// Finds the flaws of a timeline in a sweep over its times: only neighbours along a connector are
// looked at, as no two holds are too far apart where no neighbours between them are.

namespace {

/// Something that holds a connector for a time.
struct Known {
  double along = 0;            // m
  double from = 0, until = 0;  // s
  const Attachment* to = nullptr;
  std::size_t pin = 0;  // index + 1 of the timeline's pin; 0: an end of the connector
};

/// Lengths along a connector, without a pass over its links for every question.
class Ruler {
 public:
  explicit Ruler(const Connector& connector) : connector_(connector) {
    start_.reserve(connector.particles());
    start_.push_back(0);
    for (const double rest : connector.rest) {
      start_.push_back(start_.back() + rest);
      longest_ = std::max(longest_, rest);
    }
  }

  double along(std::size_t particle) const { return start_[particle]; }

  /// Of two places on the connector.
  DistanceRange range(double along, double other) const {
    const auto [low, high] = std::minmax(along, other);
    if (2 * longest_ <= high - low || connector_.pulls) return {0, high - low};
    const auto after = std::ranges::upper_bound(start_, low);
    auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - start_.begin() - 1, 0));
    double longest = 0;
    for (; k < connector_.links() && start_[k] < high; ++k) {
      longest = std::max(longest, std::min(start_[k + 1], high) - std::max(start_[k], low));
    }
    return {std::max(0.0, 2 * longest - (high - low)), high - low};
  }

 private:
  const Connector& connector_;
  std::vector<double> start_;  // m, of every particle
  double longest_ = 0;         // m, of the links
};

bool on_body(const Attachment& to) {
  return to.kind == Attachment::Kind::body;
}

/// Whether two attachments are of one frame, so that they stay as far apart as they are.
bool one_frame(const Attachment& a, const Attachment& b) {
  if (a.kind != b.kind) return false;
  if (a.kind == Attachment::Kind::fixed) return true;
  return on_body(a) ? a.body == b.body : a.path == b.path;
}

/// When the last of the paths ends that two attachments follow.
double last_motion(const World& world, const Known& a, const Known& b) {
  double last = std::max(a.from, b.from);
  for (const Attachment* to : {a.to, b.to}) {
    const Path* path = to->path.get();
    if (on_body(*to)) path = world.bodies[to->body].path.get();
    if (path) last = std::max(last, path->keys().back().time);
  }
  return std::min({last, a.until, b.until});
}

/// Words that end a sentence about a place too far from or too near to a hold; empty: neither.
std::string misfit(double distance, double along, const DistanceRange& range, double same) {
  const bool far = distance > range.most + same, near = distance < range.least - same;
  if (!far && !near) return {};
  std::ostringstream line;
  line << "it is " << distance << " m from what holds the connector at " << along << " m, ";
  if (far) line << "with " << range.most << " m of the connector between them";
  if (near) line << "and the links between them fold to no less than " << range.least << " m";
  return line.str();
}

class Sweep {
 public:
  Sweep(const World& world, const Timeline& timeline) : world_(world), timeline_(timeline) {}

  std::optional<Flaw> run() {
    std::map<std::size_t, std::vector<Known>> pins;  // by connector
    for (std::size_t i = 0; i < timeline_.pins.size(); ++i) {
      const TimedPin& pin = timeline_.pins[i];
      std::string what = alone(pin);
      if (!what.empty()) {
        note(i, std::move(what));
        continue;
      }
      pins[pin.connector].push_back(
          {pin.along, pin.from, pin.until, pin.to ? &*pin.to : nullptr, i + 1});
    }
    for (auto& [index, entries] : pins) {
      const Connector& connector = world_.connectors[index];
      const Ruler ruler(connector);
      for (const Hold& hold : connector.holds) {
        entries.push_back({ruler.along(hold.particle), world_.time, INFINITY, &hold.to, 0});
      }
      const double same = kSamePlace * connector.length;
      over(entries, false, [&](const Known& a, const Known& b, double) {
        if (b.along - a.along <= same) meet(a, b);
      });
      std::erase_if(entries, [](const Known& entry) { return entry.to == nullptr; });
      for (Known& entry : entries) {
        if (entry.pin > 0) entry.from += timeline_.pins[entry.pin - 1].over;
      }
      const auto pair = [&](const Known& a, const Known& b, double time) {
        part(a, b, time, ruler, connector);
      };
      // A hold whose motion is unknown fits only holds on the same body.
      auto loose = entries;
      std::erase_if(loose, [&](const Known& e) { return is_prescribed(world_, *e.to); });
      std::ranges::stable_sort(loose, {}, [](const Known& e) { return e.to->body; });
      for (auto first = loose.begin(); first != loose.end();) {
        const auto last = std::find_if(
            first, loose.end(), [&](const Known& e) { return e.to->body != first->to->body; });
        over({first, last}, true, pair);
        first = last;
      }
      std::erase_if(entries, [&](const Known& e) { return !is_prescribed(world_, *e.to); });
      over(entries, true, pair);
    }
    check_cuts();
    return found_;
  }

 private:
  void note(std::size_t pin, std::string what) {
    if (!found_ || pin < found_->index) found_ = Flaw{false, pin, std::move(what)};
  }

  /// The flaw of a pin by itself, all others aside.
  std::string alone(const TimedPin& pin) const {
    const std::string place = place_flaw(pin.connector, pin.along, pin.from);
    if (!place.empty()) return place;
    if (!(pin.until > pin.from)) {
      std::ostringstream line;
      line << "it ends at " << pin.until << " s, expected later than it begins, at " << pin.from
           << " s";
      return line.str();
    }
    if (pin.to && !exists(world_, *pin.to)) return std::string(words(Outcome::no_target));
    return {};
  }

  std::string place_flaw(std::size_t connector, double along, double time) const {
    if (connector >= world_.connectors.size()) return std::string(words(Outcome::no_connector));
    if (world_.connectors[connector].winch) return std::string(words(Outcome::has_winch));
    std::ostringstream line;
    const double length = world_.connectors[connector].length;
    if (!(along >= 0 && along <= length)) {
      line << "its place at " << along << " m is not on the connector, which is " << length
           << " m long";
    } else if (!(time >= world_.time)) {
      line << "it begins at " << time << " s, before the scene, which begins at " << world_.time
           << " s";
    }
    return line.str();
  }

  /// Calls look(a, b, time) for every two entries that become neighbours along the connector, a
  /// before b, at that time (s); `after_end`, also where one between them has ended.
  static void over(const std::vector<Known>& entries, bool after_end, auto&& look) {
    std::vector<std::tuple<double, bool, std::size_t>> events;  // ends come first
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (!(entries[i].until > entries[i].from)) continue;
      events.emplace_back(entries[i].from, true, i);
      events.emplace_back(entries[i].until, false, i);
    }
    std::ranges::sort(events);
    std::set<std::pair<double, std::size_t>> active;  // by their places
    for (const auto& [time, begins, i] : events) {
      const std::pair key(entries[i].along, i);
      const auto after = active.upper_bound(key);
      if (begins) {
        if (after != active.end()) look(entries[i], entries[after->second], time);
        if (after != active.begin()) look(entries[std::prev(after)->second], entries[i], time);
        active.insert(after, key);
        continue;
      }
      const auto own = active.find(key);
      const auto next = active.erase(own);
      if (after_end && std::isfinite(time) && next != active.begin() && next != active.end()) {
        look(entries[std::prev(next)->second], entries[next->second], time);
      }
    }
  }

  void meet(const Known& a, const Known& b) {
    if (a.pin == 0 && b.pin == 0) return;
    const bool end = a.pin == 0 || b.pin == 0;
    note(std::max(a.pin, b.pin) - 1,
         std::string(words(Outcome::held_there)) + (end ? "" : ", by another pin at that time"));
  }

  /// Notes where two holds are farther apart than the connector between them is long, or nearer
  /// than it folds, from `time` on.
  void part(const Known& a, const Known& b, double time, const Ruler& ruler,
            const Connector& connector) {
    if (a.pin == 0 && b.pin == 0) return;
    constexpr double kSampling = 1e-3;  // s; no hand moves a millimetre in less
    const DistanceRange range = ruler.range(a.along, b.along);
    const bool rigid = one_frame(*a.to, *b.to);
    const double end = rigid ? time : last_motion(world_, a, b);
    for (;;) {
      const Vec3 from = hold_motion(world_, *a.to, time).position;
      const double distance = (hold_motion(world_, *b.to, time).position - from).norm();
      const Known& other = a.pin < b.pin ? a : b;
      const std::string what = misfit(distance, other.along, range, 1e-6 * connector.length);
      if (!what.empty()) {
        std::ostringstream line;
        line << "at " << time << " s " << what;
        if (rigid && on_body(*a.to)) line << ", and one body holds both";
        return note(std::max(a.pin, b.pin) - 1, line.str());
      }
      if (time >= end) return;
      time = std::min(time + kSampling, end);
    }
  }

  /// The cuts, where no pin has a flaw.
  void check_cuts() {
    if (found_) return;
    const std::vector<TimedCut>& cuts = timeline_.cuts;
    const auto note_cut = [&](std::size_t cut, std::string what) {
      if (!found_ || cut < found_->index) found_ = Flaw{true, cut, std::move(what)};
    };
    std::vector<std::tuple<std::size_t, double, std::size_t>> places;
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      const TimedCut& cut = cuts[i];
      std::string what = place_flaw(cut.connector, cut.along, cut.time);
      if (what.empty()) {
        const double length = world_.connectors[cut.connector].length, same = kSamePlace * length;
        if (cut.along <= same || cut.along >= length - same) {
          what = "it is at an end of the connector";
        }
      }
      if (what.empty()) {
        places.emplace_back(cut.connector, cut.along, i);
      } else {
        note_cut(i, std::move(what));
      }
    }
    std::ranges::sort(places);
    const auto same_place = [&](std::size_t connector, double along, double other) {
      return std::abs(along - other) <= kSamePlace * world_.connectors[connector].length;
    };
    for (std::size_t k = 1; k < places.size(); ++k) {
      const auto& [connector, along, i] = places[k];
      const auto& [before, at, j] = places[k - 1];
      if (before == connector && same_place(connector, along, at)) {
        note_cut(std::max(i, j), "the connector is cut there already");
      }
    }
    for (const TimedPin& pin : timeline_.pins) {
      const double same = kSamePlace * world_.connectors[pin.connector].length;
      auto near = std::ranges::lower_bound(
          places, std::tuple(pin.connector, pin.along - same, std::size_t{0}));
      for (; near != places.end(); ++near) {
        const auto& [connector, along, i] = *near;
        if (connector != pin.connector || along > pin.along + same) break;
        if (!(pin.from <= cuts[i].time && cuts[i].time < pin.until)) continue;
        std::ostringstream line;
        line << "pins[" << &pin - timeline_.pins.data() << "] holds the connector there from "
             << pin.from << " s until " << pin.until << " s, expected another place or time";
        note_cut(i, line.str());
      }
    }
  }

  const World& world_;
  const Timeline& timeline_;
  std::optional<Flaw> found_;
};

}  // namespace

std::optional<Flaw> find_flaw(const World& world, const Timeline& timeline) {
  return Sweep(world, timeline).run();
}

std::string why_out_of_reach(const World& world, std::size_t index, double along,
                             const Attachment& to) {
  const Connector& connector = world.connectors[index];
  const Ruler ruler(connector);
  const Vec3 target = hold_motion(world, to, world.time).position;
  for (const Hold& hold : connector.holds) {
    const double there = ruler.along(hold.particle);
    const std::string what = misfit((target - connector.position[hold.particle]).norm(), there,
                                    ruler.range(along, there), kSamePlace * connector.length);
    if (what.empty()) continue;
    return what + (on_body(to) ? ", expected a point of the body that is within reach" : "");
  }
  return {};
}

std::string why_inside(const World& world, std::size_t index, std::size_t particle) {
  constexpr double kInside = 1e-6;  // of the connector's length: as deep as methods leave beads
  const Connector& connector = world.connectors[index];
  for (const Obstacle& obstacle : world.obstacles) {
    if (!obstacle.touches(connector.category)) continue;
    const double apart = gap(obstacle, obstacle.frame(world.time).pose(),
                             connector.position[particle], connector.radius)
                             .distance;
    if (apart >= -kInside * connector.length) continue;
    std::ostringstream line;
    line << "it frees a bead " << -apart << " m inside of obstacle " << obstacle.name
         << ", expected a place or time where the bead is outside";
    return line.str();
  }
  return {};
}

std::vector<TimedCut> in_order_of_time(std::vector<TimedCut> cuts) {
  std::ranges::stable_sort(cuts, {}, &TimedCut::time);
  return cuts;
}

World divided(World world, const Timeline& timeline) {
  Parts parts(world.connectors);
  Interventions interventions;
  const std::vector<TimedCut> cuts = in_order_of_time(timeline.cuts);
  std::vector<double> along;
  for (std::size_t i = 0; i < cuts.size();) {
    const std::size_t part = parts.at(cuts[i].connector, cuts[i].along).connector;
    std::size_t end = i;
    along.clear();
    for (; end < cuts.size() && cuts[end].connector == cuts[i].connector; ++end) {
      const Parts::Place place = parts.at(cuts[end].connector, cuts[end].along);
      if (place.connector != part) break;
      along.push_back(place.along);
    }
    std::size_t made = world.connectors.size();
    if (interventions.cut(world, part, along)) {
      for (; i < end; ++i) parts.cut(cuts[i].connector, cuts[i].along, made++);
      continue;
    }
    for (; i < end; ++i) {
      const auto [connector, place] = parts.at(cuts[i].connector, cuts[i].along);
      const Divided divided = interventions.cut(world, connector, place);
      if (divided.outcome == Outcome::done) {
        parts.cut(cuts[i].connector, cuts[i].along, divided.connector);
      }
    }
  }
  return world;
}

BadIntervention::BadIntervention(Flaw found, double at, const std::string& source)
    : std::runtime_error([&] {
        std::ostringstream line;
        if (!source.empty()) line << source << ": ";
        line << (found.cut ? "cut " : "pin ") << found.index + 1 << ", at " << at
             << " s: " << found.what;
        return printable(line.str());
      }()),
      flaw(std::move(found)),
      time(at) {}

}  // namespace taut
