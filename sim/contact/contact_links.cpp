// Links as capsules in the smooth motion between events, and the beads beside them.
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/contact/contact_motion.h"

namespace taut::contact {
namespace {

using Map = Eigen::Map<Vec3>;
using ConstMap = Eigen::Map<const Vec3>;

constexpr double kBeyond = 0.25;     // of a link: its line goes on so far beyond its beads
constexpr double kLevel = 1e-9;      // rad: a link that rises by less lies level
constexpr double kAtBead = 1e-4;     // of a link, from its bead: they are one place
constexpr double kAtEnd = 1e-6;      // of a link, from its bead: what lies flat ends there
constexpr double kBeside = 1e-6;     // of a link, beside the end of what it lies on
constexpr double kStraight = 1e-12;  // 1/m: a solid that bends by less is straight along a link
constexpr double kLevelled = 1e-10;  // of a link: ends that are no farther than the nearest
constexpr double kBroken = 1e-6;     // of accelerations: by so much a closed touch may be broken

/// Whether a link lies flat on a face, or nearly so.
bool lies_evenly(const std::array<SpotGap, 5>& gaps) {
  return gaps[static_cast<std::size_t>(Spot::first)].even;
}

}  // namespace

/// Where links touch, beads and links are parts that meet obstacles.
void ContactMotion::rebuild_parts(const World& world) {
  parts_.clear();
  if (!has_touching_links(world)) return;
  const auto meet = [&](const Part& part, const Connector& of) {
    const auto number = small(capsules_.size() + parts_.size());
    parts_.push_back(part);
    add_meetings(number, of.category, obstacles_, meetings_);
  };
  std::uint32_t first = 0;
  const auto& mobile = mechanism_.inverse_mass();
  for (const Connector& connector : world.connectors) {
    const auto end = small(first + connector.particles());
    for (std::uint32_t p = first; p < end; ++p) {
      if (mobile[p] > 0) meet({p, p, connector.radius}, connector);
      if (p + 1 == end || !connector.links_touch) continue;
      if (inverse_mass(p) > 0 || inverse_mass(p + 1) > 0) {
        meet({p, p + 1, connector.radius}, connector);
      }
    }
    first = end;
  }
  std::ranges::fill(radius_, -1);  // no bead touches by itself
}

Capsule ContactMotion::capsule_of_part(const State& state, const Part& part) const {
  return {place(state, part.first), place(state, part.next), part.radius};
}

/// The gap of a touch. Between its beads it stays one of the line of its link beyond these as well,
/// until the event in which it gets there.
SpotGap ContactMotion::gap_of_part(const BodyTouch& at, const Pose& place,
                                   const Capsule& own) const {
  const Shape& shape = meetings_[at.meeting].shape;
  if (at.spot != Spot::nearest) {
    const SpotGap near = gap_at(shape, place, own, at.spot);
    if (part(at.body).is_bead() || near.even) return near;
  }
  const Vec3 more = kBeyond * (own.to - own.from);
  SpotGap near =
      gap_at(shape, place, Capsule{own.from - more, own.to + more, own.radius}, Spot::nearest);
  near.along = (1 + 2 * kBeyond) * near.along - kBeyond;
  return near;
}

/// m/s, of its line where it touches.
Vec3 ContactMotion::velocity_of_part(const BodyTouch& at, const State& state) const {
  const Part& own = part(at.body);
  return (1 - at.share) * velocity(state, own.first) + at.share * velocity(state, own.next);
}

/// The acceleration of a point that is held or carried, of which neither forces nor twists have a
/// part: along a path, or about the centre of mass.
Vec3 ContactMotion::led(const State& state, std::uint32_t point) const {
  if (const std::uint32_t c = carrier(point); c != kNoBody) {
    const Mechanism::BodyPoint& carried = mechanism_.body_points()[c];
    const Vec3 spin = twist(state, carried.body).tail<3>();
    return spin.cross(spin.cross(carried.arm));
  }
  if (mechanism_.inverse_mass()[point] > 0) return Vec3::Zero();
  return mechanism_.point_acceleration()[point];
}

/// Asks for the accelerations with which a part stays on the surface, and with which it does not
/// slide. In the frame of the obstacle, with the normal n at p = (1 - s) a + s b, the way
/// w = b - a, the velocity v there and the derivative H of the normal by the place, n w = 0 gives
///   s' = -(w H v + n w')/(w H w),   0 = d/dt (n v) = n p'' + (v + s' w) H v + s' n w'.
void ContactMotion::ask_of_part(BodyTouch& at, const State& state) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  const Part& own = part(at.body);
  const FrameMotion& frame = frames_[meeting.obstacle];
  const Quat back = frame.rotation.conjugate();
  const Vec3 local = back * (at.arm - frame.position), n = back * at.touch.normal;
  const PointMotion carried = frame.point(local);
  const Vec3 passes = velocity_of_part(at, state) - carried.velocity;
  Vec3 asked = carried.acceleration + 2 * frame.spin.cross(passes);
  asked -= (1 - at.share) * led(state, own.first) + at.share * led(state, own.next);
  const Vec3 way = place(state, own.next) - place(state, own.first);
  const Vec3 w = back * way, v = back * passes;
  const Vec3 turns =
      back * (velocity(state, own.next) - velocity(state, own.first) - frame.spin.cross(way));
  Vec3 there = local;  // what tips about the end of a face rolls over the edge beside it
  if (at.spot == Spot::first) there -= kBeside * w;
  if (at.spot == Spot::last) there += kBeside * w;
  const Vec3 bends = meeting.shape.normal_rate(there, w);
  const double curve = bends.dot(w);
  const double travels =
      curve > kStraight * w.squaredNorm() ? -(bends.dot(v) + n.dot(turns)) / curve : 0;
  const Vec3 rate = meeting.shape.normal_rate(there, v + travels * w);
  at.touch.least = at.touch.normal.dot(asked) - rate.dot(v) - travels * n.dot(turns);
  at.touch.surface = asked - travels * (frame.rotation * turns);
}

/// m/s^2, without pulls and touches. What is held has none of its own where links touch.
Vec3 ContactMotion::weight(std::size_t point) const {
  const bool held = mechanism_.inverse_mass()[point] == 0;
  return held && !parts_.empty() ? Vec3(Vec3::Zero()) : mechanism_.gravity();
}

/// By how much the distance from a solid rises along a link, at one of its ends.
double ContactMotion::slope(const BodyMeeting& meeting, const State& state, double along) const {
  const Capsule own = capsule(state, meeting.body);
  return gap_at(meeting.shape, solid(meeting, state), own, along)
      .normal.dot((own.to - own.from).normalized());
}

/// Whether a spot is one that may touch: a bead; the nearest of a link between its beads, however
/// close to one; or both ends of what lies flat.
bool ContactMotion::is_place(const BodyMeeting& meeting, const State& state,
                             const std::array<SpotGap, 5>& gaps, Spot spot) const {
  const SpotGap& near = gaps[static_cast<std::size_t>(spot)];
  if (!is_part(meeting.body)) return near.distinct;
  if (part(meeting.body).is_bead()) return spot == Spot::from;
  if (spot == Spot::from || spot == Spot::to) return false;
  const bool flat = lies_evenly(gaps);
  const auto inside = [&](double by) { return near.along > by && near.along < 1 - by; };
  if (meeting.shape.kind == Shape::Kind::plane || flat != (spot != Spot::nearest)) return false;
  if (flat) return inside(kAtEnd);
  const double level =
      near.distance +
      kLevelled *
          (place(state, part(meeting.body).next) - place(state, part(meeting.body).first)).norm();
  if (gaps[0].distance <= level && gaps[1].distance <= level) return false;  // its beads touch
  if (inside(kAtBead)) return true;
  return slope(meeting, state, 0) < -kLevel / 2 && slope(meeting, state, 1) > kLevel / 2;
}

/// Opens beads where a link beside them touches at the same place.
void ContactMotion::leave_to_links() {
  const auto is_there = [&](const BodyTouch& at, std::uint32_t point, std::uint32_t obstacle) {
    if (part(at.body).is_bead() || meetings_[at.meeting].obstacle != obstacle) return false;
    return (part(at.body).first == point && at.share < kAtBead) ||
           (part(at.body).next == point && at.share > 1 - kAtBead);
  };
  const auto links = std::vector<BodyTouch>(body_touches_);
  std::erase_if(body_touches_, [&](const BodyTouch& bead) {
    if (!is_part(bead.body) || !part(bead.body).is_bead()) return false;
    return std::ranges::any_of(links, [&](const BodyTouch& at) {
      return is_part(at.body) &&
             is_there(at, part(bead.body).first, meetings_[bead.meeting].obstacle);
    });
  });
}

/// The events of a closed touch of a part: a link gets to its bead, or a bead to a link; a law is
/// broken, as what touches is led apart.
void ContactMotion::part_events(const BodyTouch& at, const State& state,
                                std::vector<double>& values) const {
  const BodyMeeting& meeting = meetings_[at.meeting];
  values.push_back(kBroken * stir(at) - off(at));
  if (!part(at.body).is_bead()) {
    const bool flat =
        lies_evenly(all_gaps(meeting.shape, solid(meeting, state), capsule(state, at.body)));
    values.push_back(flat == (at.spot != Spot::nearest) ? 1 : -1);
    if (at.spot != Spot::nearest) {
      values.push_back(std::min(at.share, 1 - at.share) - kAtEnd);
      return;
    }
    values.push_back(-slope(meeting, state, 0));
    values.push_back(slope(meeting, state, 1));
    return;
  }
  if (meeting.shape.kind == Shape::Kind::plane) return;
  const std::uint32_t point = part(at.body).first;
  for (const BodyMeeting& other : meetings_) {
    if (!is_part(other.body) || other.obstacle != meeting.obstacle) continue;
    const Part& link = part(other.body);
    if (link.is_bead() || (link.first != point && link.next != point)) continue;
    const double along = link.first == point ? 0 : 1;
    const bool flat =
        lies_evenly(all_gaps(other.shape, solid(other, state), capsule(state, other.body)));
    values.push_back(flat ? 1 : kLevel + (1 - 2 * along) * slope(other, state, along));
  }
}

/// m/s^2, by which a closed touch breaks its law under what was found last.
double ContactMotion::off(const BodyTouch& at) const {
  const Vec3 moves = passing(after_impact(), at);
  const double apart = moves.dot(at.touch.normal) - at.touch.least;
  if (at.touch.state != Touch::State::sticks) return std::abs(apart);
  return std::hypot(apart, (across(at.touch.normal) * (moves - at.touch.surface)).norm());
}

/// The number among the body points; kNoBody: no free body carries it.
std::uint32_t ContactMotion::carrier(std::uint32_t point) const {
  if (!is_carried_[point]) return kNoBody;
  const auto found =
      std::ranges::find(mechanism_.body_points(), point, &Mechanism::BodyPoint::point);
  return small(std::size_t(found - mechanism_.body_points().begin()));
}

}  // namespace taut::contact
