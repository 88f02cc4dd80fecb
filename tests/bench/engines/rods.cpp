#include "tests/bench/engines/rods.h"

#include <algorithm>
#include <functional>
#include <stdexcept>

#include "sim/material/elements.h"
#include "sim/material/forces.h"
#include "tests/bench/engines/solids.h"

namespace taut::engines {
namespace {

/// The hold of the upper end, or null.
const Hold* top(const World& world) {
  const std::vector<Hold>& holds = world.connectors[0].holds;
  return holds.empty() || holds[0].particle > 0 ? nullptr : &holds[0];
}

void need(bool holds, const char* what) {
  if (!holds) throw std::invalid_argument(what);
}

void check_material(const World& world) {
  const Connector& connector = world.connectors[0];
  const auto is_straight = [](const Section& section) { return section.rest_curvature.isZero(0); };
  need(!connector.stretches(), "engines are given links that do not stretch");
  need(std::ranges::all_of(connector.sections, is_straight),
       "engines are given a connector that is straight at rest");
  need(connector.sections.empty() || world.air.density == 0 ||
           (connector.drag.across == 0 && connector.drag.along == 0),
       "engines are given no air");
  for (const Hold& hold : connector.holds) {
    need(hold.clamp.isZero(0) || hold.to.kind == Attachment::Kind::fixed,
         "engines are given a clamp that stands still");
  }
}

void check(const World& world) {
  need(world.connectors.size() == 1, "engines are given one connector");
  const Connector& connector = world.connectors[0];
  const std::size_t last = connector.particles() - 1;
  const std::size_t below = top(world) ? 1 : 0;
  need(!top(world) || is_prescribed(world, top(world)->to),
       "engines are given a connector that hangs from a fixed or driven point, or from none");
  need(connector.holds.size() == below ||
           (connector.holds.size() == below + 1 && connector.holds[below].particle == last &&
            !is_prescribed(world, connector.holds[below].to)),
       "engines are given a connector that nothing but a free body holds below");
  need(static_cast<std::size_t>(std::ranges::count_if(world.bodies, std::not_fn(&Body::driven))) +
               below ==
           connector.holds.size(),
       "engines are given one free body at most");
  check_material(world);
  if (world.obstacles.empty()) return;
  need(!connector.pulls, "engines are given rods beside obstacles");
  need(!connector.links_touch, "engines are given beads that touch obstacles");
  for (const Obstacle& obstacle : world.obstacles) check_solid(obstacle);
  for (const Body& body : world.bodies) {
    if (body.driven() || !body.capsule.touches()) continue;
    need(std::ranges::all_of(world.obstacles,
                             [&](const Obstacle& obstacle) {
                               return obstacle.touches(connector.category) ==
                                      obstacle.touches(body.capsule.category);
                             }),
         "engines are given obstacles that touch a body and its connector alike");
  }
}

}  // namespace

Rods::Rods(const World& world) {
  check(world);
  const Connector& connector = world.connectors[0];
  const std::size_t links = connector.links();
  for (std::size_t i = 0; i < links; ++i) {
    // Every particle is shared by its two links; one at an end belongs to its link alone.
    const double upper = connector.particle_mass[i] / (i == 0 && !top(world) ? 1 : 2);
    const double lower = connector.particle_mass[i + 1] / (i + 1 < links ? 2 : 1);
    Rod rod;
    rod.along = connector.position[i + 1] - connector.position[i];
    rod.mass = upper + lower;
    rod.centre = lower / rod.mass;
    rod.inertia = upper * lower / rod.mass * rod.along.squaredNorm();
    rod.spin = rod.along.cross(connector.velocity[i + 1] - connector.velocity[i]) /
               rod.along.squaredNorm();
    rods_.push_back(rod);
  }
  std::vector<material::BendElement> bends;
  material::add_bends(connector, 0, 0, bends);
  for (const material::BendElement& bend : bends) {
    Rod& below = rods_[bend.b];  // point i is above rod i
    below.bending_stiffness = bend.stiffness;
    below.bending_damping = bend.damping;
  }
  hangs_ = top(world) != nullptr;
  if (hangs_) clamp_ = top(world)->clamp.normalized();
  if (!hangs_) velocity_ = connector.velocity[0];
  start_ = connector.position[0];
  radius_ = connector.radius;
  obstacles_ = world.obstacles;
  std::erase_if(obstacles_, [&](const Obstacle& o) { return !o.touches(connector.category); });
  if (connector.holds.size() == (hangs_ ? 1U : 0U)) return;
  const Attachment& to = connector.holds.back().to;
  const Body& body = world.bodies[to.body];
  const Mat3 turn = body.rotation.toRotationMatrix();
  body_ = to.body;
  at_start_ = body.rotation;
  load_ = Load{body.bare.mass, turn * (body.bare.centre - to.point),
               turn * body.bare.inertia * turn.transpose(), body.spin, body.capsule};
  load_->capsule.from = turn * (body.capsule.from - to.point);
  load_->capsule.to = turn * (body.capsule.to - to.point);
}

FrameMotion Rods::motion(const Obstacle& obstacle, const World& world, double time) const {
  FrameMotion motion = obstacle.frame(time);
  if (!hangs_) {
    motion.position -= start_;
    return motion;
  }
  const PointMotion from = hold_motion(world, top(world)->to, time);
  motion.position -= from.position;
  motion.velocity -= from.velocity;
  motion.acceleration -= from.acceleration;
  return motion;
}

bool Rods::resist_bending() const {
  return std::ranges::any_of(
      rods_, [](const Rod& rod) { return rod.bending_stiffness > 0 || rod.bending_damping > 0; });
}

void Rods::bend(const std::vector<Vec3>& edges, const std::vector<Vec3>& spins,
                std::vector<Vec3>& moments) const {
  moments.assign(rods_.size(), Vec3::Zero());
  for (std::size_t i = 0; i < rods_.size(); ++i) {
    const Rod& rod = rods_[i];
    if (rod.bending_stiffness == 0 && rod.bending_damping == 0) continue;
    const Vec3& above = i == 0 ? clamp_ : edges[i - 1];
    const material::Bend bend(above, edges[i]);
    Vec3 by_above, by_own;  // N
    bend.slope(rod.bending_stiffness, by_above, by_own);
    if (rod.bending_damping > 0) {
      const Vec3 rate = i == 0 ? Vec3::Zero() : Vec3(spins[i - 1].cross(above));
      Vec3 damped_above, damped_own;
      bend.resistance(rod.bending_damping, rate, spins[i].cross(edges[i]), damped_above,
                      damped_own);
      by_above += damped_above;
      by_own += damped_own;
    }
    if (i > 0) moments[i - 1] -= above.cross(by_above);
    moments[i] -= edges[i].cross(by_own);
  }
  for (std::size_t i = rods_.size() - 1; i-- > 0;) moments[i] += moments[i + 1];
}

std::vector<Bead> Rods::beads() const {
  std::vector<Bead> beads;
  if (obstacles_.empty()) return beads;
  if (!hangs_) beads.push_back({0, -rods_[0].centre * rods_[0].along});
  for (std::size_t i = 0; i < rods_.size(); ++i) {
    if (i + 1 == rods_.size() && load_) break;  // the body holds it
    beads.push_back({i, (1 - rods_[i].centre) * rods_[i].along});
  }
  return beads;
}

Vec3 Rods::gravity(const World& world, double time) const {
  if (!hangs_) return world.gravity;
  return world.gravity - hold_motion(world, top(world)->to, time).acceleration;
}

void Rods::place(const std::vector<Vec3>& ends, const Quat& turn, double time, World& world) const {
  Connector& connector = world.connectors[0];
  const Vec3 from = hangs_ ? hold_motion(world, top(world)->to, time).position : start_;
  for (std::size_t i = 0; i < ends.size(); ++i) connector.position[i] = from + ends[i];
  if (load_) {
    const Vec3 point = connector.holds.back().to.point;
    Body& body = world.bodies[body_];
    body.rotation = turn * at_start_;
    body.position =
        connector.position.back() + body.rotation * (body.mass_properties.centre - point);
  }
  place_held(world, time);
}

}  // namespace taut::engines
