#include "sim/methods/span_path.h"

#include <algorithm>
#include <cmath>

namespace taut::methods {
namespace {

constexpr double kPresses = 1e-6;  // of a pull: so much presses on a surface
constexpr double kNear = 0.02;     // of a link: a bead so near a surface was on it
constexpr double kLocked = 1e9;    // no pull is so many times another

Vec3 unit(const Vec3& way) {
  const double length = way.norm();
  return length > 0 ? Vec3(way / length) : Vec3(0, 0, 0);
}

/// The touch of the bead on which pulls to both neighbours press most; null: on none.
const contact::Touch* pressed(const TouchingBead& bead, const Vec3& pull, double nearest) {
  const contact::Touch* most = nullptr;
  double push = kPresses;
  for (std::size_t k = 0; k < bead.count; ++k) {
    if (bead.apart_before[k] > nearest) continue;
    const double presses = -bead.touch[k].normal.dot(pull);
    if (presses <= push) continue;
    push = presses;
    most = &bead.touch[k];
  }
  return most;
}

double growth(double friction, double half_bend_tangent) {
  const double rubs = friction * half_bend_tangent;
  return rubs < 1 ? std::min(kLocked, (1 + rubs) / (1 - rubs)) : kLocked;
}

}  // namespace

SpanPath PathFinder::find(const World& world, const Span& span, const std::vector<double>& along,
                          BeadTouches& touches) {
  const Connector& connector = world.connectors[span.connector];
  const std::vector<Vec3>& position = connector.position;
  const std::size_t a = span.a.particle, b = span.b.particle;
  const auto foot = [&](const TouchingBead& bead) {  // on the surface that it touches
    return Vec3(position[bead.particle] - bead.apart[0] * bead.touch[0].normal);
  };
  const auto place = [&](std::size_t k) {  // of the corners so far, counted from 1; 0: the end a
    return k == 0 ? position[a] : foot(*corners_[k - 1]);
  };
  const auto touch_at = [&](const TouchingBead& bead, const Vec3& before, const Vec3& after) {
    const Vec3 at = foot(bead);
    const double link = std::min(connector.rest[bead.particle - 1], connector.rest[bead.particle]);
    return pressed(bead, unit(before - at) + unit(after - at), kNear * link);
  };
  const auto straighten = [&](const Vec3& next) {
    while (!corners_.empty()) {
      if (touch_at(*corners_.back(), place(corners_.size() - 1), next)) return;
      corners_.pop_back();
    }
  };
  corners_.clear();
  auto bead = std::ranges::lower_bound(
      touches.beads(), std::pair(span.connector, a + 1), {},
      [](const TouchingBead& one) { return std::pair(one.connector, one.particle); });
  for (; bead != touches.beads().end() && bead->connector == span.connector && bead->particle < b;
       ++bead) {
    straighten(foot(*bead));
    corners_.push_back(&*bead);
  }
  straighten(position[b]);

  SpanPath path;
  path.bends = !corners_.empty();
  for (std::size_t k = 0; k < corners_.size(); ++k) {
    const Vec3 at = place(k + 1), before = place(k);
    const Vec3 after = k + 1 < corners_.size() ? place(k + 2) : position[b];
    const contact::Touch* touch = touch_at(*corners_[k], before, after);
    if (!touch) touch = corners_[k]->touch.data();
    const Vec3 back = unit(before - at), on = unit(after - at);
    const double half_bend = (back + on).norm() / (on - back).norm();
    path.most_stuck *= growth(touch->stick, half_bend);
    path.most_slid *= growth(touch->slide, half_bend);
    const SpanPath::Corner corner{corners_[k]->particle, at, touch->surface,
                                  touch->normal.dot(touch->surface) * touch->normal};
    if (k == 0) {
      path.first = corner;
    } else {
      const Vec3 way = at - path.last.at;
      path.inner += way.norm();
      path.inner_rate += unit(way).dot(corner.led - path.last.led);
    }
    path.last = corner;
  }
  if (!path.bends) return path;
  path.most_stuck = std::min(path.most_stuck, kLocked);
  path.most_slid = std::min(path.most_slid, kLocked);
  path.first_length = along[path.first.particle] - along[a];
  path.last_length = along[b] - along[path.last.particle];
  return path;
}

}  // namespace taut::methods
