#include "sim/methods/direct/touches.h"

#include <algorithm>

#include "sim/contact/body_touch.h"

namespace taut::direct {
namespace {

using contact::Spot;
using PartOf = Eigen::Map<const Vec3>;

void at_each_obstacle(const World& world, std::uint64_t category, Candidate made,
                      std::vector<Candidate>& candidates) {
  for (std::uint32_t o = 0; o < world.obstacles.size(); ++o) {
    const Obstacle& obstacle = world.obstacles[o];
    if (!obstacle.touches(category)) continue;
    made.obstacle = o;
    made.shape = obstacle.shape;
    made.stick = obstacle.static_friction;
    made.slide = obstacle.kinetic_friction;
    made.restitution = obstacle.restitution;
    candidates.push_back(made);
  }
}

}  // namespace

void Touches::rebuild(const World& world, const Mechanism& mechanism) {
  candidates_.clear();
  frames_.resize(world.obstacles.size());
  std::uint32_t first = 0;
  const auto is_free = [&](std::uint32_t point) { return mechanism.inverse_mass()[point] != 0; };
  std::vector<char> carried(mechanism.points());
  for (const auto& at : mechanism.body_points()) carried[at.point] = 1;
  for (const Connector& connector : world.connectors) {
    const auto n = static_cast<std::uint32_t>(connector.particles());
    if (connector.model == ConnectorModel::links && !world.obstacles.empty()) {
      for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t point = first + i;
        if (!is_free(point) || mechanism.leader(point) != point) continue;
        at_each_obstacle(world, connector.category,
                         {.a = point, .b = point, .radius = connector.radius}, candidates_);
      }
      for (std::uint32_t k = 0; connector.links_touch && k + 1 < n; ++k) {
        const auto a = small(mechanism.leader(first + k)),
                   b = small(mechanism.leader(first + k + 1));
        const auto moves = [&](std::uint32_t point) { return is_free(point) || carried[point]; };
        if (!moves(a) && !moves(b)) continue;
        for (const Spot spot : {Spot::from, Spot::to, Spot::nearest, Spot::first, Spot::last}) {
          // Its beads stand for the ends, but for one that a free body holds.
          if (spot == Spot::from && !carried[a]) continue;
          if (spot == Spot::to && !carried[b]) continue;
          at_each_obstacle(world, connector.category,
                           {.a = a, .b = b, .spot = spot, .radius = connector.radius}, candidates_);
        }
      }
    }
    first += n;
  }
  const auto of_body = [&](const contact::BodyMeeting& meeting, const BodyCapsule& capsule) {
    Candidate made{
        .body = meeting.body,
        .from = capsule.from,
        .to = capsule.to,
        .radius = capsule.radius,
        .obstacle = meeting.other == contact::kNoBody ? meeting.obstacle : Candidate::kNone,
        .other = meeting.other == contact::kNoBody ? Candidate::kNone : meeting.other,
        .shape = meeting.shape,
        .place = meeting.place,
        .stick = meeting.static_friction,
        .slide = meeting.kinetic_friction,
        .restitution = meeting.restitution};
    for (const Spot spot : contact::kSpots) {
      if (capsule.from == capsule.to && spot != Spot::from) continue;
      made.spot = spot;
      candidates_.push_back(made);
    }
  };
  const auto capsules = contact::capsules_of_free_bodies(world);
  for (const auto& meeting : contact::meetings_of_bodies(world, world.obstacles, world.pairs)) {
    of_body(meeting, capsules[meeting.body]);
  }
  std::vector<double> radius;
  for (const Connector& connector : world.connectors) {
    radius.insert(radius.end(), connector.particles(), connector.radius);
  }
  for (const auto& meeting : contact::meetings_of_beads(world, mechanism, world.bead_pairs)) {
    candidates_.push_back({.a = meeting.body,
                           .b = meeting.body,
                           .radius = radius[meeting.body],
                           .other = meeting.other,
                           .shape = meeting.shape,
                           .place = meeting.place,
                           .stick = meeting.static_friction,
                           .slide = meeting.kinetic_friction,
                           .restitution = meeting.restitution});
  }
}

void Touches::place(const World& world, double time) {
  for (std::size_t o = 0; o < frames_.size(); ++o) frames_[o] = world.obstacles[o].frame(time);
}

Pose Touches::frame_of(const Mechanism& mechanism, const Candidate& of, const double* state) const {
  if (of.obstacle != Candidate::kNone) return frames_[of.obstacle].pose();
  const double* pose = state + mechanism.pose(of.other);
  const Quat turn = quaternion(pose + 3).normalized();
  return {PartOf(pose) + turn * of.place.position, turn * of.place.rotation};
}

contact::Capsule Touches::capsule_of(const Mechanism& mechanism, const Candidate& of,
                                     const double* state) {
  if (of.body == Candidate::kNone) {
    return {PartOf(state + mechanism.position(of.a)), PartOf(state + mechanism.position(of.b)),
            of.radius};
  }
  const double* pose = state + mechanism.pose(of.body);
  const Quat turn = quaternion(pose + 3).normalized();
  return {PartOf(pose) + turn * of.from, PartOf(pose) + turn * of.to, of.radius};
}

bool Touches::is_distinct(const Mechanism& mechanism, std::size_t candidate,
                          const double* state) const {
  const Candidate& of = candidates_[candidate];
  if (of.is_bead()) return true;
  return contact::all_gaps(of.shape, frame_of(mechanism, of, state),
                           capsule_of(mechanism, of, state))[static_cast<std::size_t>(of.spot)]
      .distinct;
}

Meeting Touches::meet(const Mechanism& mechanism, std::size_t candidate,
                      const double* state) const {
  const Candidate& of = candidates_[candidate];
  Meeting at;
  const Pose frame = frame_of(mechanism, of, state);
  Vec3 axis;  // the point of the axis, or the bead's centre
  if (of.is_bead()) {
    axis = PartOf(state + mechanism.position(of.a));
    at.local = frame.rotation.conjugate() * (axis - frame.position);
    const SurfaceDistance near = of.shape.from(at.local);
    at.gap = near.distance - of.radius;
    at.normal = frame.rotation * near.normal;
  } else {
    const contact::Capsule capsule = capsule_of(mechanism, of, state);
    const auto near = contact::gap_at(of.shape, frame, capsule, of.spot);
    at.gap = near.distance;
    at.normal = near.normal;
    axis = capsule.at(near.along);
    at.local = frame.rotation.conjugate() * (axis - frame.position);
    if (of.body != Candidate::kNone) {
      at.arm = axis - of.radius * at.normal - PartOf(state + mechanism.pose(of.body));
    } else {
      at.share = near.along;
    }
  }
  at.turn = frame.rotation;
  if (of.obstacle != Candidate::kNone) {
    const FrameMotion& moves = frames_[of.obstacle];
    at.surface = moves.velocity + moves.spin.cross(axis - moves.position);
  } else {
    at.other_arm = axis - of.radius * at.normal - PartOf(state + mechanism.pose(of.other));
  }
  return at;
}

Mat3 Touches::curvature(const Mechanism& mechanism, std::size_t candidate, const Meeting& at,
                        const double* state) const {
  const Candidate& of = candidates_[candidate];
  const Mat3 turn = frame_of(mechanism, of, state).rotation.toRotationMatrix();
  Mat3 by;
  for (int k = 0; k < 3; ++k) {
    by.col(k) = turn * of.shape.normal_rate(at.local, turn.row(k).transpose());
  }
  return by;
}

Vec3 Touches::axis(const Mechanism& mechanism, std::size_t candidate, const double* state) const {
  const contact::Capsule capsule = capsule_of(mechanism, candidates_[candidate], state);
  return capsule.to - capsule.from;
}

Vec3 Touches::passing(const Mechanism& mechanism, std::size_t candidate, const Meeting& at,
                      const double* state) const {
  const Candidate& of = candidates_[candidate];
  const auto of_body = [&](std::uint32_t body, const Vec3& arm) -> Vec3 {
    const double* twist = state + mechanism.twist(body);
    return PartOf(twist) + PartOf(twist + 3).cross(arm);
  };
  Vec3 moves;
  if (of.body != Candidate::kNone) {
    moves = of_body(of.body, at.arm);
  } else {
    moves = (1 - at.share) * PartOf(state + mechanism.velocity(of.a)) +
            at.share * PartOf(state + mechanism.velocity(of.b));
    if (mechanism.has_winches()) {
      const Vec3 flow = (1 - at.share) * mechanism.flow_past(of.a, state) +
                        at.share * mechanism.flow_past(of.b, state);
      moves += flow - at.normal.dot(flow) * at.normal;
    }
  }
  return of.other != Candidate::kNone ? moves - of_body(of.other, at.other_arm)
                                      : moves - at.surface;
}

}  // namespace taut::direct
