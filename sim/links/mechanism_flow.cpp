// How a mechanism pays rope out: winches, as the time tells, and pulleys, as they turn.
#include <algorithm>

#include "sim/links/mechanism.h"
#include "sim/material/elements.h"

namespace taut {
namespace {

Eigen::Map<const Vec3> as_vector(const double* at) {
  return Eigen::Map<const Vec3>(at);
}

/// The share of the length paid out at an end (first 0, last 1) that passes a particle, forwards.
double flow_share(const Winch& winch, std::size_t end, std::size_t particle) {
  return end == 0 ? 1 - winch.before[particle] : -winch.before[particle];
}

}  // namespace

void Mechanism::place_winches(double time, const double* state) {
  for (Winched& at : winches_) {
    at.first = at.winch->paid_out(0, time);
    at.last = at.winch->paid_out(1, time);
  }
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const PaidOut moved{state[passed(p)], state[speed(p)]};
    PaidOut& first = winches_[pulleys_[p].end[1].winched].first;
    PaidOut& last = winches_[pulleys_[p].end[0].winched].last;
    first = first + moved;
    last = last + PaidOut{-moved.length, -moved.rate};
  }
  for (Winched& at : winches_) {
    const Winch& winch = *at.winch;
    at.longer = at.first + at.last;
    const double longer = at.longer.length;
    for (std::size_t k = 0; k < winch.rest.size(); ++k) {
      double& rest = rows_[at.first_row + k].rest;
      rest = winch.rest[k] + winch.share(k) * longer;
      if (material_.any()) material_.set_rest(at.first_point + small(k), rest);
      if (!at.first_drag) continue;
      const double speed =
          winch.flow(k, at.first, at.last).speed + winch.flow(k + 1, at.first, at.last).speed;
      material_.flow_past(*at.first_drag + k, speed / 2);
    }
    material_.bend_over_lengths(at.first_bend, at.bends_end);
    for (std::size_t i = 0; i < winch.particle_mass.size(); ++i) {
      double& easy = inverse_mass_[at.first_point + i];
      if (easy == 0) continue;
      easy = 1 / (winch.particle_mass[i] + winch.density * winch.share_at(i) * longer);
    }
  }
}

void Mechanism::add_flow(const double* state, std::vector<Vec3>& force) const {
  const double* velocities = state + velocities_;
  for (const Winched& at : winches_) {
    const Winch& winch = *at.winch;
    for (std::size_t k = 0; k < winch.rest.size(); ++k) {
      const std::size_t a = at.first_point + k, b = a + 1;
      const Winch::Flow before = winch.flow(k, at.first, at.last),
                        behind = winch.flow(k + 1, at.first, at.last);
      const Vec3 gap = as_vector(state + 3 * b) - as_vector(state + 3 * a);
      const Vec3 turned = (before.speed + behind.speed) *
                          (as_vector(velocities + 3 * b) - as_vector(velocities + 3 * a));
      force[a] -= winch.density / 2 * (turned + before.rate * gap);
      force[b] -= winch.density / 2 * (turned + behind.rate * gap);
    }
  }
}

Vec3 Mechanism::flow_past(std::size_t point, const double* state) const {
  for (const Winched& at : winches_) {
    const std::size_t links = at.winch->rest.size();
    if (point < at.first_point || point > at.first_point + links) continue;
    const std::size_t i = point - at.first_point;
    const std::size_t before = i == 0 ? 0 : i - 1, behind = i == links ? links : i + 1;
    const Vec3 way = as_vector(state + position(at.first_point + behind)) -
                     as_vector(state + position(at.first_point + before));
    return at.winch->flow(i, at.first, at.last).speed * way.normalized();
  }
  return Vec3::Zero();
}

/// Beside measure(): rest lengths change.
void Mechanism::measure_winches() {
  for (const Winched& at : winches_) {
    for (std::size_t k = 0; k < at.winch->rest.size(); ++k) {
      rate_[at.first_row + k] -= at.winch->share(k) * at.longer.rate;
      velocity_term_[at.first_row + k] -= at.winch->share(k) * at.longer.acceleration;
    }
  }
}

/// By how much (N) the energy of bends falls with what a connector pays out.
double Mechanism::bending_force(const Winched& at, const double* state) const {
  double sum = 0;
  Vec3 e0, e1;
  for (std::size_t b = at.first_bend; b < at.bends_end; ++b) {
    const material::BendElement& bend = material_.bends()[b];
    material_.edges(bend, state, e0, e1);
    const std::size_t particle = bend.b - at.first_point;
    double length = 0, share = 0;  // of half of either link
    const auto add = [&](std::size_t link) {
      length += rows_[at.first_row + link].rest / 2;
      share += at.winch->share(link) / 2;
    };
    if (!bend.clamped_before()) add(particle - 1);
    if (!bend.clamped_behind()) add(particle);
    sum += material::Bend(e0, e1, bend.rest).energy(bend.stiffness) / length * share;
  }
  return sum;
}

double Mechanism::paying_force(const Winched& at, std::size_t end, const double* state,
                               std::span<const Vec3> acceleration, const PointMotion& frame) const {
  const Winch& winch = *at.winch;
  const double bent = bending_force(at, state);
  if (winch.density == 0 && !at.first_drag) return bent;
  const auto point = [&](std::size_t particle) { return at.first_point + particle; };
  const auto place = [&](std::size_t i) -> Vec3 {
    return as_vector(state + position(point(i))) - frame.position;
  };
  const auto velocity_at = [&](std::size_t i) -> Vec3 {
    return as_vector(state + velocity(point(i))) - frame.velocity;
  };
  const Vec3 weight = gravity_ - frame.acceleration;
  double rate = 0, slope = 0, air = 0;  // of dL/dq' by time, dL/dq
  for (std::size_t k = 0; k < winch.rest.size(); ++k) {
    const double length = rows_[at.first_row + k].rest, share = winch.share(k);
    const Vec3 gap = place(k + 1) - place(k), gap_rate = velocity_at(k + 1) - velocity_at(k);
    Vec3 drag = Vec3::Zero();
    if (at.first_drag) {
      const material::DragElement& link = material_.drags()[*at.first_drag + k];
      drag = material_.drag(link, state, state + velocities_);
    }
    for (const std::size_t i : {k, k + 1}) {
      const double part = flow_share(winch, end, i);
      const Winch::Flow flow = winch.flow(i, at.first, at.last);
      air += part * drag.dot(gap) / length;
      rate += part * ((acceleration[point(i)] - frame.acceleration).dot(gap) +
                      velocity_at(i).dot(gap_rate) + share * at.longer.rate * flow.speed +
                      length * flow.rate);
      slope += share * ((velocity_at(i).squaredNorm() + flow.speed * flow.speed) / 2 +
                        weight.dot(place(i)));
    }
  }
  return winch.density / 2 * (slope - rate) + air + bent;
}

double Mechanism::drum_force(std::size_t connector, std::size_t end, const double* state,
                             const double* tension, std::span<const Vec3> acceleration) const {
  Winched at = *std::ranges::find(winches_, connector, &Winched::connector);
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const double hastens = tension[rows_.size() + p];
    if (pulleys_[p].end[1].connector == connector) at.first.acceleration += hastens;
    if (pulleys_[p].end[0].connector == connector) at.last.acceleration -= hastens;
  }
  const std::size_t eye = at.first_point + (end == 0 ? 0 : at.winch->rest.size());
  double pull = 0;
  for (std::size_t k = 0; k < at.winch->rest.size(); ++k) {
    pull += at.winch->share(k) * tension[at.first_row + k];
  }
  const double own = (end == 0 ? at.first : at.last).rate;
  return pull + at.winch->density / 2 * own * own +
         paying_force(at, end, state, acceleration,
                      {as_vector(state + position(eye)), as_vector(state + velocity(eye)),
                       acceleration[eye]});
}

void Mechanism::add_pulleys(const World& world) {
  pulleys_.clear();
  couplings_.clear();
  unit_.assign(world.pulleys.empty() ? 0 : points(), Vec3::Zero());
  for (const Pulley& pulley : world.pulleys) {
    Passing added{.inertia = pulley.inertia,
                  .has_friction = pulley.has_friction(),
                  .friction = pulley.friction,
                  .bearing = pulley.bearing};
    const std::uint32_t number = small(pulleys_.size());
    std::vector<std::uint32_t> bodies;
    for (const std::size_t side : {0u, 1u}) {
      const std::size_t connector = side == 0 ? pulley.from : pulley.to;
      const auto found = std::ranges::find(winches_, connector, &Winched::connector);
      RopeEnd& end = added.end[side];
      end.connector = small(connector);
      end.winched = small(static_cast<std::size_t>(found - winches_.begin()));
      const std::size_t links = found->winch->rest.size();
      added.has_mass = found->winch->density > 0;
      end.force.assign(links + 1, Vec3::Zero());
      for (std::size_t k = 0; k < links; ++k) {
        const double share = found->winch->share(k);
        couplings_.push_back({found->first_row + small(k), number, side == 0 ? -share : share});
      }
      for (std::size_t b = 0; b < body_points_.size(); ++b) {
        if (body_points_[b].point - found->first_point > links) continue;
        end.carried.push_back(small(b));
        const std::uint32_t body = body_points_[b].body;
        const auto is_it = [&](const auto& push) { return push.first == body; };
        if (std::ranges::none_of(end.pushes, is_it)) end.pushes.push_back({body, {}});
        bodies.push_back(body);
      }
    }
    std::ranges::sort(bodies);
    for (const RowEnd& end : row_ends_) {  // rows of other connectors that these bodies hold
      const std::uint32_t row = end.row, connector = rows_[row].connector;
      if (connector == pulley.from || connector == pulley.to) continue;
      if (std::ranges::binary_search(bodies, body_points_[end.body_point].body)) {
        if (couplings_.back().row != row) couplings_.push_back({row, number, 0});
      }
    }
    pulleys_.push_back(std::move(added));
  }
  const auto size = static_cast<Eigen::Index>(pulleys_.size());
  passing_inertia_.setZero(size, size);
  for (Passing& pulley : pulleys_) {
    if (!pulley.has_friction) continue;
    pulley.before_inertia.setZero(size);
    pulley.inertia_of_all.setZero(size);
  }
}

/// The forces of the material that flows, and on bodies, at a pulley that turns with 1 m/s^2.
void Mechanism::find_flow(Passing& pulley, const double* state) const {
  if (!pulley.has_mass) return;
  for (const std::size_t side : {0u, 1u}) {
    RopeEnd& end = pulley.end[side];
    for (auto& [body, push] : end.pushes) push = {};
    const Winched& at = winches_[end.winched];
    const Winch& winch = *at.winch;
    const double sign = side == 0 ? -1 : 1;  // of what the connector's end pays out
    std::ranges::fill(end.force, Vec3::Zero());
    for (std::size_t k = 0; k < winch.rest.size(); ++k) {
      const double* from = state + position(at.first_point + k);
      const Vec3 half = winch.density / 2 * (as_vector(from + 3) - as_vector(from));
      for (const std::size_t i : {k, k + 1}) {
        end.force[i] -= sign * flow_share(winch, 1 - side, i) * half;
      }
    }
    for (const std::uint32_t b : end.carried) {
      const BodyPoint& carried = body_points_[b];
      const std::size_t particle = carried.point - at.first_point;
      const FreeBody& body = bodies_[carried.body];
      BodyPush& push =
          std::ranges::find(end.pushes, carried.body, &std::pair<std::uint32_t, BodyPush>::first)
              ->second;
      push.linear += body.inverse_mass * end.force[particle];
      push.angular += body.world_inverse * carried.arm.cross(end.force[particle]);
    }
  }
}

template <class Visit>
void Mechanism::each_moved(const RopeEnd& end, Visit visit) const {
  const std::size_t first = winches_[end.winched].first_point;
  for (std::size_t i = 0; i < end.force.size(); ++i) {
    if (inverse_mass_[first + i] != 0) visit(first + i, inverse_mass_[first + i] * end.force[i]);
  }
}

/// Adds to unit_ what the material before or behind a pulley gives all points.
void Mechanism::give_unit(const RopeEnd& end) {
  each_moved(end, [&](std::size_t point, const Vec3& by) { unit_[point] = by; });
  for (const auto& [body, push] : end.pushes) {
    for (const BodyPoint& carried : body_points_) {
      if (body != carried.body) continue;
      unit_[carried.point] += push.linear + push.angular.cross(carried.arm);
    }
  }
}

void Mechanism::clear_unit(const Passing& pulley) {
  for (const RopeEnd& end : pulley.end) {
    each_moved(end, [&](std::size_t point, const Vec3&) { unit_[point].setZero(); });
  }
  for (const BodyPoint& carried : body_points_) unit_[carried.point].setZero();
}

void Mechanism::measure_pulleys(const double* state) {
  for (Passing& pulley : pulleys_) {
    find_flow(pulley, state);
    const Winched &from = winches_[pulley.end[0].winched], &to = winches_[pulley.end[1].winched];
    pulley.free_force = paying_force(to, 0, state, point_acceleration_, {}) -
                        paying_force(from, 1, state, point_acceleration_, {});
    if (pulley.has_friction) measure_friction(pulley, state);
  }
  auto coupling = couplings_.begin();
  for (std::size_t p = 0; p < pulleys(); ++p) {
    Passing& pulley = pulleys_[p];
    const auto first = coupling;
    const auto each_row = [&](auto visit) {
      for (coupling = first; coupling != couplings_.end() && coupling->pulley == p; ++coupling) {
        const Row& row = rows_[coupling->row];
        visit(direction_[coupling->row].dot(unit_[row.b] - unit_[row.a]));
      }
    };
    if (pulley.has_mass) give_unit(pulley.end[0]);
    if (pulley.has_friction) {
      each_row([&](double moved) { coupling->before = moved - std::min(coupling->share, 0.0); });
    }
    if (pulley.has_mass) give_unit(pulley.end[1]);
    each_row([&](double moved) {
      coupling->value = moved - coupling->share;
      coupling->drive = -coupling->value;
    });
    const auto column = static_cast<Eigen::Index>(p);
    for (std::size_t other = 0; other < pulleys(); ++other) {
      Passing& driven = pulleys_[other];
      const double before = passing_inertia(driven, 0, pulley);
      const double behind = passing_inertia(driven, 1, pulley);
      const double all = (other == p ? pulley.inertia : 0) + before + behind;
      passing_inertia_(static_cast<Eigen::Index>(other), column) = all;
      if (!driven.has_friction) continue;
      driven.before_inertia[column] = before + (other == p ? pulley.inertia / 2 : 0);
      driven.inertia_of_all[column] = all;
    }
    if (pulley.has_mass) clear_unit(pulley);
  }
  use_friction();
}

/// How what drives `pulley` falls, by the rope before (0) or behind it (1), with the acceleration
/// of `other`, which gives unit_ to all points.
double Mechanism::passing_inertia(const Passing& pulley, std::size_t side,
                                  const Passing& other) const {
  if (!pulley.has_mass) return 0;
  double sum = 0;
  const RopeEnd& end = pulley.end[side];
  const Winched& at = winches_[end.winched];
  bool shared = false;
  for (const std::size_t side_of_other : {0u, 1u}) {
    if (other.end[side_of_other].winched != end.winched) continue;
    shared = true;
    sum += (side == side_of_other ? 1 : -1) * flow_inertia(at, 1 - side, 1 - side_of_other);
  }
  if (shared) {
    for (std::size_t i = 0; i < end.force.size(); ++i) {
      sum -= end.force[i].dot(unit_[at.first_point + i]);
    }
  } else {  // by a body alone
    for (const std::uint32_t b : end.carried) {
      const std::size_t point = body_points_[b].point;
      sum -= end.force[point - at.first_point].dot(unit_[point]);
    }
  }
  return sum;
}

/// The mass (kg) that moves with what two ends of a connector pay out, or one.
double Mechanism::flow_inertia(const Winched& at, std::size_t end, std::size_t other) const {
  double sum = 0;
  for (std::size_t k = 0; k < at.winch->rest.size(); ++k) {
    const double half = at.winch->density / 2 * rows_[at.first_row + k].rest;
    for (const std::size_t i : {k, k + 1}) {
      sum += half * flow_share(*at.winch, end, i) * flow_share(*at.winch, other, i);
    }
  }
  return sum;
}

std::optional<std::size_t> Mechanism::run_through(double time, double* state) {
  constexpr double kLeast = 1e-2;
  if (pulleys() > 0) place(time, state);
  for (const Passing& pulley : pulleys_) {
    for (const RopeEnd& end : pulley.end) {
      const Winched& at = winches_[end.winched];
      for (std::size_t k = 0; k < at.winch->rest.size(); ++k) {
        if (rows_[at.first_row + k].rest < kLeast * at.winch->rest[k]) return end.connector;
      }
    }
  }
  return {};
}

void Mechanism::right_side(std::vector<double>& right) const {
  right.resize(unknowns());
  for (std::size_t r = 0; r < rows_.size(); ++r) right[r] = free_acceleration(r);
  for (std::size_t p = 0; p < pulleys(); ++p) {
    const Passing& pulley = pulleys_[p];
    right[rows_.size() + p] =
        pulley.slip == Slip::stick ? 0 : pulley.excess() * pulley.before - pulley.free_force;
  }
}

void Mechanism::push_pulleys(const double* by, double* velocities, double* speeds) const {
  for (std::size_t p = 0; p < pulleys(); ++p) {
    if (pulleys_[p].has_mass) {
      for (const RopeEnd& end : pulleys_[p].end) {
        each_moved(end, [&](std::size_t point, const Vec3& unit) {
          Eigen::Map<Vec3>(velocities + 3 * point) += by[p] * unit;
        });
      }
    }
    speeds[p] += by[p];
  }
}

}  // namespace taut
