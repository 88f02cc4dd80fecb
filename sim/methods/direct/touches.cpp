#include "sim/methods/direct/touches.h"

#include <algorithm>

#include "sim/contact/body_contacts.h"

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
  known_.clear();
  within_ = -1;
  frames_.resize(world.obstacles.size());
  turns_.resize(world.obstacles.size());
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
  radius_.clear();
  particles_.clear();
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    radius_.insert(radius_.end(), connector.particles(), connector.radius);
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      particles_.push_back({Forces::Side::Kind::particle, c, i});
    }
  }
  free_.clear();
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    if (!world.bodies[b].driven()) free_.push_back(b);
  }
  for (const auto& meeting : contact::meetings_of_beads(world, mechanism, world.bead_pairs)) {
    candidates_.push_back({.a = meeting.body,
                           .b = meeting.body,
                           .radius = radius_[meeting.body],
                           .other = meeting.other,
                           .shape = meeting.shape,
                           .place = meeting.place,
                           .stick = meeting.static_friction,
                           .slide = meeting.kinetic_friction,
                           .restitution = meeting.restitution});
  }
  fixed_ = candidates_.size();
  on_moving_.assign(fixed_, 0);
  for (std::size_t i = 0; i < fixed_; ++i) {
    const std::uint32_t obstacle = candidates_[i].obstacle;
    on_moving_[i] = obstacle != Candidate::kNone && world.obstacles[obstacle].path != nullptr;
  }
  reach_.assign(mechanism.bodies().size(), 0.0);
  for (std::size_t b = 0; b < reach_.size() && b < capsules.size(); ++b) {
    reach_[b] = std::max(capsules[b].from.norm(), capsules[b].to.norm()) + capsules[b].radius;
  }
  links_.rebuild(world);
  rules_ = world.connector_pairs;
  if (!links_.any()) return;
  leader_.resize(mechanism.points());
  moves_.resize(mechanism.points());
  next_.assign(mechanism.points(), Candidate::kNone);
  former_ = next_;
  for (std::uint32_t p = 0; p < mechanism.points(); ++p) {
    leader_[p] = small(mechanism.leader(p));
    moves_[p] = is_free(leader_[p]) || carried[leader_[p]];
  }
  first = 0;
  for (const Connector& connector : world.connectors) {
    for (std::uint32_t k = 0; k < connector.links(); ++k) {
      const std::uint32_t a = leader_[first + k], b = leader_[first + k + 1];
      next_[a] = b;
      former_[b] = a;
    }
    first += static_cast<std::uint32_t>(connector.particles());
  }
}

double Touches::largest_move(const Mechanism& mechanism, const std::vector<double>& one,
                             const std::vector<double>& other) const {
  double most = 0;
  for (std::size_t p = 0; p < mechanism.points(); ++p) {
    const std::size_t at = mechanism.position(p);
    most = std::max(most, (PartOf(&one[at]) - PartOf(&other[at])).squaredNorm());
  }
  most = std::sqrt(most);
  for (std::size_t b = 0; b < reach_.size(); ++b) {
    const std::size_t at = mechanism.pose(b);
    const double turn = (quaternion(&one[at + 3]).coeffs() - quaternion(&other[at + 3]).coeffs())
                            .norm();  // half of the angle, where it is small
    most = std::max(most, (PartOf(&one[at]) - PartOf(&other[at])).norm() + 3 * turn * reach_[b]);
  }
  return most;
}

bool Touches::are_near_known(const Mechanism& mechanism, const std::vector<double>& state) const {
  return within_ >= 0 && largest_move(mechanism, state, near_at_) <= within_ / 2;
}

void Touches::find_near(const Mechanism& mechanism, const std::vector<double>& state,
                        double within) {
  within_ = within;
  near_at_ = state;
  near_.clear();
  for (std::uint32_t i = 0; i < fixed_; ++i) {
    if (on_moving_[i] || meet(mechanism, i, state.data()).gap <= within) near_.push_back(i);
  }
  if (!links_.any()) return;
  const std::size_t others = near_.size();
  links_.find({state.data(), 3 * mechanism.points()}, within, pairs_);
  for (const contact::LinkPair& pair : pairs_) add_pair(pair);
  const auto from = near_.begin() + static_cast<std::ptrdiff_t>(others);
  std::sort(from, near_.end());
  near_.erase(std::unique(from, near_.end()), near_.end());
}

/// Adds all spots at which two links may touch to the near ones.
void Touches::add_pair(const contact::LinkPair& pair) {
  const std::uint32_t a = pair.a, c = pair.b;
  add_near(a, a + 1, c, c + 1, pair);
  for (const std::uint32_t end : {a, a + 1}) add_near(end, end, c, c + 1, pair);
  for (const std::uint32_t end : {c, c + 1}) add_near(end, end, a, a + 1, pair);
  for (const std::uint32_t end : {a, a + 1}) {
    for (const std::uint32_t other : {c, c + 1}) add_near(end, end, other, other, pair);
  }
}

void Touches::add_near(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d,
                       const contact::LinkPair& pair) {
  if (!moves_[a] && !moves_[b] && !moves_[c] && !moves_[d]) return;
  const auto key_of = [](std::uint32_t from, std::uint32_t to) {
    return std::uint64_t{2} * from + (from != to ? 1 : 0);
  };
  const std::uint64_t key = key_of(a, b) << 32 | key_of(c, d);
  const auto [at, is_new] = known_.emplace(key, static_cast<std::uint32_t>(candidates_.size()));
  if (is_new) {
    const ConnectorPair& rule = rules_[pair.rule];
    candidates_.push_back({.a = leader_[a],
                           .b = leader_[b],
                           .c = leader_[c],
                           .d = leader_[d],
                           .spot = contact::Spot::nearest,
                           .radius = radius_[a] + radius_[c],
                           .stick = rule.static_friction,
                           .slide = rule.kinetic_friction,
                           .restitution = rule.restitution});
  }
  near_.push_back(at->second);
}

/// Whether the point of a link that is nearest to a bead is between its ends.
bool Touches::is_between(const Mechanism& mechanism, std::uint32_t bead, std::uint32_t a,
                         std::uint32_t b, const double* state) const {
  const PartOf from(state + mechanism.position(a)), to(state + mechanism.position(b));
  const Vec3 way = to - from;
  const double share = way.dot(PartOf(state + mechanism.position(bead)) - from);
  return share > 0 && share < way.squaredNorm();
}

/// Each place where two ropes are nearest to each other has one candidate that is distinct there.
bool Touches::are_links_distinct(const Mechanism& mechanism, const Candidate& of,
                                 const double* state) const {
  if (of.a != of.b) {  // else its ends at the other link, and those of the other, tell
    constexpr double kParallel = 1e-3;  // rad
    const Meeting at = meet_links(mechanism, of, state);
    const auto inside = [](double share) { return share > 0 && share < 1; };
    const Vec3 e =
        PartOf(state + mechanism.position(of.b)) - PartOf(state + mechanism.position(of.a));
    const Vec3 f =
        PartOf(state + mechanism.position(of.d)) - PartOf(state + mechanism.position(of.c));
    return inside(at.share) && inside(at.other_share) &&
           e.cross(f).norm() > kParallel * e.norm() * f.norm();
  }
  if (of.c != of.d) return is_between(mechanism, of.a, of.c, of.d, state);
  const auto nearer = [&](std::uint32_t bead, std::uint32_t at) {
    return (next_[at] != Candidate::kNone && is_between(mechanism, bead, at, next_[at], state)) ||
           (former_[at] != Candidate::kNone && is_between(mechanism, bead, former_[at], at, state));
  };
  return !nearer(of.a, of.c) && !nearer(of.c, of.a);
}

Meeting Touches::meet_links(const Mechanism& mechanism, const Candidate& of,
                            const double* state) const {
  const PartOf a(state + mechanism.position(of.a)), b(state + mechanism.position(of.b));
  const PartOf c(state + mechanism.position(of.c)), d(state + mechanism.position(of.d));
  const contact::NearestShares near = contact::nearest_shares(a, b, c, d);
  Meeting at;
  at.share = near.first;
  at.other_share = near.other;
  const Vec3 apart = a + near.first * (b - a) - c - near.other * (d - c);
  const double distance = apart.norm();
  at.gap = distance - of.radius;
  at.normal = distance > 0 ? Vec3(apart / distance) : (b - a).cross(d - c).normalized();
  if (!at.normal.allFinite() || at.normal.isZero(0)) at.normal = Vec3::UnitY();
  return at;
}

void Touches::place(const World& world, double time) {
  for (std::size_t o = 0; o < frames_.size(); ++o) {
    frames_[o] = world.obstacles[o].frame(time);
    turns_[o] = frames_[o].rotation.toRotationMatrix();
  }
}

Touches::Axes Touches::axes_of(const Mechanism& mechanism, const Candidate& of,
                               const double* state) const {
  if (of.obstacle != Candidate::kNone) return {frames_[of.obstacle].position, turns_[of.obstacle]};
  const Pose frame = frame_of(mechanism, of, state);
  return {frame.position, frame.rotation.toRotationMatrix()};
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

std::pair<Forces::Side, Forces::Side> Touches::sides(std::size_t candidate) const {
  using Side = Forces::Side;
  const Candidate& of = candidates_[candidate];
  const auto of_rope = [&](std::uint32_t first, std::uint32_t second) {
    Side side = particles_[first];
    if (first != second) side.kind = Side::Kind::link;
    return side;
  };
  const auto of_body = [&](std::uint32_t body) { return Side{Side::Kind::body, free_[body], 0}; };
  const Side one = of.body != Candidate::kNone ? of_body(of.body) : of_rope(of.a, of.b);
  if (of.is_at_rope()) return {one, of_rope(of.c, of.d)};
  if (of.obstacle == Candidate::kNone) return {one, of_body(of.other)};
  return {one, {Side::Kind::obstacle, of.obstacle, 0}};
}

bool Touches::is_distinct(const Mechanism& mechanism, std::size_t candidate,
                          const double* state) const {
  const Candidate& of = candidates_[candidate];
  if (of.is_at_rope()) return are_links_distinct(mechanism, of, state);
  if (of.is_bead()) return true;
  return contact::all_gaps(of.shape, frame_of(mechanism, of, state),
                           capsule_of(mechanism, of, state))[static_cast<std::size_t>(of.spot)]
      .distinct;
}

Meeting Touches::meet(const Mechanism& mechanism, std::size_t candidate,
                      const double* state) const {
  const Candidate& of = candidates_[candidate];
  if (of.is_at_rope()) return meet_links(mechanism, of, state);
  Meeting at;
  const Axes axes = axes_of(mechanism, of, state);
  Vec3 axis;  // the point of the axis, or the bead's centre
  if (of.is_bead()) {
    axis = PartOf(state + mechanism.position(of.a));
    at.local = axes.turn.transpose() * (axis - axes.origin);
    const SurfaceDistance near = of.shape.from(at.local);
    at.gap = near.distance - of.radius;
    at.normal = axes.turn * near.normal;
  } else {
    const contact::Capsule capsule = capsule_of(mechanism, of, state);
    const auto near = contact::gap_at(of.shape, frame_of(mechanism, of, state), capsule, of.spot);
    at.gap = near.distance;
    at.normal = near.normal;
    axis = capsule.at(near.along);
    at.local = axes.turn.transpose() * (axis - axes.origin);
    if (of.body != Candidate::kNone) {
      at.arm = axis - of.radius * at.normal - PartOf(state + mechanism.pose(of.body));
    } else {
      at.share = near.along;
    }
  }
  at.turn = axes.turn;
  if (of.obstacle != Candidate::kNone) {
    const FrameMotion& moves = frames_[of.obstacle];
    at.surface = moves.velocity + moves.spin.cross(axis - moves.position);
  } else {
    at.other_arm = axis - of.radius * at.normal - PartOf(state + mechanism.pose(of.other));
  }
  return at;
}

Mat3 Touches::curvature(std::size_t candidate, const Meeting& at) const {
  const Candidate& of = candidates_[candidate];
  if (of.is_at_rope()) {
    return (Mat3::Identity() - at.normal * at.normal.transpose()) / (at.gap + of.radius);
  }
  Mat3 by;
  for (int k = 0; k < 3; ++k) {
    by.col(k) = at.turn * of.shape.normal_rate(at.local, at.turn.row(k).transpose());
  }
  return by;
}

Vec3 Touches::axis(const Mechanism& mechanism, const Candidate& of, const double* state) const {
  const contact::Capsule capsule = capsule_of(mechanism, of, state);
  return capsule.to - capsule.from;
}

Vec3 Touches::passing(const Mechanism& mechanism, std::size_t candidate, const Meeting& at,
                      const double* state) const {
  const Candidate& of = candidates_[candidate];
  const auto of_body = [&](std::uint32_t body, const Vec3& arm) -> Vec3 {
    const double* twist = state + mechanism.twist(body);
    return PartOf(twist) + PartOf(twist + 3).cross(arm);
  };
  const auto of_link = [&](std::uint32_t a, std::uint32_t b, double share) -> Vec3 {
    const Vec3 moves = (1 - share) * PartOf(state + mechanism.velocity(a)) +
                       share * PartOf(state + mechanism.velocity(b));
    if (!mechanism.has_winches()) return moves;
    const Vec3 flow =
        (1 - share) * mechanism.flow_past(a, state) + share * mechanism.flow_past(b, state);
    return moves + flow - at.normal.dot(flow) * at.normal;
  };
  const Vec3 moves =
      of.body != Candidate::kNone ? of_body(of.body, at.arm) : of_link(of.a, of.b, at.share);
  if (of.is_at_rope()) return moves - of_link(of.c, of.d, at.other_share);
  return of.other != Candidate::kNone ? moves - of_body(of.other, at.other_arm)
                                      : moves - at.surface;
}

}  // namespace taut::direct
