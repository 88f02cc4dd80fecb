#include "sim/run/bodies_as_links.h"

#include <algorithm>
#include <memory>

#include "sim/links/equimomental_link.h"
#include "sim/motion/rotation.h"

namespace taut {
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

void BodiesAsLinks::show(Snapshot& state) const {
  for (const Link& link : links_) {
    std::vector<Vec3>& at = state.connectors[link.connector];
    at.erase(link.first ? at.begin() : at.end() - 1);
    const Vec3& hangs = link.first ? at.front() : at.back();
    state.bodies[link.body] = {hangs - link.rotation * link.point, link.rotation};
  }
}

}  // namespace taut
