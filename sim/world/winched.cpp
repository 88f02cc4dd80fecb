#include "sim/world/winched.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sim/world/held.h"

namespace taut {
namespace {

bool at_end(const Connector& connector, const Hold& hold) {
  return hold.particle == 0 || hold.particle + 1 == connector.particles();
}

/// The hold of a connector's first (0) or last (1) end; null: none.
const Hold* hold_at(const Connector& connector, std::size_t end) {
  const std::size_t particle = end == 0 ? 0 : connector.links();
  const auto found = std::ranges::find(connector.holds, particle, &Hold::particle);
  return found == connector.holds.end() ? nullptr : &*found;
}

std::string flaw_of(const World& world, std::size_t index) {
  const Connector& connector = world.connectors[index];
  for (const Hold& hold : connector.holds) {
    if (!at_end(connector, hold)) return "is held between its ends";
  }
  for (const std::size_t end : {0u, 1u}) {
    if (!connector.winch->paths[end]) continue;
    const Hold* hold = hold_at(connector, end);
    if (!hold || !is_prescribed(world, hold->to)) {
      return "has a winch at an end whose motion is not known beforehand";
    }
  }
  return {};
}

bool same_place(const Attachment& a, const Attachment& b) {
  return a.kind == b.kind && a.point == b.point && a.path == b.path && a.body == b.body;
}

std::string pulley_flaw(const World& world, const Pulley& pulley) {
  constexpr double kRounding = 1e-9;
  std::array<const Connector*, 2> ropes;
  for (const std::size_t side : {0u, 1u}) {
    const std::size_t index = side == 0 ? pulley.from : pulley.to;
    if (index >= world.connectors.size()) return "is of a connector that is not there";
    ropes[side] = &world.connectors[index];
    if (!ropes[side]->winch)
      return "is of the connector " + ropes[side]->name + " without add_pulley()";
    if (ropes[side]->winch->paths[1 - side]) return "is where a winch is";
  }
  for (const Pulley& other : world.pulleys) {
    if (&other == &pulley) continue;
    if (other.from == pulley.from || other.to == pulley.to) return "is where another is";
  }
  if (pulley.from == pulley.to) return "is of one connector";
  const Hold *before = hold_at(*ropes[0], 1), *behind = hold_at(*ropes[1], 0);
  if (!before || !behind || !same_place(before->to, behind->to)) {
    return "is of ends that are not held at one place";
  }
  const double density = ropes[0]->winch->density, other = ropes[1]->winch->density;
  if (std::abs(density - other) > kRounding * density) return "is between two densities";
  if (pulley.friction < 0 || pulley.bearing < 0) return "has a negative friction";
  // Half a turn with this friction already multiplies a tension by 8e10; beyond, the smaller of the
  // two tensions is lost to rounding.
  constexpr double kMostFriction = 8;
  if (pulley.friction > kMostFriction) return "has a friction above 8";
  if (pulley.bearing >= 1) return "has a bearing that lets nothing turn";
  if (pulley.has_friction() && density > 0 && before->to.kind == Attachment::Kind::body &&
      !world.bodies[before->to.body].driven()) {
    return "has friction at rope with mass on a body that is free";
  }
  return pulley.inertia >= 0 ? "" : "has a negative inertia";
}

}  // namespace

void add_winches(const World& world, Connector& connector, std::shared_ptr<const Path> first,
                 std::shared_ptr<const Path> last, std::optional<double> density) {
  Winch winch;
  winch.paths = {std::move(first), std::move(last)};
  winch.length = connector.length;
  winch.mass = connector.mass;
  winch.rest = connector.rest;
  winch.particle_mass = connector.particle_mass;
  const auto links = static_cast<double>(connector.links());
  winch.density = density.value_or(connector.mass / static_cast<double>(connector.particles()) /
                                   (connector.length / links));
  std::size_t from = 0, until = connector.links();  // the links that change
  for (const Hold& hold : connector.holds) {
    if (is_prescribed(world, hold.to) || winch.density == 0) continue;
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

void add_pulley(World& world, std::string name, std::size_t from, std::size_t to, double inertia) {
  for (const std::size_t c : {from, to}) {
    Connector& connector = world.connectors[c];
    if (connector.winch) continue;
    weigh_by_links(connector);
    add_winches(world, connector, nullptr, nullptr, connector.mass / connector.length);
  }
  world.pulleys.push_back({.name = std::move(name), .from = from, .to = to, .inertia = inertia});
}

PaidOut paid_out(const World& world, std::size_t connector, std::size_t end, double time) {
  PaidOut sum = world.connectors[connector].winch->paid_out(end, time);
  for (const Pulley& pulley : world.pulleys) {
    if (end == 0 && pulley.to == connector) sum = sum + PaidOut{pulley.passed, pulley.speed};
    if (end == 1 && pulley.from == connector) sum = sum + PaidOut{-pulley.passed, -pulley.speed};
  }
  return sum;
}

std::string winch_flaw(const World& world) {
  if (!has_winches(world)) return {};
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (!connector.winch) continue;
    const std::string what = std::isfinite(connector.breaks_at)
                                 ? "breaks_at, expected one that keeps its length"
                                 : flaw_of(world, c);
    if (!what.empty()) return "the connector " + connector.name + " has a winch and " + what;
  }
  for (const Pulley& pulley : world.pulleys) {
    const std::string what = pulley_flaw(world, pulley);
    if (!what.empty()) return "the pulley " + pulley.name + " " + what;
  }
  return {};
}

namespace {

void set_lengths(Connector& connector, double longer) {
  const Winch& winch = *connector.winch;
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

}  // namespace

void set_lengths(World& world, double time) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    if (!world.connectors[c].winch) continue;
    const double first = paid_out(world, c, 0, time).length;
    set_lengths(world.connectors[c], first + paid_out(world, c, 1, time).length);
  }
}

}  // namespace taut
