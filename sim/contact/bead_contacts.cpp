#include "sim/contact/bead_contacts.h"

#include <algorithm>

#include "sim/contact/coulomb.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

}  // namespace

void BeadContacts::rebuild(const Mechanism& mechanism, const World& world) {
  obstacles_ = world.obstacles;
  radius_.clear();
  category_.clear();
  if (obstacles_.empty()) return;
  radius_.reserve(mechanism.state_room());  // enough for points that pins add
  category_.reserve(mechanism.state_room());
  met_.reserve(mechanism.state_room());
  for (const Connector& connector : world.connectors) {
    radius_.insert(radius_.end(), connector.particles(), connector.radius);
    category_.insert(category_.end(), connector.particles(), connector.category);
  }
  for (std::size_t p = 0; p < radius_.size(); ++p) {
    if (mechanism.inverse_mass()[p] == 0) radius_[p] = -1;
  }
}

void BeadContacts::find(const Mechanism& mechanism, double time, const std::vector<double>& state) {
  met_.clear();
  for (std::size_t o = 0; o < obstacles_.size(); ++o) {
    const FrameMotion frame = obstacles_[o].frame(time);
    for (std::size_t p = 0; p < radius_.size(); ++p) {
      if (radius_[p] < 0 || !obstacles_[o].touches(category_[p])) continue;
      const Vec3 at = ConstMap(&state[mechanism.position(p)]);
      const SurfaceDistance near = gap(obstacles_[o], frame.pose(), at, radius_[p]);
      if (near.distance > 0) continue;
      met_.push_back({p, o, near.normal, frame.velocity + frame.spin.cross(at - frame.position),
                      -near.distance});
    }
  }
}

void BeadContacts::move_out(const Mechanism& mechanism, double time, double dt,
                            const std::vector<double>& before, std::vector<double>& state) {
  find(mechanism, time, state);
  for (const Met& met : met_) {
    Map at(&state[mechanism.position(met.point)]);
    at += met.depth * met.normal;
    const Vec3 moved = at - ConstMap(&before[mechanism.position(met.point)]) - dt * met.surface;
    const Vec3 slip = moved - met.normal.dot(moved) * met.normal;
    at -= held_share(obstacles_[met.obstacle], slip.norm(), met.depth) * slip;
  }
}

void BeadContacts::rebound(const Mechanism& mechanism, double dt, const std::vector<double>& before,
                           std::vector<double>& state) {
  const double resting = 2 * dt * mechanism.gravity().norm();  // m/s, what gravity alone may make
  for (const Met& met : met_) {
    Map velocity(&state[mechanism.velocity(met.point)]);
    const ConstMap came(&before[mechanism.velocity(met.point)]);
    const double into = met.normal.dot(met.surface - came);
    const double back = into > resting ? obstacles_[met.obstacle].restitution * into : 0;
    velocity += (back - met.normal.dot(velocity - met.surface)) * met.normal;
  }
}

void BeadContacts::stop(const Mechanism& mechanism, double time, double dt,
                        std::vector<double>& state) {
  find(mechanism, time, state);
  const double resting = 2 * dt * mechanism.gravity().norm();
  for (const Met& met : met_) {
    const Obstacle& obstacle = obstacles_[met.obstacle];
    Map(&state[mechanism.position(met.point)]) += met.depth * met.normal;
    Map velocity(&state[mechanism.velocity(met.point)]);
    const Vec3 passing = velocity - met.surface;
    const double into = -met.normal.dot(passing);
    if (into <= 0) continue;
    const double push = into * (1 + (into > resting ? obstacle.restitution : 0));
    const Vec3 slip = passing + into * met.normal;
    velocity += push * met.normal - held_share(obstacle, slip.norm(), push) * slip;
  }
}

}  // namespace taut::contact
