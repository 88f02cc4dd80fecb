#include "sim/world/ties.h"

#include <algorithm>

#include "sim/world/held.h"
#include "sim/world/joined.h"
#include "sim/world/structure.h"

namespace taut {

void Ties::reserve(const World& world, std::size_t connectors, std::size_t holds) {
  ties_.reserve(connectors);
  std::size_t held = holds, joined = 0;
  for (const Connector& connector : world.connectors) held += connector.holds.size();
  for (const Joint& joint : world.joints) joined += joint.particles.size();
  holder_.reserve(held);
  tie_.reserve(joined);
  holders_.reserve(world.bodies.size());
}

void Ties::follow(const World& world) {
  if (topology_ == world.topology && ties_.size() == world.connectors.size() &&
      holders_.size() == world.bodies.size()) {
    return;
  }
  ties_.assign(world.connectors.size(), kNone);
  tie_.clear();
  for (std::size_t j = 0; j < world.joints.size(); ++j) {
    const std::vector<Joint::Particle>& particles = world.joints[j].particles;
    for (std::size_t i = 0; i < particles.size(); ++i) {
      std::uint32_t& first = ties_[particles[i].connector];
      tie_.push_back({std::uint32_t(j), std::uint32_t(i), first});
      first = std::uint32_t(tie_.size() - 1);
    }
  }
  holders_.assign(world.bodies.size(), kNone);
  holder_.clear();
  spare_ = kNone;
  for (std::size_t c = world.connectors.size(); c-- > 0;) {  // the last ends up behind the others
    for (const Hold& hold : world.connectors[c].holds) {
      if (!is_prescribed(world, hold.to)) held(c, hold.to.body);
    }
  }
  topology_ = world.topology;
}

const Joint* Ties::find_joint(const World& world, std::size_t connector,
                              std::size_t particle) const {
  for (std::uint32_t p = ties_[connector]; p != kNone; p = tie_[p].next) {
    const Joint& joint = world.joints[tie_[p].joint];
    if (joint.particles[tie_[p].particle].particle == particle) return &joint;
  }
  return nullptr;
}

double Ties::joined_mass(const World& world, std::size_t connector, std::size_t particle) const {
  const Joint* joint = find_joint(world, connector, particle);
  return joint ? taut::joined_mass(world, *joint)
               : world.connectors[connector].particle_mass[particle];
}

MassProperties Ties::laden(const World& world, std::size_t body) const {
  MassProperties properties = world.bodies[body].bare;
  std::uint32_t last = kNone;
  for (std::uint32_t h = holders_[body]; h != kNone; h = holder_[h].next) {
    const std::uint32_t c = holder_[h].connector;
    if (c == last) continue;
    last = c;
    for (const Hold& hold : world.connectors[c].holds) {
      if (hold.to.kind != Attachment::Kind::body || hold.to.body != body) continue;
      const double mass = joined_mass(world, c, hold.particle);
      properties = with_point_mass(properties, mass, hold.to.point);
    }
  }
  return properties;
}

void Ties::place_joined(World& world, std::size_t connector, std::size_t particle) const {
  if (const Joint* joint = find_joint(world, connector, particle)) {
    taut::place_joined(world, *joint);
  }
}

/// Lets `change` change the joints' particles on a connector, and the topology with them.
void Ties::each(World& world, std::size_t connector, auto change) {
  for (std::uint32_t p = ties_[connector]; p != kNone;) {
    const auto [joint, particle, next] = tie_[p];
    Joint::Particle& at = world.joints[joint].particles[particle];
    const std::uint64_t before = structure_of_joint(world, joint);
    change(at);
    world.topology += structure_of_joint(world, joint) - before;
    p = next;
  }
}

void Ties::particles_added(World& world, std::size_t connector, std::span<const Place> places) {
  each(world, connector, [&](Joint::Particle& at) {
    const auto behind = std::ranges::lower_bound(places, at.particle, {}, &Place::particle);
    at.particle += static_cast<std::size_t>(behind - places.begin());
  });
}

void Ties::particles_removed(World& world, std::size_t connector,
                             std::span<const std::size_t> removed) {
  each(world, connector, [&](Joint::Particle& at) {
    const auto behind = std::ranges::lower_bound(removed, at.particle);
    at.particle -= static_cast<std::size_t>(behind - removed.begin());
  });
}

void Ties::connector_divided(World& world, std::size_t connector, std::size_t first,
                             std::size_t second) {
  each(world, connector, [&](Joint::Particle& at) {
    if (at.particle >= first) at = {second, at.particle - first};
  });
  for (std::uint32_t* from = &ties_[connector]; *from != kNone;) {
    const std::uint32_t p = *from;
    Tie& tie = tie_[p];
    if (world.joints[tie.joint].particles[tie.particle].connector == connector) {
      from = &tie.next;
      continue;
    }
    *from = tie.next;
    tie.next = ties_[second];
    ties_[second] = p;
  }
  for (const Hold& hold : world.connectors[second].holds) {
    if (is_prescribed(world, hold.to)) continue;
    let_go(connector, hold.to.body);
    held(second, hold.to.body);
  }
}

void Ties::held(std::size_t connector, std::size_t body) {
  std::uint32_t h = spare_;
  if (h != kNone) {
    spare_ = holder_[h].next;
  } else {
    h = std::uint32_t(holder_.size());
    holder_.emplace_back();
  }
  std::uint32_t* at = &holders_[body];
  while (*at != kNone && holder_[*at].connector < connector) at = &holder_[*at].next;
  holder_[h] = {std::uint32_t(connector), *at};
  *at = h;
}

void Ties::let_go(std::size_t connector, std::size_t body) {
  std::uint32_t* at = &holders_[body];
  while (*at != kNone && holder_[*at].connector != connector) at = &holder_[*at].next;
  if (*at == kNone) return;
  const std::uint32_t h = *at;
  *at = holder_[h].next;
  holder_[h].next = spare_;
  spare_ = h;
}

}  // namespace taut
