#include "sim/methods/bead_touches.h"

#include <algorithm>

#include "sim/topology/room.h"

namespace taut::methods {
namespace {

/// Of a change of a bead's speed: smaller ones are rounding.
constexpr double kNothing = 1e-9;

Vec3 across(const Vec3& velocity, const Vec3& normal) {
  return velocity - normal.dot(velocity) * normal;
}

/// The velocity of a bead on which `touches` act; they remember what they have given.
Vec3 respond_and_note(const Vec3& free, std::span<contact::Touch> touches) {
  const Vec3 velocity = contact::respond(free, touches).velocity;
  for (contact::Touch& touch : touches) {
    touch.pushed = touch.push * touch.normal;
    touch.friction_before = touch.friction;
  }
  return velocity;
}

Vec3 friction(std::span<const contact::Touch> touches) {
  Vec3 sum = Vec3::Zero();
  for (const contact::Touch& touch : touches) sum += touch.friction_before;
  return sum;
}

}  // namespace

void BeadTouches::prepare(const World& world) {
  obstacles_ = world.obstacles;
  beads_.clear();
  first_.clear();
  index_.clear();
  touches_.clear();
  if (obstacles_.empty()) return;
  frames_.resize(obstacles_.size());
  const std::size_t particles = room(world).particles;
  if (index_.capacity() == 0) {  // what is cut off later has its particles from here
    beads_.reserve(particles);
    index_.reserve(particles);
    touches_.reserve(particles);
    first_.reserve(world.connectors.capacity());
  }
  for (const Connector& connector : world.connectors) {
    first_.push_back(touches_.size());
    touches_.insert(touches_.end(), connector.particles(), 1);
    for (const Hold& hold : connector.holds) touches_[first_.back() + hold.particle] = 0;
  }
  index_.assign(touches_.size(), kNone);
}

contact::Touch BeadTouches::meet(std::size_t obstacle, const Vec3& at, const Vec3& normal) const {
  const FrameMotion& frame = frames_[obstacle];
  contact::Touch touch;
  touch.normal = normal;
  touch.surface = frame.velocity + frame.spin.cross(at - frame.position);
  touch.least = normal.dot(touch.surface);
  touch.stick = obstacles_[obstacle].static_friction;
  touch.slide = obstacles_[obstacle].kinetic_friction;
  return touch;
}

/// Moves a place out of what the bead touches.
void BeadTouches::place_out(const TouchingBead& bead, double radius, Vec3& at) const {
  for (std::size_t k = 0; k < bead.count; ++k) {
    const std::size_t o = bead.obstacle[k];
    const SurfaceDistance near = gap(obstacles_[o], frames_[o].pose(), at, radius);
    if (near.distance < 0) at -= near.distance * near.normal;
  }
}

void BeadTouches::land(World& world, double time, double dt) {
  for (const TouchingBead& bead : beads_) index_[first_[bead.connector] + bead.particle] = kNone;
  beads_.clear();
  for (std::size_t o = 0; o < obstacles_.size(); ++o) frames_[o] = obstacles_[o].frame(time);
  const Vec3 gain = dt * world.gravity;
  const double resting = 2 * gain.norm();  // m/s, what gravity alone may make
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Connector& connector = world.connectors[c];
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (!touches_[first_[c] + i]) continue;
      Vec3 &at = connector.position[i], &velocity = connector.velocity[i];
      const Vec3 started = at - dt * velocity + dt / 2 * gain;
      TouchingBead bead;
      for (std::size_t o = 0; o < obstacles_.size() && bead.count < bead.kMost; ++o) {
        if (!obstacles_[o].touches(connector.category)) continue;
        const SurfaceDistance near = gap(obstacles_[o], frames_[o].pose(), at, connector.radius);
        contact::Touch touch = meet(o, at, near.normal);
        if (near.distance > dt * (velocity - touch.surface).norm()) continue;
        touch.sliding = across(velocity - gain - touch.surface, near.normal);
        std::size_t slot = bead.count++;
        if (near.distance <= 0) {
          const double into = near.normal.dot(touch.surface - velocity);
          if (into > resting) touch.least += obstacles_[o].restitution * into;
          if (slot != bead.inside) {
            bead.touch[slot] = bead.touch[bead.inside];
            bead.obstacle[slot] = bead.obstacle[bead.inside];
            bead.apart[slot] = bead.apart[bead.inside];
            bead.apart_before[slot] = bead.apart_before[bead.inside];
          }
          slot = bead.inside++;
        }
        bead.touch[slot] = touch;
        bead.obstacle[slot] = o;
        bead.apart[slot] = std::max(0.0, near.distance);
        bead.apart_before[slot] = 0;
        if (near.distance <= 0) continue;
        const Vec3 before = started + dt * touch.surface;
        bead.apart_before[slot] =
            std::max(0.0, gap(obstacles_[o], frames_[o].pose(), before, connector.radius).distance);
      }
      if (bead.count == 0) continue;
      bead.connector = c;
      bead.particle = i;
      bead.started = started;
      if (bead.inside > 0) {
        const std::span inside(bead.touch.data(), bead.inside);
        velocity = respond_and_note(velocity, inside);
        at += dt / 2 * friction(inside);
        place_out(bead, connector.radius, at);
      }
      index_[first_[c] + i] = static_cast<std::uint32_t>(beads_.size());
      beads_.push_back(bead);
    }
  }
}

bool BeadTouches::press(World& world, TouchingBead& bead, double dt) const {
  if (bead.inside == 0) return false;
  Connector& connector = world.connectors[bead.connector];
  Vec3 &at = connector.position[bead.particle], &velocity = connector.velocity[bead.particle];
  const Vec3 pulled = velocity;
  velocity = respond_and_note(velocity, std::span(bead.touch.data(), bead.inside));
  at += dt / 2 * (velocity - pulled);
  place_out(bead, connector.radius, at);
  return (velocity - pulled).norm() > kNothing * (1 + pulled.norm());
}

void BeadTouches::hold(World& world, TouchingBead& bead, double dt) const {
  Connector& connector = world.connectors[bead.connector];
  Vec3 &at = connector.position[bead.particle], &velocity = connector.velocity[bead.particle];
  bead.role = TouchingBead::Role::held;
  velocity = bead.touch[0].surface;
  at = bead.started + dt * velocity;
  place_out(bead, connector.radius, at);
}

void BeadTouches::begin_repositioning(const World& world, double dt) {
  for (TouchingBead& bead : beads_) {
    const Connector& connector = world.connectors[bead.connector];
    bead.place = connector.position[bead.particle];
    bead.velocity = connector.velocity[bead.particle];
    for (std::size_t k = bead.inside; k < bead.count; ++k) {
      const std::size_t o = bead.obstacle[k];
      const double apart =
          gap(obstacles_[o], frames_[o].pose(), bead.place, connector.radius).distance;
      bead.touch[k].least = bead.touch[k].normal.dot(bead.touch[k].surface) - apart / dt;
    }
    if (bead.role != TouchingBead::Role::led) continue;
    for (std::size_t k = 0; k < bead.count; ++k) bead.touch[k].stick = bead.touch[k].slide = 0;
  }
}

Vec3 BeadTouches::allowed(const TouchingBead& bead, const Vec3& wanted, double dt) {
  if (bead.role == TouchingBead::Role::held) return bead.place;
  std::array<contact::Touch, TouchingBead::kMost> touch = bead.touch;
  const Vec3 free = bead.velocity + (wanted - bead.place) / dt;
  const Vec3 velocity = contact::respond(free, std::span(touch.data(), bead.count)).velocity;
  return bead.place + dt * (velocity - bead.velocity);
}

void BeadTouches::finish(World& world, const std::vector<std::vector<Vec3>>& flown,
                         double dt) const {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    for (std::size_t i = 0; i < world.connectors[c].particles(); ++i) {
      if (touches_[first_[c] + i]) keep_out(world.connectors[c], c, i, flown[c][i], dt);
    }
  }
}

void BeadTouches::keep_out(Connector& connector, std::size_t c, std::size_t i, const Vec3& flown,
                           double dt) const {
  Vec3 &at = connector.position[i], &velocity = connector.velocity[i];
  const TouchingBead* bead = find(c, i);
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    if (!obstacles_[o].touches(connector.category)) continue;
    const Pose frame = frames_[o].pose();
    if (gap(obstacles_[o], frame, at, connector.radius).distance >= 0) continue;
    const bool known = bead && std::ranges::count(bead->obstacle.begin(),
                                                  bead->obstacle.begin() + bead->count, o) > 0;
    if (!known) {  // links have drawn it in: it stays on the side from which it came
      const SurfaceDistance from = gap(obstacles_[o], frame, flown, connector.radius);
      contact::Touch touch = meet(o, at, from.normal);
      touch.least -= std::max(0.0, from.distance) / dt;
      const Vec3 drawn = velocity;
      velocity = contact::respond(velocity, std::span(&touch, 1)).velocity;
      at += dt * (velocity - drawn);
    }
    const SurfaceDistance near = gap(obstacles_[o], frame, at, connector.radius);
    at -= std::min(0.0, near.distance) * near.normal;
    contact::Touch touch = meet(o, at, near.normal);
    touch.stick = touch.slide = 0;  // it has had its friction
    velocity = contact::respond(velocity, std::span(&touch, 1)).velocity;
  }
}

}  // namespace taut::methods
