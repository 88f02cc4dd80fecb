// From a component of a world to a system.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/system.h"
#include "sim/stick.h"

namespace taut::direct {
namespace {

/// Two particles joined by a link this short, as a share of their span's length, are one point.
constexpr double kLeastLink = 1e-6;

/// A particle without mass, which the model has no equation for, is taken to weigh this share of
/// everything that moves with it.
constexpr double kLeastMass = 1e-9;

}  // namespace

void System::reserve(std::size_t points, std::size_t ends, std::size_t bodies) {
  const std::size_t room = points + 2 * ends;
  point_mass_.reserve(room);
  link_rest_.reserve(room);
  held_.reserve(room);
  point_of_.reserve(room);
  arena_.reserve(32 * (room + 3 * kLanes));
  spans_.reserve(ends);
  ends_.reserve(ends);
  body_ends_.reserve(ends);
  bars_.reserve(ends);
  bodies_.reserve(ends);
  body_of_.reserve(bodies);
  bar_of_.reserve(bodies);
}

void System::rebuild(const World& world, const Component& component,
                     const std::optional<Plane>& plane) {
  world_ = &world;
  plane_ = plane;
  axes_ = plane ? 2 : 3;
  left_plane_.reset();
  body_of_.assign(world.bodies.size(), kNone);
  bar_of_.assign(world.bodies.size(), kNone);
  spans_.clear();
  ends_.clear();
  bars_.clear();
  bodies_.clear();
  point_mass_.clear();
  link_rest_.clear();
  held_.clear();
  point_of_.clear();
  mass_ = 0;
  for (const std::size_t b : component.bodies) {
    const MassProperties& m = world.bodies[b].mass_properties;
    mass_ += m.mass;
    if (plane) {
      bar_of_[b] = bars_.size();
      bars_.emplace_back().body = b;
      continue;
    }
    body_of_[b] = bodies_.size();
    RigidBody& body = bodies_.emplace_back();
    body.body = b;
    body.mass = m.mass;
    body.inertia = m.inertia;
    body.inverse_inertia = m.inertia.inverse();
  }
  for (const SpanRange& range : component.spans) add_span(world, range);
  floats_ = std::ranges::all_of(ends_, [](const End& end) { return end.body != kNone; });
  lay_out();
  couple();
  for (int c = 0; c < 3; ++c) {
    const Vec3 axis = !plane ? Vec3::Unit(c) : c == 0 ? plane->x : c == 1 ? plane->y : Vec3::Zero();
    gravity_axes_[c] = world.gravity.dot(axis);
  }
}

void System::add_point(double mass) {
  point_mass_.push_back(mass);
  link_rest_.push_back(0);
  held_.push_back(false);
}

void System::add_end(const World& world, const Attachment& to, std::size_t point, std::size_t link,
                     double pull) {
  End& end = ends_.emplace_back();
  end.point = point;
  end.link = link;
  end.pull = pull;
  end.to = to;
  held_[point] = true;
  point_mass_[point] = 0;
  if (is_prescribed(world, to)) return;
  end.body = body_of_[to.body];
  end.local_arm = to.point - world.bodies[to.body].mass_properties.centre;
  ++bodies_[end.body].ends;
}

/// The points of a span in the order of its particles, with a point more for each bar at its ends.
void System::add_span(const World& world, const SpanRange& range) {
  const Connector& connector = world.connectors[range.connector];
  const auto hold = [&](std::size_t particle) { return hold_at(connector, particle); };
  const auto bar_at = [&](std::size_t particle) {
    const Hold* by = hold(particle);
    return by && !is_prescribed(world, by->to) ? bar_of_[by->to.body] : kNone;
  };
  const auto stick = [&](Bar& bar, std::size_t particle) {
    const Body& body = world.bodies[bar.body];
    const MassProperties& m = body.mass_properties;
    const Vec3 normal = body.rotation.conjugate() * plane_->normal;
    bar.arm = (hold(particle)->to.point - m.centre).norm();
    return Stick(m.mass, normal.dot(m.inertia * normal), bar.arm);
  };
  Span& span = spans_.emplace_back();
  span.range = range;
  const std::size_t begin = point_mass_.size();
  if (const std::size_t b = bar_at(range.first); b != kNone) {
    const Stick made = stick(bars_[b], range.first);
    add_point(made.far);
    link_rest_.back() = made.reach;
    bars_[b].far = begin, bars_[b].tip = begin + 1;
  }
  const std::size_t first = point_mass_.size();
  span.first_particle = point_of_.size();
  const double least = kLeastLink * connector.length;
  for (std::size_t k = range.first; k <= range.last; ++k) {
    const bool carried = hold(k) && (k == range.first || k == range.last);
    const double mass = carried ? 0 : connector.particle_mass[k];
    mass_ += mass;
    const bool joined = k > range.first && !(connector.rest[k - 1] > least);
    if (joined) {
      point_mass_.back() += mass;
    } else {
      if (k > range.first) link_rest_.back() = connector.rest[k - 1];
      add_point(mass);
    }
    point_of_.push_back(point_mass_.size() - 1);
  }
  if (const std::size_t b = bar_at(range.last); b != kNone) {
    const Stick made = stick(bars_[b], range.last);
    point_mass_.back() = made.tip;
    link_rest_.back() = made.reach;
    bars_[b].tip = point_mass_.size() - 1, bars_[b].far = point_mass_.size();
    add_point(made.far);
  }
  if (const std::size_t b = bar_at(range.first); b != kNone) {
    point_mass_[first] = stick(bars_[b], range.first).tip;
  }
  span.first_link = begin;
  const std::size_t last = point_mass_.size() - 1;
  if (hold(range.first) && bar_at(range.first) == kNone) {
    add_end(world, hold(range.first)->to, first, first, 1);
  }
  if (hold(range.last) && bar_at(range.last) == kNone) {
    add_end(world, hold(range.last)->to, last, last - 1, -1);
  }
}

void System::lay_out() {
  points_ = point_mass_.size();
  held_.push_back(true);  // behind the last point
  stride_ = (points_ + 1 + kLanes - 1) / kLanes * kLanes;
  const std::size_t room = stride_ + 2 * kLanes;
  double** const rows[] = {
      &rest_,    &inverse_rest_, &inverse_mass_, &falls_, &scale_, &beside_, &weight_, &after_,
      &before_,  &wave_,         &near_,         &far_,   &apart_, &off_,    &turned_, &right_,
      &unknown_, &change_,       &stiffness_,    &pivot_, &up_,    &down_};
  constexpr std::size_t kRows = std::size(rows);
  arena_.assign((kRows + 3) * room + 2 * (3 * stride_ + 2 * kLanes), 0.0);
  double* next = arena_.data() + kLanes;
  for (double** row : rows) *row = next, next += room;
  work_space_ = next, next += 3 * room;
  u_ = next, next += 3 * stride_ + 2 * kLanes;
  work_u_ = next;

  const double least = kLeastMass * (mass_ > 0 ? mass_ : 1);
  length_ = 0;
  for (std::size_t k = 0; k < points_; ++k) {
    inverse_mass_[k] = held_[k] ? 0 : 1 / std::max(point_mass_[k], least);
    falls_[k] = held_[k] ? 0 : 1;
    rest_[k] = link_rest_[k];
    length_ += rest_[k];
  }
  shortest_ = points_ > 0 ? length_ : 1;
  std::vector<double>& body_mobility = link_rest_;  // no longer needed
  std::ranges::fill(body_mobility, 0.0);
  for (const End& end : ends_) {
    if (end.body != kNone) body_mobility[end.link] += 1 / bodies_[end.body].mass;
  }
  for (std::size_t i = 0; i < points_; ++i) {
    if (!(rest_[i] > 0)) {  // behind a span
      near_[i] = far_[i] = 1;
      continue;
    }
    shortest_ = std::min(shortest_, rest_[i]);
    inverse_rest_[i] = 1 / rest_[i];
    const double both = inverse_mass_[i] + inverse_mass_[i + 1];
    const double sum = both + body_mobility[i];
    scale_[i] = sum > 0 ? std::sqrt(2 / sum) : 1;
    weight_[i] = rest_[i] * scale_[i];
    near_[i] = inverse_mass_[i] * scale_[i] * scale_[i];
    far_[i] = inverse_mass_[i + 1] * scale_[i] * scale_[i];
    wave_[i] = 2 * both * scale_[i] * inverse_rest_[i];
    after_[i] = inverse_mass_[i] * scale_[i];
    before_[i + 1] = inverse_mass_[i + 1] * scale_[i];
  }
  for (std::size_t i = 0; i + 1 < points_; ++i) {
    if (rest_[i] > 0 && rest_[i + 1] > 0) {
      beside_[i] = inverse_mass_[i + 1] * scale_[i] * scale_[i + 1];
    } else {
      apart_[i] = far_[i] * near_[i + 1];
    }
  }
}

void System::couple() {
  body_ends_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    bodies_[b].first_end = body_ends_.size();
    for (std::size_t e = 0; e < ends_.size(); ++e) {
      if (ends_[e].body == b) body_ends_.push_back(e);
    }
  }
  coupled_.clear();
  couplings_.clear();
  const auto row_of = [&](std::size_t link) {
    const auto found = std::ranges::find(coupled_, link);
    if (found == coupled_.end()) coupled_.push_back(link);
    return static_cast<std::size_t>(found - coupled_.begin());
  };
  for (const RigidBody& body : bodies_) {
    for (const std::size_t a : ends_of(body)) {
      for (const std::size_t b : ends_of(body)) {
        if (a == b) continue;
        const std::size_t first = row_of(ends_[a].link), second = row_of(ends_[b].link);
        couplings_.push_back({a, b, first, second});
      }
    }
  }
  const auto n = static_cast<Eigen::Index>(coupled_.size());
  response_.assign(points_ * coupled_.size(), 0.0);
  dense_.resize(n, n);
  gain_.resize(n, n);
  dense_right_.resize(n);
  // Cycles: the loops over links, ends and bodies, and the systems of coupled links.
  const auto count = [](std::size_t number) { return static_cast<double>(number); };
  const double links = count(points_), coupled = count(coupled_.size());
  work_ = 450 + (axes_ == 2 ? 20 : 24) * links + 100 * count(ends_.size()) +
          200 * count(bodies_.size()) + coupled * (15 * links + 50) + coupled * coupled * coupled;
}

double System::time_scale() const {
  constexpr double kStandardGravity = 9.80665;  // m/s^2
  return std::sqrt(length_ / kStandardGravity);
}

}  // namespace taut::direct
