// Cutting a connector in two.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <utility>

#include "sim/interventions/interventions.h"
#include "sim/interventions/renumber.h"
#include "sim/world/places.h"

namespace taut {
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

}  // namespace taut
