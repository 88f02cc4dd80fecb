#include "sim/contact/capsule.h"

#include <algorithm>
#include <cmath>

#include "sim/contact/near_links.h"
#include "sim/motion/larger.h"
#include "sim/motion/rotation.h"
#include "sim/world/places.h"

namespace taut::contact {
namespace {

constexpr double kTurn = 1e-2;    // rad: turned by that, what lies flat touches at one end of it
constexpr double kCrosses = 10;   // cot^2 of 17 degrees: what crosses by more does not lie flat
constexpr double kSame = 1e-6;    // of the axis: spots so near to each other are one
constexpr double kFlat = 1e-10;   // of the axis' length: distances so near to each other are equal
constexpr double kEvenly = 1e-9;  // rad: slopes so near to each other are one
constexpr double kFarther = 1.5;  // times the way that it rolls and slides: it tips
constexpr int kHalvings = 54;     // of a double's fraction
constexpr int kToCell = 40;       // of these, down to a cell that may be guessed
constexpr double kCell = 0x1p-40;
constexpr int kTrials = 20;  // of a guess

/// The first and the last of what lies flat, and whether distances rise evenly between.
struct Flat {
  double first = 0, last = 0;
  bool even = false;
};

/// A capsule's axis in the frame of a solid.
struct Axis {
  Axis(const Shape& of, const Pose& frame, const Capsule& capsule)
      : shape(of),
        from(frame.rotation.conjugate() * (capsule.from - frame.position)),
        way(frame.rotation.conjugate() * (capsule.to - capsule.from)),
        length(way.norm()) {}

  SurfaceDistance at(double along) const { return shape.from(from + along * way); }

  /// Where distances plus `turn` (rad) times the way along the axis are least: they are convex, so
  /// that their slope rises.
  double least(double turn) const {
    const auto rise = [&](double along) { return at(along).normal.dot(way) + turn * length; };
    const double first = rise(0), last = rise(1);
    if (first >= 0) return 0;
    if (!(last >= 0)) return 1;
    // The cell of a grid that halvings would come to, or else all of the axis.
    double low = std::clamp(guess(first, last, rise), 0.0, 1 - kCell), high = low + kCell;
    int halvings = kHalvings - kToCell;
    if (rise(low) >= 0 || !(rise(high) >= 0)) low = 0, high = 1, halvings = kHalvings;
    for (; halvings > 0; --halvings) {
      const double middle = (low + high) / 2;
      (rise(middle) >= 0 ? high : low) = middle;
    }
    return high;
  }

  /// Where `rise` may cross zero, which it does in kCell of that: regula falsi, by Illinois.
  static double guess(double first, double last, const auto& rise) {
    double low = 0, high = 1, along = 0;
    bool rose = false;
    for (int i = 0; i < kTrials; ++i) {
      const double before = along;
      along = (low * last - high * first) / (last - first);
      if (!(along > low && along < high) || std::abs(along - before) < kCell / 8) break;
      const double there = rise(along);
      const bool rises = there >= 0, again = i > 0 && rises == rose;
      if (rises) {
        high = along, last = there;
        if (again) first /= 2;
      } else {
        low = along, first = there;
        if (again) last /= 2;
      }
      rose = rises;
    }
    return std::floor(along / kCell) * kCell;
  }

  /// An end of what lies flat, where the turned axis touches a rounded edge beside it: the point of
  /// the axis over the curve's centre is where it lies.
  double over_curve(double along) const {
    if (!(along > 0 && along < 1)) return along;
    const SurfaceDistance near = at(along);
    const double rounding = shape.kind == Shape::Kind::capsule ? shape.radius : shape.rounding;
    const Vec3 centre = from + along * way - (near.distance + rounding) * near.normal;
    return std::clamp(way.dot(centre - from) / (length * length), 0.0, 1.0);
  }

  double slope(double along) const { return at(along).normal.dot(way) / length; }

  /// The first and the last of what lies flat. Over a face that is flat itself distances rise
  /// evenly; tipped about an end, the axis touches the edge beside it.
  Flat flat_ends() const {
    const double low = least(kTurn), high = least(-kTurn), tilt = slope((low + high) / 2);
    const double first = least(kEvenly - tilt), last = least(-kEvenly - tilt);
    if (!(last - first > (high - low) / 2)) return {over_curve(low), over_curve(high), false};
    const double nearest = least(0);
    return {std::min(first, nearest), std::max(last, nearest), true};
  }

  double along(Spot spot) const {
    if (spot == Spot::from || !(length > 0)) return 0;
    if (spot == Spot::to) return 1;
    return least(0);
  }

  const Shape& shape;
  Vec3 from, way;
  double length;
};

/// m, of the axis of a capsule that rolls over an edge or a round solid.
double curve(const Shape& shape, double radius) {
  const bool round = shape.kind == Shape::Kind::capsule || shape.kind == Shape::Kind::cylinder;
  return radius + (round ? shape.radius : shape.rounding);
}

bool lies_flat(const Shape& shape) {
  return shape.kind != Shape::Kind::plane && shape.kind != Shape::Kind::sphere;
}

SpotGap gap_of(const Axis& axis, const Pose& frame, double radius, double along) {
  const SurfaceDistance near = axis.at(along);
  return {along, near.distance - radius, frame.rotation * near.normal};
}

}  // namespace

SpotGap gap_at(const Shape& shape, const Pose& frame, const Capsule& capsule, double along) {
  return gap_of(Axis(shape, frame, capsule), frame, capsule.radius, along);
}

SpotGap gap_at(const Shape& shape, const Pose& frame, const Capsule& capsule, Spot spot) {
  const Axis axis(shape, frame, capsule);
  if (spot <= Spot::nearest || !(axis.length > 0)) {
    return gap_of(axis, frame, capsule.radius, axis.along(spot));
  }
  const Flat flat = axis.flat_ends();
  SpotGap gap = gap_of(axis, frame, capsule.radius, spot == Spot::first ? flat.first : flat.last);
  gap.even = flat.even;
  return gap;
}

std::array<SpotGap, 5> all_gaps(const Shape& shape, const Pose& frame, const Capsule& capsule) {
  const Axis axis(shape, frame, capsule);
  std::array<SpotGap, 5> gaps;
  const bool point = !(axis.length > 0);
  Flat ends;
  if (!point && lies_flat(shape)) ends = axis.flat_ends();
  for (const Spot spot : kSpots) {
    SpotGap& gap = gaps[static_cast<std::size_t>(spot)];
    const bool end = spot == Spot::from || spot == Spot::to;
    if (!end && (shape.kind == Shape::Kind::plane || point)) {
      gap = gaps[0];
      gap.distinct = false;
      continue;
    }
    if (spot > Spot::nearest && !lies_flat(shape)) {
      gap = gaps[2];
      gap.distinct = false;
      continue;
    }
    const bool flat = spot == Spot::first || spot == Spot::last;
    const double along = flat ? (spot == Spot::first ? ends.first : ends.last) : axis.along(spot);
    gap = gap_of(axis, frame, capsule.radius, along);
    gap.even = flat && ends.even;
    if (!end) gap.distinct = gap.along > kSame && gap.along < 1 - kSame;
    if (spot == Spot::to) gap.distinct = !point;
  }
  const auto apart = [&](std::size_t i, std::size_t k) {
    return std::abs(gaps[i].along - gaps[k].along) > kSame;
  };
  // An axis that crosses a round solid at an angle a: they are 2 kTurn cot^2(a) of the radii apart.
  const double between = axis.length * std::abs(gaps[4].along - gaps[3].along);
  const double rolls = 2 * kTurn * curve(shape, capsule.radius);
  if (!apart(3, 4) || between < kCrosses * rolls) {  // it does not lie flat
    gaps[3].distinct = gaps[4].distinct = false;
  } else if (!apart(2, 3) || !apart(2, 4)) {
    gaps[2].distinct = false;
  }
  bool before = false, behind = false;
  for (std::size_t i = 0; i < gaps.size(); ++i) {
    if (i == 2 || !gaps[i].distinct) continue;
    if (gaps[i].distance > gaps[2].distance + kFlat * axis.length) continue;
    (gaps[i].along < gaps[2].along ? before : behind) = true;
  }
  if (before && behind) gaps[2].distinct = false;
  return gaps;
}

bool tips(const Shape& shape, const Pose& start, const Capsule& from, double from_along,
          const Pose& end, const Capsule& to, double to_along) {
  if (!lies_flat(shape)) return false;
  const Axis before(shape, start, from), after(shape, end, to);
  const double turn = (after.way / after.length - before.way / before.length).norm();
  const double rolls = (1 + kCrosses) * curve(shape, from.radius) * turn;
  const Vec3 first = after.from - before.from, last = first + after.way - before.way;
  const double slides = std::sqrt(1 + kCrosses) * std::max(first.norm(), last.norm());
  const double moves = to_along - from_along;
  if (std::abs(moves) * before.length <= kFarther * (rolls + slides)) return false;
  // Distances rise evenly over what is flat, ever faster over what is round.
  return std::ranges::any_of(std::array{&before, &after}, [&](const Axis* axis) {
    const double near = axis->slope(from_along + moves / 4);
    const double far = axis->slope(from_along + 3 * moves / 4);
    return std::abs(far - near) < std::max(std::abs(near), std::abs(far)) / 4;
  });
}

double least_gap(const Shape& shape, const Pose& frame, const Capsule& capsule) {
  const Axis axis(shape, frame, capsule);
  double least = std::min(axis.at(0).distance, axis.at(1).distance);
  if (shape.kind != Shape::Kind::plane && axis.length > 0) {
    least = std::min(least, axis.at(axis.least(0)).distance);
  }
  return least - capsule.radius;
}

double least_gap(const Capsule& solid, const Capsule& capsule) {
  const Vec3 way = solid.to - solid.from;
  const double length = way.norm();
  const Pose frame{solid.at(0.5),
                   length > 0 ? rotation_between(Vec3::UnitY(), way) : Quat::Identity()};
  const Shape shape = length > 0 ? capsule_shape(solid.radius, length) : sphere_shape(solid.radius);
  return least_gap(shape, frame, capsule);
}

double penetration_max(const World& world) {
  double most = 0;
  for (const Obstacle& obstacle : world.obstacles) {
    const Pose frame = obstacle.frame(world.time).pose();
    for (const Connector& connector : world.connectors) {
      if (!obstacle.touches(connector.category)) continue;
      for (std::size_t i = 0; i < connector.particles(); ++i) {
        if (holds(connector, i)) continue;
        const Vec3& at = connector.position[i];
        most = larger(most, -gap(obstacle, frame, at, connector.radius).distance);
      }
    }
    for (const Body& body : world.bodies) {
      const BodyCapsule& own = body.capsule;
      if (body.driven() || !own.touches() || !obstacle.touches(own.category)) continue;
      const Capsule capsule{body.point(own.from), body.point(own.to), own.radius};
      most = larger(most, -least_gap(obstacle.shape, frame, capsule));
    }
  }
  return larger(most, deepest_link(world));
}

}  // namespace taut::contact
