#include "sim/methods/direct/contact/contact_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace taut::direct {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

constexpr double kTouching = 1e-9;  // of the longest connector
constexpr double kExact = 1e-14;    // of it, or of a metre
constexpr double kShortest = 1e-7;  // s: nothing is located more precisely
constexpr double kMoment = 1e-8;    // s, of an impact where a step begins
constexpr double kMeeting = 1e-6;   // s, of a step in which bodies meet that are as near
constexpr double kTipping = 1e-6;   // s: in longer steps nothing may tip from end to end
constexpr int kRounds = 12;         // of finding what is hit in a step

}  // namespace

void ContactStep::rebuild(const World& world, const std::vector<Obstacle>& obstacles,
                          std::span<const BodyPair> pairs, std::span<const BeadPair> bead_pairs) {
  obstacles_ = &obstacles;
  mechanism_.rebuild(world);
  bodies_.rebuild(world, obstacles, pairs);
  links_.rebuild(world, mechanism_);
  beads_.rebuild(world, mechanism_, bead_pairs);
  system_.rebuild(mechanism_, bodies_.together());
  glide_system_.rebuild(mechanism_, bodies_.together());
  radius_.clear();
  category_.clear();
  double longest = 0;
  for (const Connector& connector : world.connectors) {
    longest = std::max(longest, connector.length);
    const bool joint = !(connector.length > 0);
    category_.insert(category_.end(), connector.particles(), connector.category);
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      radius_.push_back(joint ? -1 : connector.radius);
    }
  }
  for (std::size_t p = 0; p < radius_.size(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) radius_[p] = -1;
  }
  for (std::size_t b = 0; b < mechanism_.bodies().size(); ++b) {
    if (world.connectors.empty()) longest = std::max(longest, bodies_.bounding_radius(b));
  }
  length_ = longest > 0 ? longest : 1;
  touching_ = kTouching * length_;
  exact_ = kExact * std::max(longest, 1.0);
  const std::size_t points = mechanism_.points(), rows = mechanism_.rows().size();
  for (auto* array : {&mean_, &middle_, &free_, &bare_, &behind_, &acceleration_,
                      &last_acceleration_, &steady_}) {
    array->assign(points, Vec3::Zero());
  }
  // Explicit Euler is stable below twice that, and below it brings nothing past its rest.
  const double damping = mechanism_.material().highest_mode(mechanism_.inverse_mass()).damping;
  longest_damped_ = damping > 0 ? 1 / damping : std::numeric_limits<double>::infinity();
  for (auto* array : {&from_, &along_, &to_}) array->assign(rows, Vec3::Zero());
  for (auto* array : {&pull_, &rest_, &change_, &tension_, &last_tension_}) array->assign(rows, 0);
  rebuild_strings();
  mobility_.assign(points, Mat3::Zero());
  bend_.assign(points, Mat3::Zero());
  is_carried_.assign(points, false);
  for (const auto& carried : mechanism_.body_points()) is_carried_[carried.point] = true;
  stiffness_.assign(rows, Mat3::Zero());
  noise_.assign(points, 0);
  arm_.resize(mechanism_.body_points().size());
  inverse_.resize(mechanism_.bodies().size());
  pushed_.assign(mechanism_.bodies().size(), contact::Vec6::Zero());
  last_pushed_ = steady_pushed_ = pushed_;
  bounding_radius_.clear();
  for (std::size_t b = 0; b < pushed_.size(); ++b) {
    bounding_radius_.push_back(bodies_.bounding_radius(b));
  }
  for (const auto& carried : mechanism_.body_points()) {
    bounding_radius_[carried.body] = std::max(bounding_radius_[carried.body], carried.local.norm());
  }
  touches_.clear();
  before_.clear();
  last_hits_ = true;
  watched_ = 0;
  solves_ = 0;
}

void ContactStep::load(const World& world) {
  mechanism_.load(world, state_);
  next_ = state_;
  last_hits_ = true;
  watched_ = 0;
  risen_ = 0;
}

Vec3 ContactStep::position(const std::vector<double>& state, std::size_t point) const {
  return ConstMap(&state[mechanism_.position(point)]);
}

/// Beads that touch at the start, but for those which are leaving. Whether one of them gets there
/// only then, to be thrown back faster than `least` (m/s).
bool ContactStep::find_touches(double least) {
  bool arrives = false;
  before_.swap(touches_);
  touches_.clear();
  for (std::uint32_t p = 0; p < radius_.size(); ++p) {
    if (radius_[p] < 0) continue;
    const Vec3 at = position(state_, p);
    for (std::uint32_t o = 0; o < start_.size(); ++o) {
      if (!(*obstacles_)[o].touches(category_[p])) continue;
      const SurfaceDistance near = gap((*obstacles_)[o], start_[o].pose(), at, radius_[p]);
      if (near.distance > touching_) continue;
      const Vec3 velocity = ConstMap(&state_[mechanism_.velocity(p)]);
      const Vec3 surface =
          start_[o].point(start_[o].rotation.conjugate() * (at - start_[o].position)).velocity;
      const double leaving = near.normal.dot(velocity - surface);
      if (leaving > touching_) continue;
      const std::size_t known = touches_.size();
      add_touch({.point = p,
                 .obstacle = o,
                 .anchor = start_[o].rotation.conjugate() * (at - start_[o].position)},
                known);
      if (touches_.size() == known) continue;
      touches_.back().hits = -leaving * (*obstacles_)[o].restitution > least;
      arrives = arrives || touches_.back().hits;
    }
  }
  return arrives;
}

/// Adds a touch at the end, unless the bead has that one or three already. Touches before `sorted`
/// are in order of points, later ones in that of the calls.
void ContactStep::add_touch(const Hit& hit, std::size_t sorted) {
  const auto of = [&](const std::vector<BeadTouch>& touches, std::size_t count) {
    const auto end = touches.begin() + static_cast<std::ptrdiff_t>(count);
    const auto first =
        std::ranges::lower_bound(touches.begin(), end, hit.point, {}, &BeadTouch::point);
    return std::span(first, std::ranges::upper_bound(first, end, hit.point, {}, &BeadTouch::point));
  };
  const auto same = [&](const BeadTouch& touch) { return touch.obstacle == hit.obstacle; };
  const auto known = of(touches_, sorted);
  if (std::ranges::any_of(known, same)) return;
  std::size_t count = known.size();
  for (std::size_t i = touches_.size(); i-- > sorted && touches_[i].point == hit.point;) ++count;
  if (count == 3) return;
  const Obstacle& obstacle = (*obstacles_)[hit.obstacle];
  BeadTouch made{.point = hit.point,
                 .obstacle = hit.obstacle,
                 .hits = true,
                 .anchor = hit.anchor,
                 .side = obstacle.shape.from(hit.anchor).normal,
                 .touch = {}};
  made.touch.stick = obstacle.static_friction;
  made.touch.slide = obstacle.kinetic_friction;
  const auto before = of(before_, before_.size());
  const auto was = std::ranges::find_if(before, same);
  const bool stuck = was != before.end() && was->touch.state == contact::Touch::State::sticks;
  if (!stuck) {
    const FrameMotion& start = start_[hit.obstacle];
    const Vec3 from = position(state_, hit.point) - start.position;
    made.touch.sliding =
        ConstMap(&state_[mechanism_.velocity(hit.point)]) - start.velocity - start.spin.cross(from);
  }
  touches_.push_back(made);
}

BodyTouches::Step ContactStep::body_step(double time, double h) const {
  return {mechanism_, *obstacles_, start_, end_, state_, time, h, touching_};
}

/// Whether something hit within a share of the step is thrown back.
bool ContactStep::throws_back(double share) const {
  const auto bounces = [&](const auto& hit) {
    return hit.share <= share && (*obstacles_)[hit.obstacle].restitution > 0;
  };
  return std::ranges::any_of(found_, bounces) || std::ranges::any_of(links_.found(), bounces) ||
         bodies_.thrown_back_within(share) || beads_.thrown_back_within(share);
}

/// Adds what was found to the touches, where the step is to end with the first of it to those
/// alone; whether it does.
bool ContactStep::take_hits(bool locates, double& h) {
  double first = 1;
  for (const Hit& hit : found_) {
    if (locates || hit.passes) first = std::min(first, hit.share);
  }
  for (const BodyTouches::Hit& hit : bodies_.found()) {
    if (locates || hit.passes) first = std::min(first, hit.share);
  }
  for (const LinkTouches::Hit& hit : links_.found()) {
    if (locates || hit.passes) first = std::min(first, hit.share);
  }
  for (const BeadTouches::Hit& hit : beads_.found()) {
    if (locates || hit.passes) first = std::min(first, hit.share);
  }
  for (const Snap& snap : snaps_) first = std::min(first, snap.share);
  const bool shortens = first < 1 - 1e-6 && first * h > kShortest;
  // What is thrown back where the step begins is so in a moment, not after the rest of the step.
  const double moment = kShortest / h;
  const bool bounces = locates && first <= moment && moment < 1 && throws_back(moment);
  const double until = bounces ? moment : shortens ? first * (1 + 1e-6) : INFINITY;
  const std::size_t sorted = touches_.size();
  for (const Hit& hit : found_) {
    if (hit.share <= until) add_touch(hit, sorted);
  }
  std::ranges::inplace_merge(touches_, touches_.begin() + static_cast<std::ptrdiff_t>(sorted), {},
                             &BeadTouch::point);
  for (const BodyTouches::Hit& hit : bodies_.found()) {
    if (hit.share <= until) bodies_.add(body_step(0, h), hit);
  }
  for (const LinkTouches::Hit& hit : links_.found()) {
    if (hit.share <= until) links_.add(body_step(0, h), hit);
  }
  for (const BeadTouches::Hit& hit : beads_.found()) {
    if (hit.share <= until) beads_.add(body_step(0, h), hit);
  }
  for (const Snap& snap : snaps_) {
    if (snap.share <= until) taut_[snap.row] = true;
  }
  if (bounces) h = kShortest;
  if (shortens) h *= first;
  // Bodies that meet at once do so in a moment: not held together for the rest of the step.
  const bool meet = bodies_.meet_within(kShortest / h) || beads_.meet_within(kShortest / h);
  const bool at_once = locates && !shortens && h > kMeeting && meet;
  if (at_once) h = kMeeting;
  return shortens || bounces || at_once;
}

/// m/s, of the lowest bounces that are followed.
double ContactStep::lowest_speed(double lowest) const {
  return std::sqrt(2 * mechanism_.gravity().norm() * lowest);
}

double ContactStep::attempt(double time, double h, double slippery, bool locates, double lowest) {
  slippery_ = slippery;
  const std::vector<Obstacle>& obstacles = *obstacles_;
  start_.resize(obstacles.size());
  end_.resize(obstacles.size());
  for (std::size_t o = 0; o < obstacles.size(); ++o) start_[o] = obstacles[o].frame(time);
  mechanism_.update(time, state_.data());
  from_ = mechanism_.direction();
  for (std::size_t i = 0; i < arm_.size(); ++i) arm_[i] = mechanism_.body_points()[i].arm;
  for (std::size_t b = 0; b < inverse_.size(); ++b) {
    inverse_[b] = mechanism_.bodies()[b].world_inverse;
  }
  const double least = lowest_speed(lowest);
  bool arrives = find_touches(least);
  if (bodies_.possible()) arrives = bodies_.find(body_step(time, h), least) || arrives;
  if (links_.possible()) arrives = links_.find(body_step(time, h), least) || arrives;
  if (beads_.possible()) arrives = beads_.find(body_step(time, h), least) || arrives;
  find_taut(!locates);
  if (arrives) h = std::min(h, kMoment);
  hits_ = located_ = arrives;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t o = 0; o < obstacles.size(); ++o) end_[o] = obstacles[o].frame(time + h);
    if (!glide(time, h)) return 0;
    if (h > kTipping && links_.any() && links_.tips(body_step(time, h), next_)) return 0;
    const bool enters = find_hits(time, h), snaps = find_snaps(h);
    const bool hits = bodies_.possible() && !bodies_.hits(body_step(time, h), next_).empty();
    const bool crosses =
        links_.possible() && !links_.hits(body_step(time, h), next_, mean_).empty();
    const bool meets = beads_.possible() && !beads_.hits(body_step(time, h), next_, mean_).empty();
    if (!enters && !snaps && !hits && !crosses && !meets) {
      if (!settle(time, h, least) || !is_finite()) return 0;
      const bool changes = hits_ || last_hits_ || pattern() != last_pattern_;
      const bool touches = !touches_.empty() || couples();
      const EnergyChange change = changes || touches ? energy_change() : EnergyChange();
      gained_ = changes || couples() ? too_fast(change) : 0;
      take_gain(change);
      return h;
    }
    hits_ = true;
    located_ = take_hits(locates, h) || arrives;
  }
  return 0;
}

/// Whether the state after the step is; bodies without rows have no other check.
bool ContactStep::is_finite() const {
  return std::ranges::all_of(next_, [](double value) { return std::isfinite(value); });
}

/// m/s, the most by which the length of a link changes that may not.
double ContactStep::separation_speed(double time) {
  mechanism_.update(time, state_.data());
  find_taut(false);
  double most = 0;
  for (std::size_t r = 0; r < taut_.size(); ++r) {
    const double separating = mechanism_.rate()[r];
    if (!taut_[r]) continue;
    most = std::max(most, mechanism_.rows()[r].pulls ? separating : std::abs(separating));
  }
  return most;
}

double ContactStep::resolve(double time, double lowest) {
  constexpr double kSeparating = 1e-9;  // m/s
  if (!(separation_speed(time) > kSeparating) || attempt(time, kMoment, 0, false, lowest) == 0)
    return 0;
  hits_ = true;
  accept();
  return kMoment;
}

}  // namespace taut::direct
