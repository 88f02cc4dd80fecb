#include "sim/run/reduced.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "sim/links/mechanism.h"
#include "sim/motion/rotation.h"

namespace taut {

void take_masses(World& world, const World& exact) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Connector& coarse = world.connectors[c];
    const Connector& fine = exact.connectors[c];
    if (coarse.mass == 0 && fine.mass > 0) continue;  // modelled without
    std::ranges::fill(coarse.particle_mass, 0.0);
    double along = 0, link_start = 0;  // m, of the fine particle; of the coarse link
    std::size_t link = 0;
    for (std::size_t i = 0; i < fine.particles(); ++i) {
      if (i > 0) along += fine.rest[i - 1];
      while (link + 1 < coarse.links() && link_start + coarse.rest[link] < along) {
        link_start += coarse.rest[link++];
      }
      const double length = coarse.rest[link];
      const double ahead = length > 0 ? std::clamp((along - link_start) / length, 0.0, 1.0)
                                      : static_cast<double>(i) / static_cast<double>(fine.links());
      coarse.particle_mass[link] += (1 - ahead) * fine.particle_mass[i];
      coarse.particle_mass[link + 1] += ahead * fine.particle_mass[i];
    }
    if (!coarse.winch) continue;
    Winch winch = *coarse.winch;
    winch.particle_mass = coarse.particle_mass;
    winch.density = fine.winch->density;
    coarse.winch = std::make_shared<const Winch>(std::move(winch));
  }
  reweigh(world);
}

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

namespace {

struct End {
  std::size_t connector = 0, hold = 0;  // of World::connectors, of its holds
};

std::vector<End> holds_on(const World& world, std::size_t body) {
  std::vector<End> found;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const std::vector<Hold>& holds = world.connectors[c].holds;
    for (std::size_t h = 0; h < holds.size(); ++h) {
      const Attachment& to = holds[h].to;
      if (to.kind == Attachment::Kind::body && to.body == body) found.push_back({c, h});
    }
  }
  return found;
}

/// From where it hangs to its centre of mass, m, body frame.
Vec3 arm_of(const Body& body, const Hold& hold) {
  return body.bare.centre - hold.to.point;
}

/// The mean moment of inertia (kg m^2) about the axes across `along` through the centre of mass.
double moment_across(const MassProperties& body, const Vec3& along) {
  return (body.inertia.trace() - along.dot(body.inertia * along)) / 2;
}

}  // namespace

std::string why_no_link(const World& world, const Timeline& timeline, std::size_t body) {
  if (world.bodies[body].driven()) return "driven";
  const auto is_of = [&](const BodyPair& pair) { return pair.a == body || pair.b == body; };
  if (std::ranges::any_of(world.pairs, is_of)) return "it touches other bodies";
  const auto beads_touch = [&](const BeadPair& pair) { return pair.body == body; };
  if (std::ranges::any_of(world.bead_pairs, beads_touch)) return "it touches connectors";
  const std::vector<End> holds = holds_on(world, body);
  if (holds.empty()) return "nothing holds it";
  if (holds.size() > 1) return "held by more than one point";
  const std::size_t connector = holds[0].connector;
  const Connector& chain = world.connectors[connector];
  const Hold& hold = chain.holds[holds[0].hold];
  if (chain.model != ConnectorModel::links) return "on a massless span";
  if (!chain.sections.empty()) return "on a connector that stretches, bends or meets the air";
  if (chain.pulls) return "on links that only pull";
  if (chain.winch) return "on a connector that has a winch";
  if (hold.particle != 0 && hold.particle + 1 != chain.particles()) return "not at an end";
  if (!(arm_of(world.bodies[body], hold).norm() > 0)) return "held by its centre of mass";
  const auto touches = [&](const auto& entry) { return entry.connector == connector; };
  const auto pins = [&](const TimedPin& pin) {
    return touches(pin) ||
           (pin.to && pin.to->kind == Attachment::Kind::body && pin.to->body == body);
  };
  if (std::ranges::any_of(timeline.pins, pins) || std::ranges::any_of(timeline.cuts, touches)) {
    return "on a connector that is pinned or cut";
  }
  return {};
}

BodiesAsLinks::BodiesAsLinks(World& world) {
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    Body& body = world.bodies[b];
    if (body.model != BodyModel::link) continue;
    const End place = holds_on(world, b).at(0);
    Connector& chain = world.connectors[place.connector];
    const Hold hold = chain.holds[place.hold];
    const Vec3 arm = arm_of(body, hold), along = arm.normalized();
    const EquimomentalLink stick(body.bare.mass, moment_across(body.bare, along), arm.norm());
    const Vec3 beyond = hold.to.point + stick.length * along;
    const bool first = hold.particle == 0;

    chain.particle_mass[hold.particle] += stick.tip;
    const auto put = [&](auto& list, const auto& value) {
      list.insert(first ? list.begin() : list.end(), value);
    };
    put(chain.particle_mass, stick.far);
    put(chain.position, body.point(beyond));
    put(chain.velocity, body.point_velocity(beyond));
    put(chain.rest, stick.length);
    chain.length += stick.length;
    chain.holds.erase(chain.holds.begin() + static_cast<std::ptrdiff_t>(place.hold));
    for (Hold& other : chain.holds) other.particle += first ? 1 : 0;

    const Pose frame = body.frame();
    links_.push_back({b, place.connector, first, hold.to.point, along, frame.rotation});
    body.model = BodyModel::rigid;
    body.path = std::make_shared<const Path>(
        std::vector<PathKey>{{world.time, frame.position, frame.rotation, false}});
    body.grip = Vec3::Zero();
    body.velocity = body.spin = Vec3::Zero();
  }
  if (!links_.empty()) world.topology = structure(world);
}

void BodiesAsLinks::follow(const World& world) {
  for (Link& link : links_) {
    const std::vector<Vec3>& at = world.connectors[link.connector].position;
    const Vec3 line = link.first ? at[0] - at[1] : at.back() - at[at.size() - 2];
    if (line.isZero()) continue;
    const Vec3 before = link.rotation * link.along;
    link.rotation = (rotation_between(before, line) * link.rotation).normalized();
  }
}

std::vector<Quat> BodiesAsLinks::rotations() const {
  std::vector<Quat> all;
  for (const Link& link : links_) all.push_back(link.rotation);
  return all;
}

void BodiesAsLinks::turn(const std::vector<Quat>& rotations) {
  for (std::size_t i = 0; i < links_.size(); ++i) links_[i].rotation = rotations[i];
}

void BodiesAsLinks::show(Snapshot& state) const {
  for (const Link& link : links_) {
    std::vector<Vec3>& at = state.connectors[link.connector];
    at.erase(link.first ? at.begin() : at.end() - 1);
    const Vec3& hangs = link.first ? at.front() : at.back();
    state.bodies[link.body] = {hangs - link.rotation * link.point, link.rotation};
  }
}

}  // namespace taut
