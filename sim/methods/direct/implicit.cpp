#include "sim/methods/direct/implicit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/contact/touch.h"
#include "sim/material/elements.h"
#include "sim/measure/measure.h"
#include "sim/methods/direct/controller.h"
#include "sim/methods/direct/system/system.h"
#include "sim/motion/rotation.h"
#include "sim/motion/stop.h"

namespace taut::direct {
namespace {

Eigen::Map<Vec3> vec(double* at) {
  return Eigen::Map<Vec3>(at);
}
Eigen::Map<const Vec3> vec(const double* at) {
  return Eigen::Map<const Vec3>(at);
}

constexpr std::uint32_t kHeld = 0xffffffff;
const double kGamma = 1 - 1 / std::numbers::sqrt2;
/// A share of the inertia that Newton's matrix gives redundant conditions, so that it is regular:
/// of all solutions the nearest is found. It changes the way to the solution, not the solution.
constexpr double kProximal = 1e-9;
/// How often arrivals of one moment may cause others.
constexpr int kRounds = 10;
/// An axis along a surface that is flatter than that share of its curvature across is parallel.
constexpr double kFlat = 1e-6;
/// Static friction is exceeded from that share below its bound on.
constexpr double kBarely = 1e-3;
/// In shorter steps (s) contacts stop sliding and slide back as they must: an impulse, as of a jam,
/// does both at once.
constexpr double kShortestSlide = 1e-6;
/// Links, in lengths of the shortest, within which one looks for what may touch.
constexpr double kNearLinks = 0.25;
/// The cosine of the angle by which the normal of two links turns while they stay on one side of
/// each other.
constexpr double kSameSide = 0.5;
/// What arrives within that time (s) has arrived: no step is so short.
constexpr double kShortestApproach = 4e-12;
/// What stays below its bound by that share does not slide.
constexpr double kSure = 1e-9;

Quat rotation_by(const Vec3& angle) {
  const double half = angle.norm() / 2;
  const double sinc = half > 1e-4 ? std::sin(half) / half : 1 - half * half / 6;
  Quat turn;
  turn.w() = std::cos(half);
  turn.vec() = sinc / 2 * angle;
  return turn;
}

/// A function that is zero where p >= 0, w >= 0 and p w = 0, and its derivatives. Both in m/s.
struct Complementarity {
  double value = 0, by_p = 0, by_w = 0;
};

/// The smaller one, without `kappa`; else Fischer's and Burmeister's, on the central path
/// p w = kappa.
Complementarity complementarity(double p, double w, double kappa) {
  if (kappa < 0) {
    if (p > w) return {w, 0, 1};
    return {p, 1, 0};
  }
  const double root = std::sqrt(p * p + w * w + 2 * kappa), sum = p + w;
  const double value = sum > 0 ? 2 * (p * w - kappa) / (sum + root) : sum - root;
  return {value, 1 - p / root, 1 - w / root};
}

}  // namespace

void ImplicitStep::rebuild(const World& world) {
  settled_ = true;
  mechanism_.rebuild(world);
  touches_.rebuild(world, mechanism_);
  const std::size_t points = mechanism_.points(), bodies = mechanism_.bodies().size();
  node_.assign(points, kHeld);
  carried_.assign(points, kHeld);
  body_.assign(bodies, kHeld);
  std::uint32_t next = 0;
  const auto& easy = mechanism_.inverse_mass();
  for (std::uint32_t p = 0; p < points; ++p) {
    if (easy[p] == 0) continue;
    node_[p] = next;
    next += 3;
  }
  const auto& held = mechanism_.body_points();
  for (std::uint32_t i = 0; i < held.size(); ++i) carried_[held[i].point] = i;
  for (std::uint32_t b = 0; b < bodies; ++b) {
    body_[b] = next;
    next += 6;
  }
  // A joined particle stands where its leader does.
  for (std::uint32_t p = 0; p < points; ++p) {
    const std::size_t leader = mechanism_.leader(p);
    if (leader == p) continue;
    node_[p] = node_[leader];
    carried_[p] = carried_[leader];
  }
  pulley_.resize(mechanism_.pulleys());
  for (std::uint32_t& unknown : pulley_) unknown = next++;
  pulley_law_.assign(pulley_.size(), {});
  slip_before_.assign(pulley_.size(), Mechanism::Slip::free);
  slid_.assign(pulley_.size(), 0.0);
  pulley_mass_.assign(pulley_.size(), 1.0);
  own_acceleration_.assign(points, Vec3::Zero());
  first_link_ = next;
  const auto ease = [&](std::uint32_t p) {
    if (node_[p] != kHeld) return easy[p] != 0 ? easy[p] : easy[mechanism_.leader(p)];
    if (carried_[p] == kHeld) return 0.0;
    const auto& at = held[carried_[p]];
    const auto& body = mechanism_.bodies()[at.body];
    return body.inverse_mass + at.local.squaredNorm() * body.inverse_inertia.norm() / 2;
  };
  links_.clear();
  const auto add = [&](Link link) {
    const double sum = ease(link.a) + ease(link.b);
    link.inertia = sum > 0 ? 1 / sum : 1;
    links_.push_back(link);
  };
  const auto& rows = mechanism_.rows();
  for (std::uint32_t r = 0; r < rows.size(); ++r) {
    add({.a = rows[r].a, .b = rows[r].b, .pulls = rows[r].pulls, .row = r});
  }
  const auto& stretches = mechanism_.material().stretches();
  for (std::uint32_t k = 0; k < stretches.size(); ++k) {
    add({.a = stretches[k].a,
         .b = stretches[k].b,
         .soft = true,
         .soft_string = stretches[k].pulls,
         .row = k});
  }
  links_at_pulleys_.clear();
  for (const Mechanism::Coupling& coupling : mechanism_.couplings()) {
    if (coupling.share != 0)
      links_at_pulleys_.push_back({coupling.row, coupling.pulley, coupling.share});
  }
  for (const Mechanism::SoftCoupling& coupling : mechanism_.soft_couplings()) {
    links_at_pulleys_.push_back(
        {small(rows.size()) + coupling.stretch, coupling.pulley, coupling.share});
  }
  stiffest_ = 0;
  for (const material::BendElement& bend : mechanism_.material().bends()) {
    for (const std::uint32_t p : {bend.a, bend.b, bend.c}) {
      stiffest_ = std::max(stiffest_, bend.stiffness * ease(p));
    }
  }
  first_contact_ = first_link_ + links_.size();
  shape_of_.clear();
  shape_of_.push_back(kHeld);  // no layout is the last one
  base_.assign(mechanism_.state_size(), 0.0);
  state_ = base_;
  turn_.assign(bodies, Vec3::Zero());
  start_turn_.assign(bodies, Quat::Identity());
  loose_.assign(links_.size(), 0.0);
  violation_.assign(links_.size(), 0.0);
  force_.assign(points, Vec3::Zero());
  wanted_.assign(first_link_, 0.0);
}

void ImplicitStep::lay_out(const StepState& from) {
  std::vector<std::uint32_t> shape;
  for (const Contact& contact : contacts_) shape.push_back(contact.candidate);
  on_.assign(links_.size(), 1);
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (links_[k].pulls) on_[k] = from.taut[k];
    if (links_[k].soft_string) on_[k] = from.tension[k] > 0;
  }
  unknowns_ = first_contact_ + 3 * contacts_.size();
  unknown_.resize(unknowns_);
  residual_.resize(unknowns_);
  row_scale_.resize(unknowns_);
  column_scale_.resize(unknowns_);
  meetings_.resize(contacts_.size());
  bounce_.assign(contacts_.size(), 0.0);
  snap_.assign(links_.size(), 0.0);
  by_rate_.resize(links_.size());
  by_rest_.assign(links_.size(), 1.0);
  soft_rate_.resize(links_.size());
  slack_.assign(links_.size(), kTaut);
  law_.assign(contacts_.size(), kFree);
  off_.resize(contacts_.size());
  by_speed_.resize(contacts_.size());
  if (shape == shape_of_) return;
  shape_of_ = shape;
  groups_.resize(unknowns_);
  std::uint32_t group = 0;
  std::size_t u = 0;
  const auto& easy = mechanism_.inverse_mass();
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (easy[p] == 0) continue;
    for (int i = 0; i < 3; ++i) groups_[u++] = group;
    ++group;
  }
  for (std::size_t b = 0; b < body_.size(); ++b, ++group) {
    for (int i = 0; i < 6; ++i) groups_[u++] = group;
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) groups_[u++] = group++;
  // A force is of the group of a particle that it acts on, so that it is eliminated after that.
  const auto group_of = [&](std::uint32_t a, std::uint32_t b) {
    if (node_[b] != kHeld) return groups_[node_[b]];
    return node_[a] != kHeld ? groups_[node_[a]] : group++;
  };
  for (const Link& link : links_) groups_[u++] = group_of(link.a, link.b);
  for (const Contact& contact : contacts_) {
    const Candidate& of = touches_.candidates()[contact.candidate];
    const std::uint32_t own = of.body == kHeld ? group_of(of.a, of.a) : group++;
    for (int i = 0; i < 3; ++i) groups_[u++] = own;
  }
  stage_is_new_ = jump_is_new_ = true;
}

void ImplicitStep::add_handles(std::uint32_t point, double weight, Relative& to) const {
  if (weight == 0) return;
  if (node_[point] != kHeld) {
    to.add({.at = node_[point], .weight = weight});
  } else if (carried_[point] != kHeld) {
    const auto& at = mechanism_.body_points()[carried_[point]];
    to.add({.at = body_[at.body], .body = true, .weight = weight, .arm = at.arm});
  }
}

ImplicitStep::Relative ImplicitStep::relative(std::uint32_t a, std::uint32_t b) const {
  Relative made;
  add_handles(b, 1, made);
  add_handles(a, -1, made);
  return made;
}

ImplicitStep::Relative ImplicitStep::relative(const Candidate& of, const Meeting& at) const {
  Relative made;
  if (of.body != kHeld) {
    made.add({.at = body_[of.body], .body = true, .weight = 1, .arm = at.arm});
  } else if (of.is_bead()) {
    add_handles(of.a, 1, made);
  } else {
    // Also with a share of none, so that the matrix keeps its places.
    const double share = std::clamp(at.share, 1e-300, 1 - 1e-16);
    add_handles(of.a, 1 - share, made);
    add_handles(of.b, share, made);
  }
  if (of.other != kHeld) {
    made.add({.at = body_[of.other], .body = true, .weight = -1, .arm = at.other_arm});
  }
  if (of.is_at_rope() && of.c == of.d) {
    add_handles(of.c, -1, made);
  } else if (of.is_at_rope()) {
    const double share = std::clamp(at.other_share, 1e-300, 1 - 1e-16);
    add_handles(of.c, share - 1, made);
    add_handles(of.d, -share, made);
  }
  return made;
}

/// The points of a candidate that are nearest between two ends, of which each has an entry, also
/// where it is at an end just now.
int ImplicitStep::slides(const Candidate& of, const Meeting& at, std::array<Slide, 2>& made) const {
  const auto apart = [&](std::uint32_t a, std::uint32_t b, auto place) {
    return Vec3(vec(&state_[(mechanism_.*place)(b)]) - vec(&state_[(mechanism_.*place)(a)]));
  };
  const auto of_link = [&](std::uint32_t a, std::uint32_t b, double share, Slide& slide) {
    slide.ends = relative(a, b);
    slide.along = apart(a, b, &Mechanism::position);
    slide.passes = apart(a, b, &Mechanism::velocity);
    slide.moves = !of.is_at_rope() || (share > 0 && share < 1);
  };
  int count = 0;
  if (of.body != kHeld && of.spot == contact::Spot::nearest) {
    Slide& slide = made[0] = {};
    slide.along = touches_.axis(mechanism_, of, state_.data());
    slide.passes = vec(&state_[mechanism_.twist(of.body) + 3]).cross(slide.along);
    slide.ends.add({.at = body_[of.body], .body = true, .weight = 1, .arm = slide.along});
    slide.ends.add({.at = body_[of.body], .body = true, .weight = -1});
    slide.moves = true;
    ++count;
  } else if (of.spot == contact::Spot::nearest && !of.is_bead()) {
    of_link(of.a, of.b, at.share, made[static_cast<std::size_t>(count++)] = {});
  }
  if (of.c != of.d) {  // against the first
    of_link(of.d, of.c, at.other_share, made[static_cast<std::size_t>(count++)] = {});
  }
  return count;
}

/// Adds what follows from a normal that turns as places change. The nearest point of a link moves
/// along it by a share s, so that the way e along the link stays across the normal n, e n = 0. With
/// the curvature H of the distance by the place x:
///   n' = H (x' + e s'),   s' = -(e H x' + n e') / (e H e),
/// and the same in two shares where two links touch between their ends.
void ImplicitStep::turn_normal(const Problem& problem, std::size_t c, const Mat3& by_n,
                               const Vec3& force, Mat3& by_v) {
  const Candidate& of = touches_.candidates()[contacts_[c].candidate];
  const Meeting& at = meetings_[c];
  const std::size_t first = first_contact_ + 3 * c;
  const Relative gap = relative(of, at);
  const Mat3 bends = touches_.curvature(contacts_[c].candidate, at);
  std::array<Slide, 2> slide;
  const auto count = static_cast<std::size_t>(slides(of, at, slide));
  std::array<Vec3, 2> rolls;
  Eigen::Matrix2d bent = Eigen::Matrix2d::Zero(), share = bent;
  for (std::size_t k = 0; k < count; ++k) {
    rolls[k] = bends * slide[k].along;
    for (std::size_t l = 0; l <= k; ++l) {
      bent(int(k), int(l)) = bent(int(l), int(k)) = slide[l].along.dot(rolls[k]);
    }
    // Along what is flat there, or between parallel links, the point stays.
    const double least = kFlat * slide[k].along.squaredNorm() * bends.norm();
    slide[k].moves = slide[k].moves && bent(int(k), int(k)) > least;
  }
  if (count == 2 && slide[0].moves && slide[1].moves) {
    const double both = bent(0, 0) * bent(1, 1);
    if (bent.determinant() > kFlat * both) {
      share = bent.inverse();
    } else {
      slide[1].moves = false;
    }
  }
  if (share.isZero(0)) {
    for (std::size_t k = 0; k < count; ++k) {
      if (slide[k].moves) share(int(k), int(k)) = 1 / bent(int(k), int(k));
    }
  }
  const double h = problem.advance;
  Mat3 turns = bends, less = Mat3::Zero();
  for (std::size_t k = 0; k < count; ++k) {
    Vec3 by_share = Vec3::Zero(), moved = Vec3::Zero();
    for (std::size_t l = 0; l < count; ++l) {
      const double by = share(int(k), int(l));
      by_share += by * (by_n * rolls[l] + by_v * slide[l].passes);
      moved += by * rolls[l];
    }
    less += by_v * slide[k].passes * moved.transpose();
    turns -= rolls[k] * moved.transpose();
    for (std::size_t i = 0; i < 3; ++i) {
      row(first + i, slide[k].ends, -h * by_share[static_cast<int>(i)] * at.normal);
    }
    block(slide[k].ends, gap, h * force * moved.transpose());
    for (std::size_t l = 0; l < count; ++l) {
      block(slide[k].ends, slide[l].ends,
            h * share(int(k), int(l)) * force * at.normal.transpose());
    }
  }
  by_v += h * (by_n * turns - less);
}

/// A force on a relative place, out of the residual.
void ImplicitStep::push(const Relative& at, const Vec3& force) {
  for (const Handle& handle : at.all()) {
    const Vec3 own = handle.weight * force;
    vec(&residual_[handle.at]) -= own;
    if (handle.body) vec(&residual_[handle.at + 3]) -= handle.arm.cross(own);
  }
}

/// The derivative of minus a force on `row` by the velocity of `column`.
void ImplicitStep::block(const Relative& row, const Relative& column, const Mat3& value) {
  if (!assembles_) return;
  for (const Handle& r : row.all()) {
    for (const Handle& c : column.all()) {
      const Mat3 own = r.weight * c.weight * value;
      // Velocities are not scaled, and rows of three alike.
      const auto put = [&](std::size_t i, std::size_t j, const Mat3& m) {
        system_->add(i, j, m * row_scale_[i]);
      };
      put(r.at, c.at, own);
      if (c.body) put(r.at, c.at + 3, -own * cross_matrix(c.arm));
      if (!r.body) continue;
      const Mat3 turned = cross_matrix(r.arm) * own;
      put(r.at + 3, c.at, turned);
      if (c.body) put(r.at + 3, c.at + 3, -turned * cross_matrix(c.arm));
    }
  }
}

void ImplicitStep::row(std::size_t index, const Relative& column, const Vec3& value) {
  if (!assembles_) return;
  for (const Handle& c : column.all()) {
    const Vec3 own = c.weight * value;
    for (std::size_t x = 0; x < 3; ++x) entry(index, c.at + x, own[static_cast<int>(x)]);
    if (!c.body) continue;
    const Vec3 turned = c.arm.cross(own);
    for (std::size_t x = 0; x < 3; ++x) entry(index, c.at + 3 + x, turned[static_cast<int>(x)]);
  }
}

/// The derivative of minus a force on `row` by an unknown.
void ImplicitStep::column(std::size_t index, const Relative& row, const Vec3& value) {
  if (!assembles_) return;
  for (const Handle& r : row.all()) {
    const Vec3 own = r.weight * value;
    for (std::size_t x = 0; x < 3; ++x) entry(r.at + x, index, own[static_cast<int>(x)]);
    if (!r.body) continue;
    const Vec3 turned = r.arm.cross(own);
    for (std::size_t x = 0; x < 3; ++x) entry(r.at + 3 + x, index, turned[static_cast<int>(x)]);
  }
}

/// The state that the unknowns make.
void ImplicitStep::place_unknowns(const Problem& problem) {
  state_ = base_;
  const auto& easy = mechanism_.inverse_mass();
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (easy[p] == 0) continue;
    const Eigen::Map<const Vec3> v(&unknown_[node_[p]]);
    vec(&state_[mechanism_.position(p)]) += problem.advance * v;
    vec(&state_[mechanism_.velocity(p)]) = v;
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const Eigen::Map<const Vec3> v(&unknown_[body_[b]]), spin(&unknown_[body_[b] + 3]);
    vec(&state_[mechanism_.pose(b)]) += problem.advance * v;
    const Quat turned = rotation_by(turn_[b] + problem.advance * spin) * start_turn_[b];
    set_quaternion(turned.normalized(), &state_[mechanism_.pose(b) + 3]);
    vec(&state_[mechanism_.twist(b)]) = v;
    vec(&state_[mechanism_.twist(b) + 3]) = spin;
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    state_[mechanism_.passed(p)] += problem.advance * unknown_[pulley_[p]];
    state_[mechanism_.speed(p)] = unknown_[pulley_[p]];
  }
  mechanism_.place_and_measure(problem.time, state_.data());
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    meetings_[c] = touches_.meet(mechanism_, contacts_[c].candidate, state_.data());
  }
}

void ImplicitStep::scale(const Problem& problem) {
  const auto& easy = mechanism_.inverse_mass();
  std::ranges::fill(column_scale_, 1.0);
  std::ranges::fill(row_scale_, 1.0);
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (easy[p] == 0) continue;
    for (std::size_t i = 0; i < 3; ++i) row_scale_[node_[p] + i] = easy[p] / problem.inertia;
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    const double turning = std::max(body.inertia.diagonal().maxCoeff(), 1e-300);
    for (std::size_t i = 0; i < 3; ++i) {
      row_scale_[body_[b] + i] = body.inverse_mass / problem.inertia;
      row_scale_[body_[b] + 3 + i] = 1 / (turning * problem.inertia);
    }
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    column_scale_[first_link_ + k] = links_[k].inertia * problem.inertia;
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    pulley_mass_[p] = mechanism_.passing_mass(p, p, false);
    for (const LinkAtPulley& at_pulley : links_at_pulleys_) {
      if (at_pulley.pulley != p) continue;
      pulley_mass_[p] = std::max(pulley_mass_[p], links_[at_pulley.link].inertia);
    }
    row_scale_[pulley_[p]] = 1 / (pulley_mass_[p] * problem.inertia);
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Candidate& of = touches_.candidates()[contacts_[c].candidate];
    double ease = 0;
    const auto of_body = [&](std::uint32_t b, const Vec3& arm) {
      const auto& body = mechanism_.bodies()[b];
      return body.inverse_mass + arm.squaredNorm() * body.inverse_inertia.norm() / 2;
    };
    const auto of_point = [&](std::uint32_t p) {
      if (carried_[p] == kHeld) return easy[p];
      const auto& at = mechanism_.body_points()[carried_[p]];
      return of_body(at.body, at.arm);
    };
    if (of.body != kHeld) {
      ease += of_body(of.body, meetings_[c].arm);
    } else {
      const double share = meetings_[c].share;
      ease += (1 - share) * (1 - share) * of_point(of.a) + share * share * of_point(of.b);
    }
    if (of.other != kHeld) ease += of_body(of.other, meetings_[c].other_arm);
    if (of.is_at_rope()) {
      const double share = meetings_[c].other_share;
      ease += (1 - share) * (1 - share) * of_point(of.c) + share * share * of_point(of.d);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      column_scale_[first_contact_ + 3 * c + i] = problem.inertia / std::max(ease, 1e-300);
    }
  }
}

void ImplicitStep::assemble_inertia(const Problem& problem) {
  const auto& easy = mechanism_.inverse_mass();
  const Vec3 gravity = problem.forces ? mechanism_.gravity() : Vec3(Vec3::Zero());
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (easy[p] == 0) continue;
    const std::size_t at = node_[p];
    const double mass = 1 / easy[p];
    vec(&residual_[at]) +=
        mass * (problem.inertia * (vec(&unknown_[at]) - vec(&wanted_[at])) - gravity);
    for (std::size_t i = 0; i < 3; ++i) entry(at + i, at + i, mass * problem.inertia);
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    const std::size_t at = body_[b];
    const double mass = 1 / body.inverse_mass;
    vec(&residual_[at]) +=
        mass * (problem.inertia * (vec(&unknown_[at]) - vec(&wanted_[at])) - gravity);
    for (std::size_t i = 0; i < 3; ++i) entry(at + i, at + i, mass * problem.inertia);
    const Mat3 turn = quaternion(&state_[mechanism_.pose(b) + 3]).normalized().toRotationMatrix();
    Mat3 inertia = turn * body.inertia * turn.transpose();
    const Eigen::Map<const Vec3> spin(&unknown_[at + 3]);
    const Vec3 rate = problem.inertia * (spin - vec(&wanted_[at + 3]));
    // Without inertia about an axis nothing changes the spin there.
    const double least = 1e-12 * std::max(body.inertia.diagonal().maxCoeff(), 1e-300);
    const Mat3 round = inertia + least * Mat3::Identity();
    Mat3 slope = problem.inertia * round;
    Vec3 moment = round * rate;
    if (problem.forces) {
      const Vec3 momentum = inertia * spin;
      moment += spin.cross(momentum);
      slope += cross_matrix(spin) * inertia - cross_matrix(momentum);
      slope += problem.advance * (inertia * cross_matrix(rate) - cross_matrix(inertia * rate));
    }
    vec(&residual_[at + 3]) += moment;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        entry(at + 3 + i, at + 3 + j, slope(static_cast<int>(i), static_cast<int>(j)));
      }
    }
  }
}

void ImplicitStep::assemble_materials(const Problem& problem) {
  const auto& material = mechanism_.material();
  const double* places = state_.data();
  const double* velocities = &state_[mechanism_.velocity(0)];
  const double h = problem.advance;
  for (const material::BendElement& bend : material.bends()) {
    Vec3 e0, e1, by_e0, by_e1;
    material.edges(bend, places, e0, e1);
    const material::Bend shape(e0, e1, bend.rest);
    shape.slope(bend.stiffness, by_e0, by_e1);
    material::Bend::Stiffness k = shape.stiffness(bend.stiffness);
    k.e0_e0 *= h;
    k.e0_e1 *= h;
    k.e1_e1 *= h;
    if (bend.damping > 0) {
      Vec3 damped0, damped1, rate0, rate1;
      material.edge_rates(bend, velocities, rate0, rate1);
      shape.resistance(bend.damping, rate0, rate1, damped0, damped1);
      by_e0 += damped0;
      by_e1 += damped1;
      const auto d = shape.damping(bend.damping);
      k.e0_e0 += d.e0_e0;
      k.e0_e1 += d.e0_e1;
      k.e1_e1 += d.e1_e1;
    }
    Relative first, second;
    if (!bend.clamped_before()) first = relative(bend.a, bend.b);
    if (!bend.clamped_behind()) second = relative(bend.b, bend.c);
    if (const auto clamp = mechanism_.clamp_on_body(bend)) {
      // The tip of a vector of the body past its tail.
      Relative& turned = bend.clamped_before() ? first : second;
      const std::uint32_t at = body_[clamp->body];
      turned.add({.at = at, .body = true, .weight = 1, .arm = clamp->direction});
      turned.add({.at = at, .body = true, .weight = -1});
    }
    push(first, -by_e0);
    push(second, -by_e1);
    block(first, first, k.e0_e0);
    block(first, second, k.e0_e1);
    block(second, first, k.e0_e1.transpose());
    block(second, second, k.e1_e1);
  }
  for (const material::DragElement& link : material.drags()) {
    const Vec3 force = 2 * material.drag(link, places, velocities);
    const Vec3 edge = vec(places + 3 * link.b) - vec(places + 3 * link.a);
    Vec3 speed =
        (vec(velocities + 3 * link.a) + vec(velocities + 3 * link.b)) / 2 - material.wind();
    if (link.flow != 0) speed += link.flow * edge.normalized();
    Relative middle;
    add_handles(link.a, 0.5, middle);
    add_handles(link.b, 0.5, middle);
    push(middle, force);
    block(middle, middle,
          material::drag_slope(edge, speed, link.density_area(), link.across, link.along));
  }
  if (material.has_applied()) assemble_applied(problem);
  if (!mechanism_.has_winches()) return;
  std::ranges::fill(force_, Vec3::Zero());
  mechanism_.add_flow(state_.data(), force_);
  for (std::uint32_t p = 0; p < force_.size(); ++p) {
    if (force_[p].isZero(0)) continue;
    Relative at;
    add_handles(p, 1, at);
    push(at, force_[p]);
  }
}

/// An applied force is known by its values alone. Differences give its derivative: all particles
/// move by the same way at once, three ways of places and three of velocities. That is the
/// derivative if the force on a particle depends on its own motion alone; otherwise Newton's
/// iterations take more of them to the same root.
void ImplicitStep::assemble_applied(const Problem& problem) {
  constexpr double kShare = 1e-6;  // of a length and of a speed, for the differences
  const auto& material = mechanism_.material();
  const std::size_t velocities = mechanism_.velocity(0);
  std::vector<Vec3>& force = applied_[0];
  std::vector<Vec3>& changed = applied_[1];
  const auto add_to = [&](std::vector<Vec3>& sum) {
    sum.assign(mechanism_.points(), Vec3::Zero());
    material.add_applied(state_.data(), &state_[velocities], sum);
  };
  add_to(force);
  by_motion_.assign(assembles_ ? mechanism_.points() : 0, Mat3::Zero());
  for (std::size_t i = 0; assembles_ && i < 6; ++i) {
    const std::size_t first = i < 3 ? i : velocities + i - 3;
    const double by = kShare * (i < 3 ? length_ : speed_), weight = i < 3 ? problem.advance : 1;
    const auto move = [&](double way) {
      for (std::size_t p = 0; p < mechanism_.points(); ++p) state_[first + 3 * p] += way;
    };
    kept_ = state_;
    move(by);
    add_to(changed);
    state_ = kept_;
    for (std::size_t p = 0; p < mechanism_.points(); ++p) {
      by_motion_[p].col(static_cast<int>(i % 3)) -= weight / by * (changed[p] - force[p]);
    }
  }
  for (std::uint32_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.leader(p) != p) continue;
    Relative at;
    add_handles(p, 1, at);
    push(at, force[p]);
    if (assembles_ && !by_motion_[p].isZero(0)) block(at, at, by_motion_[p]);
  }
}

void ImplicitStep::assemble_links(const Problem& problem, double kappa) {
  const auto& rows = mechanism_.rows();
  const auto& stretches = mechanism_.material().stretches();
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Link& link = links_[k];
    const std::size_t at = first_link_ + k;
    const Relative gap = relative(link.a, link.b);
    const Eigen::Map<const Vec3> a(&state_[mechanism_.position(link.a)]),
        b(&state_[mechanism_.position(link.b)]);
    const Eigen::Map<const Vec3> va(&state_[mechanism_.velocity(link.a)]),
        vb(&state_[mechanism_.velocity(link.b)]);
    const Vec3 way = b - a, rate_of_way = vb - va;
    const double length = way.norm(), inverse = length > 0 ? 1 / length : 0;
    Vec3 direction = inverse * way;
    const bool joint = !link.soft && rows[link.row].axis != Row::kAlongLink;
    if (joint) direction = Vec3::Unit(rows[link.row].axis);
    double rate = direction.dot(rate_of_way);
    if (!link.soft) rate = mechanism_.rate()[link.row];
    if (link.soft) by_rest_[k] = length / stretches[link.row].rest;
    double tension = unknown_[at], damping = 0;
    double& out = residual_[at];
    const double scaled = column_scale_[at];
    if (problem.law == Problem::Law::projection) {
      const bool held = on_[k] != 0;
      const double yields = link.soft ? yields_ / stretches[link.row].stiffness : 0;  // 1/kg
      out = held ? direction.dot(rate_of_way) + violation_[k] - yields * tension : tension / scaled;
      by_rate_[k] = held ? 1 : 0;
      row(at, gap, by_rate_[k] * direction);
      put(at, at, held ? -kProximal - yields * scaled : 1.0);
      if (!held) tension = 0;
    } else if (link.soft && !problem.forces) {  // no impulse comes from what stretches
      out = tension / scaled;
      by_rate_[k] = 0;
      row(at, gap, Vec3::Zero());
      put(at, at, 1.0);
    } else {
      const Vec3 turning = (rate_of_way - direction.dot(rate_of_way) * direction) * inverse;
      Vec3 slope = direction;
      if (!joint) slope += problem.advance * turning;
      double by_rate = 1, by_tension = -kProximal;
      if (link.soft) {
        const auto& stretch = stretches[link.row];
        const double compliance = problem.inertia / stretch.stiffness;
        // What is paid out has no tension.
        rate -= by_rest_[k] * stretch.rest_rate;
        slope -= problem.advance * stretch.rest_rate / stretch.rest * direction;
        out = rate - compliance * (tension - loose_[k]);
        by_tension -= compliance * scaled;
        damping = stretch.damping;
      } else if (link.pulls) {
        if (on_[k] == 0) {
          out = tension / scaled;
          by_rate = 0;
          by_tension = 1;
        } else {
          const auto law = complementarity(tension / scaled, -rate - snap_[k], kappa);
          out = law.value;
          by_rate = -law.by_w;
          by_tension = law.by_p + (law.by_w > 0 ? kProximal : 0);
        }
      } else {
        out = rate;
      }
      by_rate_[k] = by_rate;
      row(at, gap, by_rate * slope);
      put(at, at, by_tension);
    }
    soft_rate_[k] = rate;
    double pull = tension + damping * rate;
    slack_[k] = kTaut;
    if (link.soft_string && problem.forces) {
      slack_[k] = tension <= 0 ? kSlack : pull <= 0 ? kHeldBack : kTaut;
    }
    if (slack_[k] != kTaut) pull = damping = 0;
    push(gap, -pull * direction);
    column(at, gap, slack_[k] != kTaut ? Vec3(Vec3::Zero()) : direction);
    if (!problem.forces) continue;
    const Mat3 along = direction * direction.transpose();
    Mat3 stiffness = Mat3::Zero();
    if (!joint) stiffness = problem.advance * pull * inverse * (Mat3::Identity() - along);
    if (damping > 0) stiffness += damping * along;
    block(gap, gap, stiffness);
  }
}

void ImplicitStep::assemble_contacts(const Problem& problem, double kappa) {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Candidate& of = touches_.candidates()[contacts_[c].candidate];
    const Meeting& at = meetings_[c];
    const std::size_t first = first_contact_ + 3 * c;
    const Relative gap = relative(of, at);
    const Vec3& n = at.normal;
    const double scaled = column_scale_[first];
    const Vec3 force = vec(&unknown_[first]);
    const Vec3 p = force / scaled;  // m/s
    const Vec3 v = touches_.passing(mechanism_, contacts_[c].candidate, at, state_.data());
    const Mat3 along = n * n.transpose(), across = Mat3::Identity() - along;
    Vec3 out;
    Mat3 by_p, by_v;
    if (problem.law == Problem::Law::projection) {
      const Vec3 moved = moves(gap, unknown_);
      const Mat3 held = law_[c] == kAtAnchor ? Mat3(Mat3::Identity()) : law_[c] * along;
      const Mat3 free = Mat3::Identity() - held;
      out = held * (moved + off_[c]) + free * p;
      by_p = free + kProximal * held;
      by_v = held;
    } else {
      const double pn = n.dot(p), w = n.dot(v) - bounce_[c];
      const auto law = complementarity(pn, w, kappa);
      const Vec3 pt = across * p, u = across * v;
      const Contact& contact = contacts_[c];
      // A contact that slides back within a step slides forwards until it rests, and one at rest
      // that static friction holds stays there: what ends that ends the step (first_arrival()).
      const bool sliding = std::ranges::find(reversing_, contact.candidate) != reversing_.end();
      const bool held =
          problem.forces && contact.sticks && of.stick != of.slide && friction_share_ == 1;
      const double friction = friction_share_ * (contact.sticks ? of.stick : of.slide);
      const bool frozen = problem.forces && sliding && u.dot(contact.slip) <= 0;
      const Vec3 z = (pt - u) / (1 + creep_);
      const double size = z.norm(), bound = held ? 2 * size + 1 : friction * std::max(pn, 0.0);
      out = law.value * n;
      by_p = (law.by_p + (law.by_w > 0 ? kProximal : 0)) * along;
      by_v = law.by_w * along;
      const bool stuck = size < bound && !frozen;
      if (kappa > 0 && !frozen && !held) {
        // The projection onto Coulomb's disc with max(a, b) = (a + b + sqrt((a - b)^2 + 4 kappa))
        // / 2.
        const double root_p = std::sqrt(pn * pn + 4 * kappa), s = std::sqrt(size * size + kappa);
        const double b = friction * (pn + root_p) / 2, by_pn = friction * (1 + pn / root_p) / 2;
        const double root = std::sqrt((b - s) * (b - s) + 4 * kappa), m = (b + s + root) / 2;
        const double m_b = (1 + (b - s) / root) / 2, m_s = (1 - (b - s) / root) / 2;
        const Mat3 by_z = b / m * across - b * m_s / (m * m * s) * z * z.transpose();
        out += pt - b / m * z;
        by_p += across - by_z - by_pn * (1 / m - b * m_b / (m * m)) * z * n.transpose();
        by_v += by_z;
      } else if (stuck) {
        out += (u + creep_ * pt) / (1 + creep_);
        by_v += across / (1 + creep_);
        by_p += (creep_ / (1 + creep_) + kProximal) * across;
      } else if (frozen) {
        const Vec3 way = contact.slip.normalized();
        out += pt + bound * (across * way);
        by_p += across + (pn > 0 ? friction : 0.0) * way * n.transpose();
      } else if (bound > 0) {
        const Vec3 way = z / size;
        out += pt - bound * way;
        const Mat3 turn = bound / (size * (1 + creep_)) * (across - way * way.transpose());
        by_p += across - turn - friction * way * n.transpose();
        by_v += turn;
      } else {
        out += pt;
        by_p += across;
      }
      if (problem.advance > 0 && assembles_) {
        const Mat3 by_n = law.by_w * n * v.transpose() + law.by_p * n * p.transpose() -
                          (stuck ? w : pn) * Mat3::Identity();
        turn_normal(problem, c, by_n, force, by_v);
      }
    }
    by_speed_[c] = by_v;
    for (std::size_t i = 0; i < 3; ++i) {
      residual_[first + i] = out[static_cast<int>(i)];
      row(first + i, gap, by_v.row(static_cast<int>(i)).transpose());
      for (std::size_t j = 0; j < 3; ++j) {
        put(first + i, first + j, by_p(static_cast<int>(i), static_cast<int>(j)));
      }
      column(first + i, gap, -Vec3::Unit(static_cast<int>(i)));
    }
    push(gap, force);
  }
}

/// The change of a relative place, or of a velocity, by changes of the unknown velocities.
Vec3 ImplicitStep::moves(const Relative& of, std::span<const double> by) const {
  Vec3 sum = Vec3::Zero();
  for (const Handle& at : of.all()) {
    sum += at.weight * vec(&by[at.at]);
    if (at.body) sum += at.weight * vec(&by[at.at + 3]).cross(at.arm);
  }
  return sum;
}

/// Whether a candidate is at rope that passes a pulley.
bool ImplicitStep::flows_at(const Candidate& of, std::size_t pulley) const {
  if (of.body != kHeld) return false;
  return mechanism_.is_at_pulley(pulley, of.a) ||
         (of.is_at_rope() && mechanism_.is_at_pulley(pulley, of.c));
}

ImplicitStep::FlowBy ImplicitStep::flow_by(std::size_t pulley, std::size_t c) const {
  const Candidate& of = touches_.candidates()[contacts_[c].candidate];
  const Meeting& at = meetings_[c];
  FlowBy made;
  const auto add = [&](std::uint32_t point, double weight) {
    if (weight == 0) return;
    for (const std::size_t side : {0u, 1u}) {
      const Vec3 flow = weight * mechanism_.flow_by(pulley, side, point, state_.data());
      made.all += flow;
      if (side == 0) made.before += flow;
    }
  };
  add(of.a, of.is_bead() ? 1 : 1 - at.share);
  if (!of.is_bead()) add(of.b, at.share);
  if (of.is_at_rope()) {
    add(of.c, of.c == of.d ? -1 : at.other_share - 1);
    if (of.c != of.d) add(of.d, -at.other_share);
  }
  made.all -= at.normal.dot(made.all) * at.normal;
  made.before -= at.normal.dot(made.before) * at.normal;
  return made;
}

/// What a pulley's inertia takes beyond what drives it (N), and the pull before it, as
/// Mechanism::Pull has it, with half of the force that turns the sheave.
void ImplicitStep::find_balance(const Problem& problem, std::size_t p, double& balance,
                                double& before) {
  balance = before = 0;
  for (std::size_t other = 0; other < pulley_.size(); ++other) {
    const double hastens = change_[pulley_[other]];
    balance += mechanism_.passing_mass(p, other, false) * hastens;
    before += mechanism_.passing_mass(p, other, true) * hastens;
  }
  for (const std::size_t side : {0u, 1u}) {
    mechanism_.each_passing(p, side, [&](std::uint32_t point, const Vec3& force) {
      Relative at;
      add_handles(point, 1, at);
      const double takes = -force.dot(moves(at, change_));
      balance += takes;
      if (side == 0) before += takes;
    });
  }
  for (const LinkAtPulley& at_pulley : links_at_pulleys_) {
    if (at_pulley.pulley != p) continue;
    const Link& link = links_[at_pulley.link];
    if (slack_[at_pulley.link] != kTaut) continue;
    const double tension = unknown_[first_link_ + at_pulley.link];
    double pull = at_pulley.share * tension;
    if (link.soft && problem.forces) {  // and the energy that a unit of length carries away
      const auto& stretch = mechanism_.material().stretches()[link.row];
      pull *= 1 + tension / (2 * stretch.stiffness * stretch.rest);
      pull +=
          at_pulley.share * by_rest_[at_pulley.link] * stretch.damping * soft_rate_[at_pulley.link];
    }
    balance -= pull;
    if (at_pulley.share < 0) before -= pull;
  }
  if (problem.forces) {
    balance -= mechanism_.passing_drive(p, state_.data(), own_acceleration_);
    before += mechanism_.drive_before(p, state_.data(), own_acceleration_);
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (!flows_at(touches_.candidates()[contacts_[c].candidate], p)) continue;
    const FlowBy flow = flow_by(p, c);
    const Eigen::Map<const Vec3> force(&unknown_[first_contact_ + 3 * c]);
    balance -= force.dot(flow.all);
    before -= force.dot(flow.before);
  }
}

/// The law of friction at a pulley. The force that friction has taken is -balance; it is between
/// the bounds at which rope slides, and rope slides at none but these.
ImplicitStep::PulleyLaw ImplicitStep::find_law(const Problem& problem, std::size_t p,
                                               double balance, double before, double& value) const {
  using Slip = Mechanism::Slip;
  value = balance;
  if (!mechanism_.has_friction(p)) return {};
  const double speed = unknown_[pulley_[p]], excess = mechanism_.slide_ratio(p, state_.data()) - 1;
  const double stiff = problem.inertia * pulley_mass_[p];
  if (problem.law == Problem::Law::projection) {  // rope that stays passes nothing
    if (pulley_law_[p].slip != Slip::stick) return {pulley_law_[p].slip, 1, 0};
    value = stiff * speed;
    return {Slip::stick, 0, 0};
  }
  const double behind = before - balance;
  const double forwards = excess * std::max(before, 0.0), back = excess * std::max(behind, 0.0);
  const double asked = stiff * speed - balance;
  if (before <= 0 && behind <= 0) return {};
  Slip now = asked > forwards ? Slip::forwards : asked < -back ? Slip::backwards : Slip::stick;
  // Rope that slides as a step begins slides until it rests, which ends the step.
  const bool slides = problem.forces && std::abs(slid_[p]) > lowest_slip_;
  if (slides) now = slid_[p] > 0 ? Slip::forwards : Slip::backwards;
  // Newton's correction that makes rope slide the other way has passed where it stays.
  const bool turns = (now == Slip::forwards && slip_before_[p] == Slip::backwards) ||
                     (now == Slip::backwards && slip_before_[p] == Slip::forwards);
  if ((turns && !slides) || now == Slip::stick) {
    value = stiff * speed;
    return {Slip::stick, 0, 0};
  }
  if (now == Slip::forwards) {
    value = balance + forwards;
    return {Slip::forwards, 1, before > 0 ? excess : 0};
  }
  value = balance - back;
  return {Slip::backwards, behind > 0 ? 1 + excess : 1, behind > 0 ? -excess : 0};
}

/// Assembles the rows of pulleys, and their columns in the rows of links, points and contacts. Call
/// it last: it adds to rows that the others write.
void ImplicitStep::assemble_pulleys(const Problem& problem) {
  if (pulley_.empty()) return;
  mechanism_.find_passing(state_.data());
  const bool projects = problem.law == Problem::Law::projection;
  change_.resize(first_link_);
  for (std::size_t u = 0; u < first_link_; ++u) {
    change_[u] = problem.inertia * (unknown_[u] - wanted_[u]);
  }
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    Vec3& own = own_acceleration_[p];
    own.setZero();
    if (carried_[p] != kHeld) {
      const auto& at = mechanism_.body_points()[carried_[p]];
      const Vec3 spin = vec(&state_[mechanism_.twist(at.body) + 3]);
      own = spin.cross(spin.cross(at.arm));
    } else if (node_[p] == kHeld) {
      own = mechanism_.point_acceleration()[p];
    }
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    const std::size_t at = pulley_[p];
    double balance = 0, before = 0;
    find_balance(problem, p, balance, before);
    const PulleyLaw law = find_law(problem, p, balance, before, residual_[at]);
    pulley_law_[p] = law;
    const bool stays = law.slip == Mechanism::Slip::stick;
    for (std::size_t other = 0; other < pulley_.size(); ++other) {
      const double mass = law.all * mechanism_.passing_mass(p, other, false) +
                          law.before * mechanism_.passing_mass(p, other, true);
      const double own = stays && p == other ? pulley_mass_[p] : 0;
      entry(at, pulley_[other], problem.inertia * (mass + own));
    }
    for (const std::size_t side : {0u, 1u}) {
      const double part = law.all + (side == 0 ? law.before : 0);
      mechanism_.each_passing(p, side, [&](std::uint32_t point, const Vec3& force) {
        Relative moved;
        add_handles(point, 1, moved);
        push(moved, change_[at] * force);
        row(at, moved, -part * problem.inertia * force);
        column(at, moved, -problem.inertia * force);
      });
    }
    for (const LinkAtPulley& at_pulley : links_at_pulleys_) {
      if (at_pulley.pulley != p) continue;
      const std::size_t link = first_link_ + at_pulley.link;
      const double by = at_pulley.share * by_rest_[at_pulley.link];
      const double shortens = -by * by_rate_[at_pulley.link];
      if (projects) residual_[link] += shortens * unknown_[at];
      const bool slack = slack_[at_pulley.link] != kTaut;
      const double drives = slack ? 0 : -by * (law.all + (at_pulley.share < 0 ? law.before : 0));
      entry(link, at, shortens);
      entry(at, link, drives);
      const Link& of = links_[at_pulley.link];
      if (!of.soft || !problem.forces) continue;
      const double damping = mechanism_.material().stretches()[of.row].damping;
      if (damping == 0 || slack) continue;
      const Relative gap = relative(of.a, of.b);
      const Vec3 along = direction(of);
      column(at, gap, -by * damping * along);
      row(at, gap, drives * damping * along);
      entry(at, at, -drives * by * damping);
    }
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      if (!flows_at(touches_.candidates()[contacts_[c].candidate], p)) continue;
      const FlowBy flow = flow_by(p, c);
      const Vec3 slides = by_speed_[c] * flow.all;
      const Vec3 drives = law.all * flow.all + law.before * flow.before;
      const std::size_t first = first_contact_ + 3 * c;
      for (std::size_t i = 0; i < 3; ++i) {
        entry(first + i, at, projects ? 0 : slides[static_cast<int>(i)]);
        entry(at, first + i, -drives[static_cast<int>(i)]);
      }
    }
  }
}

void ImplicitStep::assemble(const Problem& problem, double kappa) {
  system_ = problem.forces ? &stage_system_ : &jump_system_;
  bool& is_new = problem.forces ? stage_is_new_ : jump_is_new_;
  if (is_new) system_->reshape(groups_);
  assembles_ = assembles_ || is_new;
  is_new = false;
  if (assembles_) system_->clear();
  std::ranges::fill(residual_, 0.0);
  assemble_inertia(problem);
  if (problem.forces) {
    assemble_materials(problem);
    assemble_twists(problem);
  }
  assemble_links(problem, kappa);
  assemble_contacts(problem, kappa);
  assemble_pulleys(problem);
}

/// The solution of the system with the moments of twisted rods (Sherman and Morrison).
void ImplicitStep::solve_with_twists() {
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
  };
  const auto correct = [&](std::size_t count, std::vector<double>& solution) {
    for (std::size_t j = 0; j < count; ++j) {
      const Twisted& rod = twisted_[j];
      const double by = dot(rod.row, solution) / (1 + dot(rod.row, rod.solved));
      for (std::size_t i = 0; i < solution.size(); ++i) solution[i] -= by * rod.solved[i];
    }
  };
  for (std::size_t j = 0; j < twisted_.size(); ++j) {
    twisted_[j].solved = twisted_[j].column;
    stage_system_.solve(twisted_[j].solved);
    correct(j, twisted_[j].solved);
  }
  stage_system_.solve(residual_);
  correct(twisted_.size(), residual_);
}

void ImplicitStep::assemble_twists(const Problem& problem) {
  const auto& material = mechanism_.material();
  const double* places = state_.data();
  const double* velocities = &state_[mechanism_.velocity(0)];
  twisted_.resize(material.twists().size());
  for (std::size_t j = 0; j < twisted_.size(); ++j) {
    const material::TwistElement& rod = material.twists()[j];
    Twisted& made = twisted_[j];
    made.column.assign(unknowns_, 0.0);
    material.twist_slope(rod, places, slope_);
    const double moment = rod.stiffness * material.twist(rod, places) +
                          rod.damping * material.twist_rate(rod, places, velocities);
    const double stiffness = problem.advance * rod.stiffness + rod.damping;
    for (std::uint32_t i = 0; i <= rod.links; ++i) {
      Relative at;
      add_handles(material.point_of(rod, i), 1, at);
      for (const Handle& handle : at.all()) {
        vec(&made.column[handle.at]) += slope_[i];
        if (handle.body) vec(&made.column[handle.at + 3]) += handle.arm.cross(slope_[i]);
      }
      push(at, -moment * slope_[i]);
    }
    made.row = made.column;
    for (std::size_t u = 0; u < unknowns_; ++u) {
      made.column[u] *= row_scale_[u];
      made.row[u] *= stiffness * column_scale_[u];
    }
    for (std::uint32_t k = 0; k + 1 < rod.links; ++k) {
      const std::uint32_t a = material.point_of(rod, k), b = material.point_of(rod, k + 1),
                          c = material.point_of(rod, k + 2);
      const Vec3 e0 = vec(places + 3 * b) - vec(places + 3 * a);
      const Vec3 e1 = vec(places + 3 * c) - vec(places + 3 * b);
      const auto second = material::Carry(e0, e1).second();
      const Relative first = relative(a, b), next = relative(b, c);
      const double h = problem.advance * moment;
      block(first, first, h * second.e0_e0);
      block(first, next, h * second.e0_e1);
      block(next, first, h * second.e0_e1.transpose());
      block(next, next, h * second.e1_e1);
    }
  }
}

/// Whether the new correction of velocities points where the last one did.
bool ImplicitStep::goes_the_same_way() const {
  constexpr double kStraight = 1e-3;
  double along = 0, last = 0, next = 0;
  for (std::size_t u = 0; u < first_link_; ++u) {
    along += way_[u] * residual_[u];
    last += way_[u] * way_[u];
    next += residual_[u] * residual_[u];
  }
  return along > (1 - kStraight) * std::sqrt(last * next);
}

/// Whether the last correction, which tells velocities alone, made a soft string taut or slack.
bool ImplicitStep::has_tautened() const {
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const bool is_taut = unknown_[first_link_ + k] > 0;
    if (links_[k].soft_string && (slack_[k] == kSlack) == is_taut) return true;
  }
  return false;
}

/// Newton's method; a factorised matrix serves as long as corrections fall fast. True once
/// velocities err by less than `enough` (m/s), or by no more than roundings: light particles beside
/// heavy bodies multiply roundings, and corrections of that size fall no further.
bool ImplicitStep::iterate(const Problem& problem, double kappa, int most, double enough) {
  constexpr double kShortest = 1.0 / 64, kFast = 0.03;
  const double longest = problem.advance > 0 ? 0.5 * shortest_ / problem.advance
                                             : std::numeric_limits<double>::infinity();
  // On the central path the sum of squares falls by that factor in so many iterations.
  constexpr int kPeriod = 10;
  constexpr double kLeastFall = 0.7;
  double last = std::numeric_limits<double>::infinity(), part = 0, fastest = 0, before = last;
  bool keeps = reuses_;
  reuses_ = false;
  std::ranges::fill(slip_before_, Mechanism::Slip::free);
  // Where links are nearly at their full length between two places, corrections are a geometric
  // series, whose sum follows from two of them. Links are at their full length but for rounding
  // where the factor is above kLargest; they stay.
  constexpr double kSteady = 0.01, kLargest = 0.95;
  double ratio_before = 0;
  constexpr double kMostRounding = 1e4;  // of `enough`, that a correction by roundings may have
  double last_new = last;                // the last correction by a matrix of its place
  for (int i = 0; i < most;) {
    check_stop();
    place_unknowns(problem);
    if (i == 0) scale(problem);
    assembles_ = !(keeps && kappa <= 0);
    assemble(problem, kappa);
    double sum = 0;
    for (std::size_t u = 0; u < unknowns_; ++u) {
      residual_[u] *= -row_scale_[u];
      sum += residual_[u] * residual_[u];
    }
    if (kappa > 0 && !(sum <= last) && part > kShortest) {  // half the way
      part /= 2;
      for (std::size_t u = 0; u < unknowns_; ++u) unknown_[u] -= part * way_[u];
      continue;
    }
    last = sum;
    ++i;
    if (kappa > 0 && i % kPeriod == 0) {
      if (i > kPeriod && sum > kLeastFall * before) return false;
      before = sum;
    }
    if (assembles_ && !system_->factorise()) return false;
    if (problem.forces) {
      solve_with_twists();
    } else {
      jump_system_.solve(residual_);
    }
    double most_by = 0;
    for (std::size_t u = 0; u < first_link_; ++u) {
      most_by = std::max(most_by, std::abs(residual_[u]));
      if (!std::isfinite(residual_[u])) return false;
    }
    const double ratio = i > 1 && part == 1 ? most_by / fastest : 1;
    const bool steady = kappa < 0 && ratio < kLargest &&
                        std::abs(ratio - ratio_before) < kSteady * ratio && goes_the_same_way();
    if (!assembles_ && i > 1 && most_by > enough && most_by > kFast * fastest && !steady) {
      keeps = false;  // the matrix of another place serves no longer
      continue;
    }
    fastest = most_by;
    ratio_before = ratio;
    if (i == 1 && kappa < 0) first_way_ = most_by;
    part = std::min(longest / fastest, steady ? 1 / (1 - ratio) : 1);
    way_.resize(unknowns_);
    for (std::size_t u = 0; u < unknowns_; ++u) {
      way_[u] = column_scale_[u] * residual_[u];
      unknown_[u] += part * way_[u];
    }
    for (std::size_t p = 0; p < pulley_.size(); ++p) slip_before_[p] = pulley_law_[p].slip;
    if (fastest <= enough && !(problem.forces && has_tautened())) return true;
    if (assembles_) {
      if (kappa <= 0 && fastest <= kMostRounding * enough && fastest >= last_new) return true;
      last_new = fastest;
    }
    keeps = part >= 1;
  }
  return false;
}

/// Whether of each one-sided condition p w = kappa one factor is much larger than the other.
bool ImplicitStep::is_decided(double kappa) const {
  const auto decided = [&](double p, double w) {
    const double larger = std::max(std::abs(p), std::abs(w));
    return larger * larger > 1e4 * kappa;
  };
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (!links_[k].pulls || on_[k] == 0) continue;
    const std::size_t at = first_link_ + k;
    if (!decided(unknown_[at] / column_scale_[at], -mechanism_.rate()[links_[k].row] - snap_[k]))
      return false;
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const std::size_t at = first_contact_ + 3 * c;
    const Vec3& n = meetings_[c].normal;
    const Vec3 v =
        touches_.passing(mechanism_, contacts_[c].candidate, meetings_[c], state_.data());
    if (!decided(n.dot(vec(&unknown_[at])) / column_scale_[at], n.dot(v) - bounce_[c]))
      return false;
  }
  return true;
}

/// Newton's method along the central path p w = kappa, from `kappa` (m2/s2) down to where each
/// condition is decided. What stays undecided to the end is zero on both sides.
bool ImplicitStep::follow_central_path(const Problem& problem, double kappa, int most,
                                       double enough) {
  constexpr double kDown = 1e-3;
  constexpr int kMostAtEnd = 5;
  for (;; kappa *= kDown) {
    if (!iterate(problem, kappa, most, std::max(std::sqrt(kappa), enough))) return false;
    const bool last = kappa <= enough * enough;
    if (!last && !is_decided(kappa)) continue;
    const std::vector<double> central = unknown_;
    if (iterate(problem, -1, kMostAtEnd, enough)) return true;
    unknown_ = central;
    if (last) return true;
  }
}

/// The error (m/s) of a solution by roundings of places, which bends turn into forces.
double ImplicitStep::roundings(const Problem& problem) const {
  if (!problem.forces || stiffest_ == 0) return 0;
  const double place = std::numeric_limits<double>::epsilon() * length_;
  const double acceleration = stiffest_ * place / (shortest_ * shortest_);
  return std::min(acceleration / problem.inertia, place / problem.advance);
}

/// Newton's method from viscous to dry friction: what sticks creeps with u = -creep p. The part of
/// a rope that slides round a post grows by about as much with each solution.
bool ImplicitStep::harden_friction(const Problem& problem, const std::vector<double>& start,
                                   double enough) {
  constexpr double kViscous = 1e4, kHarder = 1e-2, kDry = 1e-14;
  constexpr int kMost = 20;
  unknown_ = start;
  bool found = true;
  for (creep_ = kViscous; found && creep_ > kDry; creep_ *= kHarder) {
    found = iterate(problem, -1, kMost, 1e3 * enough);
  }
  creep_ = 0;
  return found && iterate(problem, -1, kMost, enough);
}

/// Newton's method from the present unknowns. Where it fails, the central path: kappa starts at the
/// square of the first correction, then of a tenth of the fastest speed.
/// Contacts that share a load have more than one solution; the path leads between them. Where the
/// path fails, friction hardens.
bool ImplicitStep::solve(const Problem& problem) {
  constexpr int kMost = 15, kMostWarm = 20, kMostCold = 40;
  constexpr double kRoundings = 64;
  const double enough =
      std::max((problem.forces ? 1e-10 : 1e-12) * speed_, kRoundings * roundings(problem));
  const std::vector<double> start = unknown_;
  bool found = iterate(problem, -1, kMost, enough);
  const bool one_sided = !contacts_.empty() ||
                         std::ranges::any_of(links_, [](const Link& link) { return link.pulls; });
  if (!found && one_sided) {
    unknown_ = start;
    const double cold = 0.1 * speed_, warm = std::min(first_way_, cold);
    found = follow_central_path(problem, warm * warm, kMostWarm, enough);
    if (!found) {
      unknown_ = start;
      found = follow_central_path(problem, cold * cold, kMostCold, enough);
    }
    if (!found) found = harden_friction(problem, start, enough);
  }
  if (!found) return false;
  place_unknowns(problem);
  return true;
}

/// Moves places to the lengths of links and to the surfaces of contacts. Contacts within `touching`
/// (m) stay where they are if that has no solution, as where a chain at its full length holds a
/// bead over a floor.
bool ImplicitStep::project(StepState& to, double touching) {
  const std::vector<double> start = to.state, tension = to.tension;
  if (!project_places(to, 0)) {
    to.state = start;
    to.tension = tension;
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const Meeting at = touches_.meet(mechanism_, contacts_[c].candidate, to.state.data());
      law_[c] = at.gap < -touching ? kAtSurface : kFree;
    }
    if (!project_places(to, touching)) return false;
  }
  mechanism_.place_and_measure(to.time, to.state.data());
  return true;
}

/// Displacements, or changes of velocities, start from zero at the places of a state.
void ImplicitStep::start_projection(const StepState& at, const Problem& problem) {
  start_at(at);
  yields_ = 0;
  std::ranges::fill(unknown_, 0.0);
  std::ranges::fill(wanted_, 0.0);
  place_unknowns(problem);
}

double ImplicitStep::length_of(const Link& link, const std::vector<double>& state) const {
  return (vec(&state[mechanism_.position(link.b)]) - vec(&state[mechanism_.position(link.a)]))
      .norm();
}

/// The direction in which a link's ends may not part, at the present places.
Vec3 ImplicitStep::direction(const Link& link) const {
  if (!link.soft && mechanism_.rows()[link.row].axis != Row::kAlongLink) {
    return Vec3::Unit(mechanism_.rows()[link.row].axis);
  }
  return (vec(&state_[mechanism_.position(link.b)]) - vec(&state_[mechanism_.position(link.a)]))
      .normalized();
}

/// The part of held ends in the rate of a link (m/s). They have velocities of their own, which are
/// no unknowns.
double ImplicitStep::held_rate(const Link& link) const {
  const auto own = [&](std::uint32_t p) {
    const bool held = node_[p] == kHeld && carried_[p] == kHeld;
    return held ? Vec3(vec(&state_[mechanism_.velocity(p)])) : Vec3(Vec3::Zero());
  };
  const Vec3 apart = own(link.b) - own(link.a);
  return apart.isZero(0) ? 0 : direction(link).dot(apart);
}

/// Also holds contacts at their surfaces that would be deeper inside than `allowed` (m). Tensions
/// of links that stretch change as they would within a stage: between what grips, a chain of such
/// links that is too long by a rounding would else buckle.
bool ImplicitStep::project_places(StepState& to, double allowed) {
  Problem problem{.law = Problem::Law::projection, .time = to.time};
  const auto& stretches = mechanism_.material().stretches();
  bool placed = false;
  for (int i = 0; i < 8 && !placed; ++i) {
    start_projection(to, problem);
    yields_ = settled_ ? 0 : stage_inertia_ * stage_inertia_;
    double worst = 0;
    bool same = true;  // conditions, as before
    for (std::size_t k = 0; k < links_.size(); ++k) {
      const Link& link = links_[k];
      if (!link.soft) {
        violation_[k] = mechanism_.violation()[link.row];
        if (link.pulls && on_[k] != 0 && violation_[k] < 0 && to.tension[k] <= 0) {
          on_[k] = 0;
          same = false;
        } else if (link.pulls && on_[k] == 0 && violation_[k] > exact_) {
          on_[k] = 1;
          same = false;
        }
      } else {
        const auto& stretch = stretches[link.row];
        violation_[k] = length_of(link, state_) - stretch.rest - to.tension[k] / stretch.stiffness;
      }
      if (on_[k] != 0) worst = std::max(worst, std::abs(violation_[k]));
      violation_[k] -= held_rate(link);
    }
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      const Meeting& at = meetings_[c];
      if (law_[c] == kFree && at.gap < -allowed) {
        law_[c] = kAtSurface;
        same = false;
      }
      off_[c] = at.gap * at.normal;
      if (law_[c] == kAtAnchor) {
        const Vec3 off = at.turn * (at.local - contacts_[c].anchor);
        off_[c] += off - at.normal.dot(off) * at.normal;
      }
      if (law_[c] != kFree) worst = std::max(worst, off_[c].norm());
    }
    placed = worst <= exact_;
    if (placed) break;
    reuses_ = i > 0 && same;
    if (!iterate(problem, -1, 1, 1e300)) return false;
    for (std::size_t p = 0; p < mechanism_.points(); ++p) {
      if (mechanism_.inverse_mass()[p] == 0) continue;
      vec(&to.state[mechanism_.position(p)]) += vec(&unknown_[node_[p]]);
    }
    for (std::size_t b = 0; b < body_.size(); ++b) {
      vec(&to.state[mechanism_.pose(b)]) += vec(&unknown_[body_[b]]);
      rotate(vec(&unknown_[body_[b] + 3]), &to.state[mechanism_.pose(b) + 3]);
    }
    for (std::size_t p = 0; p < pulley_.size(); ++p) {
      to.state[mechanism_.passed(p)] += unknown_[pulley_[p]];
    }
    for (std::size_t k = 0; k < links_.size(); ++k) {
      if (!links_[k].soft || on_[k] == 0) continue;
      to.tension[k] += yields_ * unknown_[first_link_ + k];
    }
    placed = worst < 1e-7 * shortest_ && worst * worst / shortest_ < exact_ && i > 0;
  }
  return placed;
}

/// Projects velocities onto links and surfaces that are pressed, after places: the stages were
/// solved at other places, and extrapolation knows no conditions.
bool ImplicitStep::project_velocities(StepState& to) {
  mechanism_.place_and_measure(to.time, to.state.data());
  double worst = 0;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Link& link = links_[k];
    violation_[k] = 0;
    if (link.soft || on_[k] == 0) continue;
    const bool may_slacken = link.pulls && (jumped_ || to.tension[k] <= 0);
    if (may_slacken && mechanism_.rate()[link.row] <= 0) {
      on_[k] = 0;
      continue;
    }
    violation_[k] = mechanism_.rate()[link.row];
    worst = std::max(worst, std::abs(violation_[k]));
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    const Meeting at = touches_.meet(mechanism_, contact.candidate, to.state.data());
    const Vec3 v = touches_.passing(mechanism_, contact.candidate, at, to.state.data());
    const double speed = at.normal.dot(v);
    off_[c] = speed * at.normal;
    if (!contact.presses || (jumped_ && speed >= 0)) {
      law_[c] = kFree;
      continue;
    }
    const bool grips = contact.is_anchored && contact.grips && !jumped_;
    law_[c] = grips ? kAtAnchor : kAtSurface;
    if (grips) off_[c] = v;
    worst = std::max(worst, off_[c].norm());
  }
  if (worst <= 1e-13 * speed_) return true;
  Problem problem{.law = Problem::Law::projection, .time = to.time};
  start_projection(to, problem);
  for (std::size_t k = 0; k < links_.size(); ++k) violation_[k] -= held_rate(links_[k]);
  reuses_ = false;
  if (!iterate(problem, -1, 1, 1e300)) return false;
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    vec(&to.state[mechanism_.velocity(p)]) += vec(&unknown_[node_[p]]);
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    vec(&to.state[mechanism_.twist(b)]) += vec(&unknown_[body_[b]]);
    vec(&to.state[mechanism_.twist(b) + 3]) += vec(&unknown_[body_[b] + 3]);
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    to.state[mechanism_.speed(p)] += unknown_[pulley_[p]];
  }
  mechanism_.place_and_measure(to.time, to.state.data());
  return true;
}

/// Stages and jumps start from the places of a state.
void ImplicitStep::start_at(const StepState& from) {
  base_ = from.state;
  for (std::size_t b = 0; b < body_.size(); ++b) {
    start_turn_[b] = quaternion(&base_[mechanism_.pose(b) + 3]);
    turn_[b].setZero();
  }
}

/// J, half of the product of two motions with all masses, at the places of a jump: of one alone its
/// kinetic energy.
double ImplicitStep::energy_of(const std::vector<double>& one,
                               const std::vector<double>& other) const {
  double twice = 0;
  const auto& easy = mechanism_.inverse_mass();
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (easy[p] != 0) twice += vec(&one[node_[p]]).dot(vec(&other[node_[p]])) / easy[p];
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    const Quat back = start_turn_[b].normalized().conjugate();
    const Vec3 spin = back * vec(&one[body_[b] + 3]), others = back * vec(&other[body_[b] + 3]);
    twice += vec(&one[body_[b]]).dot(vec(&other[body_[b]])) / body.inverse_mass +
             spin.dot(body.inertia * others);
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    const double by = one[pulley_[p]], others = other[pulley_[p]];
    for (std::size_t q = 0; q < pulley_.size(); ++q) {
      twice += by * mechanism_.passing_mass(p, q, false) * other[pulley_[q]];
    }
    for (const std::size_t side : {0u, 1u}) {
      mechanism_.each_passing(p, side, [&](std::uint32_t point, const Vec3& force) {
        Relative at;
        add_handles(point, 1, at);
        twice -= force.dot(by * moves(at, other) + others * moves(at, one));
      });
    }
  }
  return twice / 2;
}

/// Gives kinetic friction to the contacts that static friction does not hold through an impact;
/// whether there are any.
bool ImplicitStep::let_impacts_slide() {
  constexpr double kAtBound = 1e-6;  // of Coulomb's bound, to which solutions have rounding
  bool any = false;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    Contact& contact = contacts_[c];
    const Candidate& of = touches_.candidates()[contact.candidate];
    if (!contact.sticks || of.stick == of.slide) continue;
    const Vec3 impulse = vec(&unknown_[first_contact_ + 3 * c]), &normal = meetings_[c].normal;
    const double push = impulse.dot(normal);
    if (!(push > 0) || (impulse - push * normal).norm() < (1 - kAtBound) * of.stick * push)
      continue;
    contact.sticks = false;
    any = true;
  }
  return any;
}

/// Velocities after the impacts of a moment. Where Newton's restitution would gain energy, as it
/// may where an impact is felt by others through links and friction, the impact goes with the share
/// of what is thrown back that makes none.
bool ImplicitStep::jump(StepState& to, std::span<const double> before) {
  const Problem problem{.time = to.time};
  start_at(to);
  gather(before, wanted_);
  const auto solve_impact = [&] {
    for (;;) {
      std::ranges::copy(wanted_, unknown_.begin());
      std::fill(unknown_.begin() + static_cast<std::ptrdiff_t>(first_link_), unknown_.end(), 0.0);
      if (!solve(problem)) return false;
      if (!let_impacts_slide()) return true;
    }
  };
  if (!solve_impact()) return false;
  const auto is_asked = [](double speed) { return speed > 0; };
  if (std::ranges::any_of(bounce_, is_asked) || std::ranges::any_of(snap_, is_asked)) {
    contact::ImpactEnergies energy{.before = energy_of(wanted_, wanted_),
                                   .thrown = energy_of(unknown_, unknown_)};
    if (contact::gains_energy(energy.before, energy.thrown)) {
      const std::vector<double> thrown = unknown_, bounce = bounce_, snap = snap_;
      std::ranges::fill(bounce_, 0.0);
      std::ranges::fill(snap_, 0.0);
      if (!solve_impact()) return false;
      energy.stopped = energy_of(unknown_, unknown_);
      energy.mixed = energy_of(unknown_, thrown);
      const double share = contact::share_thrown_back(energy);
      for (std::size_t u = 0; u < unknowns_; ++u) {
        unknown_[u] += share * (thrown[u] - unknown_[u]);
      }
      for (std::size_t c = 0; c < bounce_.size(); ++c) bounce_[c] = share * bounce[c];
      for (std::size_t k = 0; k < snap_.size(); ++k) snap_[k] = share * snap[k];
      place_unknowns(problem);
    }
  }
  to.state = state_;
  return true;
}

/// Adds the impulses of the last jump.
void ImplicitStep::note_impulses(StepState& to) {
  const double least = 1e-9 * speed_;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const std::size_t at = first_contact_ + 3 * c;
    const Vec3 impulse = vec(&unknown_[at]);
    if (!(impulse.norm() > least * column_scale_[at])) continue;
    const std::uint32_t candidate = contacts_[c].candidate;
    to.impulses.push_back({.of = candidate,
                           .contact = true,
                           .place = place_of(candidate, meetings_[c], to.state),
                           .size = impulse.norm()});
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const double impulse = unknown_[first_link_ + k];
    if (!links_[k].pulls || !(impulse > least * column_scale_[first_link_ + k])) continue;
    to.impulses.push_back({.of = small(k), .size = impulse});
  }
}

std::optional<Vec3> ImplicitStep::acceleration(std::size_t point, const StepState& to) const {
  if (mechanism_.inverse_mass()[point] > 0) return vec(&to.rate[node_[point]]);
  if (carried_[point] == kHeld) return std::nullopt;
  const Mechanism::BodyPoint& at = mechanism_.body_points()[carried_[point]];
  const Vec3 spin = vec(&to.state[mechanism_.twist(at.body) + 3]);
  return vec(&to.rate[body_[at.body]]) + vec(&to.rate[body_[at.body] + 3]).cross(at.arm) +
         spin.cross(spin.cross(at.arm));
}

Vec3 ImplicitStep::place_of(std::uint32_t candidate, const Meeting& at,
                            const std::vector<double>& state) const {
  const Candidate& of = touches_.candidates()[candidate];
  if (of.body != kHeld) return vec(&state[mechanism_.pose(of.body)]) + at.arm;
  const Vec3 a = vec(&state[mechanism_.position(of.a)]);
  const Vec3 b = vec(&state[mechanism_.position(of.b)]);
  const double radius = of.is_at_rope() ? touches_.radius(of.a) : of.radius;
  return a + at.share * (b - a) - radius * at.normal;
}

/// The part of pulleys in the right side of distance(): what their speeds do to points, and their
/// own rows, in units of change per second.
void ImplicitStep::add_passing_difference(const StepState& one, const StepState& other) {
  if (pulley_.empty()) return;
  const double inertia = stage_inertia_;
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    const std::size_t passed = mechanism_.passed(p), speed = mechanism_.speed(p);
    moved_[pulley_[p]] = one.state[passed] - other.state[passed];
    change_[pulley_[p]] = one.state[speed] - other.state[speed] + inertia * moved_[pulley_[p]];
  }
  for (std::size_t u = 0; u < pulley_.front(); ++u) change_[u] = inertia * moved_[u];
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    const std::size_t at = mechanism_.velocity(p);
    vec(&change_[node_[p]]) += vec(&one.state[at]) - vec(&other.state[at]);
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    for (std::size_t i = 0; i < 6; ++i) {
      const std::size_t at = mechanism_.twist(b) + i;
      change_[body_[b] + i] += one.state[at] - other.state[at];
    }
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    const std::size_t at = pulley_[p];
    const PulleyLaw& law = pulley_law_[p];
    double sum = 0;
    for (std::size_t q = 0; q < pulley_.size(); ++q) {
      sum += change_[pulley_[q]] * (law.all * mechanism_.passing_mass(p, q, false) +
                                    law.before * mechanism_.passing_mass(p, q, true));
    }
    for (const std::size_t side : {0u, 1u}) {
      const double part = law.all + (side == 0 ? law.before : 0);
      mechanism_.each_passing(p, side, [&](std::uint32_t point, const Vec3& force) {
        Relative held;
        add_handles(point, 1, held);
        sum -= part * force.dot(moves(held, change_));
        for (const Handle& handle : held.all()) {
          const Vec3 by = -handle.weight * inertia * change_[at] * force;
          for (std::size_t i = 0; i < 3; ++i) {
            residual_[handle.at + i] += row_scale_[handle.at + i] * by[static_cast<int>(i)];
          }
          if (!handle.body) continue;
          const Vec3 turned = handle.arm.cross(by);
          for (std::size_t i = 3; i < 6; ++i) {
            residual_[handle.at + i] += row_scale_[handle.at + i] * turned[static_cast<int>(i) - 3];
          }
        }
      });
    }
    const bool stays = law.slip == Mechanism::Slip::stick;
    residual_[at] = stays ? inertia * moved_[at] : inertia * row_scale_[at] * sum;
  }
}

double ImplicitStep::distance(const StepState& one, const StepState& other, double time) {
  moved_.assign(unknowns_, 0.0);
  residual_.assign(unknowns_, 0.0);
  const auto part = [&](std::size_t at) {
    return Vec3(vec(&one.state[at]) - vec(&other.state[at]));
  };
  // The change x of places and v of velocities, d of each before: v = (x - dx) inertia and
  // M v inertia + K x = M dv inertia, with the stage's matrix A = M inertia + K / inertia:
  // A x = M (dv + dx inertia). Tensions and forces at contacts follow x as they follow places.
  const double inertia = stage_inertia_;
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    const std::size_t at = node_[p];
    vec(&moved_[at]) = part(mechanism_.position(p));
    vec(&residual_[at]) = part(mechanism_.velocity(p)) + inertia * vec(&moved_[at]);
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const std::size_t pose = mechanism_.pose(b), twist = mechanism_.twist(b), at = body_[b];
    const auto& body = mechanism_.bodies()[b];
    const Quat to = quaternion(&one.state[pose + 3]);
    vec(&moved_[at]) = part(pose);
    vec(&moved_[at + 3]) = angle(to * quaternion(&other.state[pose + 3]).conjugate());
    vec(&residual_[at]) = part(twist) + inertia * vec(&moved_[at]);
    const Mat3 turn = to.normalized().toRotationMatrix();
    vec(&residual_[at + 3]) = turn * body.inertia * turn.transpose() *
                              (part(twist + 3) + inertia * vec(&moved_[at + 3])) /
                              std::max(body.inertia.diagonal().maxCoeff(), 1e-300);
  }
  add_passing_difference(one, other);
  // What is held moves as the difference does.
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Link& link = links_[k];
    if (link.soft || on_[k] == 0) continue;
    residual_[first_link_ + k] =
        inertia * direction(link).dot(moves(relative(link.a, link.b), moved_));
  }
  for (const LinkAtPulley& at_pulley : links_at_pulleys_) {
    if (links_[at_pulley.link].soft || on_[at_pulley.link] == 0) continue;
    residual_[first_link_ + at_pulley.link] -=
        inertia * at_pulley.share * moved_[pulley_[at_pulley.pulley]];
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Candidate& of = touches_.candidates()[contacts_[c].candidate];
    const Vec3& n = meetings_[c].normal;
    if (!other.contacts[c].presses) continue;
    const Vec3 moved = inertia * moves(relative(of, meetings_[c]), moved_);
    vec(&residual_[first_contact_ + 3 * c]) =
        other.contacts[c].grips ? moved : Vec3(n.dot(moved) * n);
  }
  solve_with_twists();
  sped_.resize(first_link_);
  for (std::size_t u = 0; u < first_link_; ++u) {
    sped_[u] = residual_[u] - inertia * moved_[u];
    moved_[u] = residual_[u] / inertia;
  }
  double sum = 0, count = 0;
  const auto add = [&](std::size_t at, double arm) {
    sum +=
        arm * arm * (vec(&moved_[at]).squaredNorm() + time * time * vec(&sped_[at]).squaredNorm());
  };
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    add(node_[p], 1);
    ++count;
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const auto& body = mechanism_.bodies()[b];
    add(body_[b], 1);
    add(body_[b] + 3, std::sqrt(body.inertia.norm() * body.inverse_mass));
    ++count;
  }
  for (const std::uint32_t u : pulley_) {
    sum += moved_[u] * moved_[u] + time * time * sped_[u] * sped_[u];
    ++count;
  }
  return std::sqrt(sum / std::max(count, 1.0));
}

void ImplicitStep::extrapolate(double share, StepState& one) const {
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    vec(&one.state[mechanism_.position(p)]) += share * vec(&moved_[node_[p]]);
    vec(&one.state[mechanism_.velocity(p)]) += share * vec(&sped_[node_[p]]);
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const std::size_t at = body_[b];
    vec(&one.state[mechanism_.pose(b)]) += share * vec(&moved_[at]);
    rotate(share * vec(&moved_[at + 3]), &one.state[mechanism_.pose(b) + 3]);
    vec(&one.state[mechanism_.twist(b)]) += share * vec(&sped_[at]);
    vec(&one.state[mechanism_.twist(b) + 3]) += share * vec(&sped_[at + 3]);
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    one.state[mechanism_.passed(p)] += share * moved_[pulley_[p]];
    one.state[mechanism_.speed(p)] += share * sped_[pulley_[p]];
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const std::size_t at = first_link_ + k;
    if (links_[k].soft) one.tension[k] += share * column_scale_stage_[at] * residual_[at];
  }
}

void ImplicitStep::gather(std::span<const double> state, std::vector<double>& unknowns) const {
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    std::copy_n(&state[mechanism_.velocity(p)], 3, &unknowns[node_[p]]);
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    std::copy_n(&state[mechanism_.twist(b)], 6, &unknowns[body_[b]]);
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    unknowns[pulley_[p]] = state[mechanism_.speed(p)];
  }
}

/// All candidates whose gap is closed, with what is known of them.
void ImplicitStep::find_contacts(const StepState& at, double touching,
                                 std::vector<Contact>& contacts) {
  contacts.clear();
  for (const std::uint32_t i : touches_.near()) {
    if (std::ranges::binary_search(at.inside, i)) continue;
    const Meeting meeting = touches_.meet(mechanism_, i, at.state.data());
    if (meeting.gap > touching + 2 * kShortestApproach * speed_) continue;
    const double rate =
        meeting.normal.dot(touches_.passing(mechanism_, i, meeting, at.state.data()));
    if (meeting.gap > touching - kShortestApproach * std::min(rate, 0.0)) continue;
    if (!touches_.is_distinct(mechanism_, i, at.state.data())) continue;
    const auto known = std::ranges::find(contacts_, i, &Contact::candidate);
    contacts.push_back(known != contacts_.end() ? *known : Contact{.candidate = i});
  }
}

/// Lists the links that are inside each other and do not touch: those of before until they are
/// apart, and those that came there past links that may not touch, which are not distinct then. In
/// a `fresh` state, also those that lie more than half in each other.
void ImplicitStep::find_inside(double touching, bool fresh, StepState& to) {
  const std::vector<std::uint32_t> before = std::move(to.inside);
  to.inside.clear();
  for (const std::uint32_t i : touches_.near()) {
    const Candidate& of = touches_.candidates()[i];
    if (!of.is_at_rope()) continue;
    const double deep = -touches_.meet(mechanism_, i, to.state.data()).gap;
    if (deep <= 2 * touching) continue;
    if ((fresh && deep > of.radius / 2) || std::ranges::binary_search(before, i) ||
        !touches_.is_distinct(mechanism_, i, to.state.data())) {
      to.inside.push_back(i);
    }
  }
}

bool ImplicitStep::load(const World& world, StepState& to, double touching) {
  world_ = &world;
  mechanism_.load(world, to.state);
  to.time = world.time;
  to.rate.clear();
  to.tension.assign(links_.size(), 0.0);
  to.taut.assign(links_.size(), 1);
  to.slips.assign(pulley_.size(), Mechanism::Slip::free);
  shortest_ = std::numeric_limits<double>::infinity();
  length_ = 0;
  for (const Connector& connector : world.connectors) {
    length_ = std::max(length_, connector.length);
    for (const double rest : connector.rest) {
      if (rest > 0) shortest_ = std::min(shortest_, rest);
    }
  }
  if (!(length_ > 0)) length_ = 1;
  if (!std::isfinite(shortest_)) shortest_ = length_;
  exact_ = 64 * std::numeric_limits<double>::epsilon() * length_;
  mechanism_.place_and_measure(to.time, to.state.data());
  touches_.place(world, to.time);
  touches_.find_near(mechanism_, to.state, kNearLinks * shortest_);
  measure_speed(to);
  const auto& stretches = mechanism_.material().stretches();
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const Link& link = links_[k];
    if (link.soft) {
      const auto& stretch = stretches[link.row];
      to.tension[k] = stretch.stiffness * (length_of(link, to.state) - stretch.rest);
    } else if (link.pulls) {
      to.taut[k] = mechanism_.violation()[link.row] >= -touching;
    }
  }
  contacts_.clear();
  to.inside.clear();
  find_inside(touching, true, to);
  find_contacts(to, touching, to.contacts);
  contacts_ = to.contacts;
  lay_out(to);
  const std::vector<double> before = to.state;
  if (!project(to, touching)) return false;
  lay_out(to);  // strings that hold nothing in a projection may stop what moves
  if (!jump(to, before)) return false;
  keep_contacts(to);
  return true;
}

void ImplicitStep::measure_speed(const StepState& at) {
  double fastest = std::sqrt(mechanism_.gravity().norm() * shortest_);
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    fastest = std::max(fastest, vec(&at.state[mechanism_.velocity(p)]).norm());
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    fastest = std::max(fastest, vec(&at.state[mechanism_.twist(b)]).norm());
  }
  speed_ = std::max(fastest, 1e-6 * length_);
}

/// Whether a contact of the solved problem presses. Either its force is zero or the speed at which
/// it parts, but for rounding.
bool ImplicitStep::presses(std::size_t c) const {
  const Vec3& n = meetings_[c].normal;
  const std::size_t at = first_contact_ + 3 * c;
  const double push = n.dot(vec(&unknown_[at])) / column_scale_[at];
  const Vec3 v = touches_.passing(mechanism_, contacts_[c].candidate, meetings_[c], state_.data());
  return push > 0 && push > n.dot(v) - bounce_[c];
}

/// Holds what presses at surfaces, and beads that grip where they do.
void ImplicitStep::hold_contacts() {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    law_[c] = !contact.presses                       ? kFree
              : contact.is_anchored && contact.grips ? kAtAnchor
                                                     : kAtSurface;
  }
}

/// Notes whether contacts slide, and which friction holds those at rest.
void ImplicitStep::keep_contacts(StepState& to) {
  touches_.place(*world_, to.time);
  to.contacts = contacts_;
  for (Contact& contact : to.contacts) {
    const Meeting at = touches_.meet(mechanism_, contact.candidate, to.state.data());
    const Vec3 v = touches_.passing(mechanism_, contact.candidate, at, to.state.data());
    const Vec3 was = contact.slip;
    contact.slip = v - at.normal.dot(v) * at.normal;
    const Candidate& of = touches_.candidates()[contact.candidate];
    // Without friction a slip has no effect, and its turning round is no event.
    const bool slid = !was.isZero(0);
    const bool rests = of.stick == 0 || contact.slip.norm() <= lowest_slip_;
    if (rests) contact.slip.setZero();
    const double push = std::max(contact.force.dot(at.normal), 0.0);
    const double pull = (contact.force - contact.force.dot(at.normal) * at.normal).norm();
    if (!rests) {
      contact.sticks = false;
    } else if (of.stick == of.slide) {
      contact.sticks = true;
    } else if (contact.sticks) {
      contact.sticks = pull <= (1 - kBarely) * of.stick * push;
    } else {
      contact.sticks = slid || pull <= of.slide * push;
    }
    const bool grips = rests && contact.sticks && contact.presses && contact.grips;
    const bool stays =
        of.is_bead() && of.obstacle != kHeld && mechanism_.flow_past(of.a, state_.data()).isZero(0);
    if (!contact.is_anchored) contact.anchor = at.local;
    contact.is_anchored = grips && stays;
  }
}

void ImplicitStep::store(const StepState& from, World& world) {
  mechanism_.store(from.state, from.time, world);
}

/// Keeps the list of what may touch on the way between two states, and some steps beyond.
void ImplicitStep::find_near(const StepState& from, const StepState& to) {
  if (!touches_.any() || (touches_.are_near_known(mechanism_, from.state) &&
                          touches_.are_near_known(mechanism_, to.state))) {
    return;
  }
  constexpr double kSteps = 8;
  const double moved = touches_.largest_move(mechanism_, from.state, to.state);
  touches_.place(*world_, from.time);
  touches_.find_near(mechanism_, from.state, std::max(kNearLinks * shortest_, 2 * kSteps * moved));
  touches_.place(*world_, to.time);
}

/// Puts everything where it is at a share of the way between two states: cubic for places, linear
/// for rotations.
void ImplicitStep::place_between(const StepState& from, const StepState& to, double h,
                                 double share) {
  const double s = share, left = 1 - s;
  const auto between = [&](std::size_t place, std::size_t rate) {
    const auto a = vec(&from.state[place]), b = vec(&to.state[place]);
    vec(&state_[place]) = left * a + s * b +
                          s * left *
                              (left * (h * vec(&from.state[rate]) - (b - a)) -
                               s * (h * vec(&to.state[rate]) - (b - a)));
    const Vec3 mean = (b - a) / h;
    vec(&state_[rate]) = mean + (left * left - 2 * s * left) * (vec(&from.state[rate]) - mean) +
                         (s * s - 2 * s * left) * (vec(&to.state[rate]) - mean);
  };
  state_ = to.state;
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] != 0) between(mechanism_.position(p), mechanism_.velocity(p));
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    const std::size_t pose = mechanism_.pose(b), twist = mechanism_.twist(b);
    between(pose, twist);
    const Quat start = quaternion(&from.state[pose + 3]);
    const Vec3 turn = angle(quaternion(&to.state[pose + 3]) * start.conjugate());
    set_quaternion((rotation_by(s * turn) * start).normalized(), &state_[pose + 3]);
    vec(&state_[twist + 3]) = turn / h;
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    const std::size_t passed = mechanism_.passed(p), speed = mechanism_.speed(p);
    state_[passed] = left * from.state[passed] + s * to.state[passed];
    state_[speed] = (to.state[passed] - from.state[passed]) / h;
  }
  const double time = from.time + s * h;
  mechanism_.place_and_measure(time, state_.data());
  touches_.place(*world_, time);
}

/// The gap (m) of a candidate at a state whose obstacles are placed, and how fast it grows (m/s).
ImplicitStep::Gap ImplicitStep::gap(std::uint32_t candidate,
                                    const std::vector<double>& state) const {
  const Meeting at = touches_.meet(mechanism_, candidate, state.data());
  return {at.gap, at.normal.dot(touches_.passing(mechanism_, candidate, at, state.data())),
          at.normal};
}

/// The share of a step after which a candidate that is apart at both ends, and approaches at first
/// and leaves at last, is deeper inside than `touching` (m) for the first time; 1 where it passes.
double ImplicitStep::first_dip(const StepState& from, const StepState& to, double h,
                               double touching, std::uint32_t candidate) {
  constexpr int kHalvings = 12;
  double low = 0, high = 1;
  place_between(from, to, h, 0);
  Gap before = gap(candidate);
  if (before.rate >= 0 || before.gap + before.rate * h >= 0) return 1;
  place_between(from, to, h, 1);
  Gap behind = gap(candidate);
  for (int i = 0; i < kHalvings; ++i) {
    // At a convex surface, and on a straight way, the gap is nowhere below both tangents.
    const double all = (high - low) * h;
    const double meet =
        (behind.gap - before.gap - behind.rate * all) / (before.rate - behind.rate);  // s
    if (before.gap + before.rate * meet > 0) return 1;
    const double share = low + std::clamp(meet / all, 1e-6, 1 - 1e-6) * (high - low);
    place_between(from, to, h, share);
    const Gap now = gap(candidate);
    if (now.gap < -touching) {
      const bool touches = touches_.is_distinct(mechanism_, candidate, state_.data());
      return touches ? low + (share - low) * before.gap / (before.gap - now.gap) : 1;
    }
    (now.rate < 0 ? low : high) = share;
    (now.rate < 0 ? before : behind) = now;
  }
  return 1;
}

/// A bound (m/s) of the speed at which any points of two links pass each other within a step.
double ImplicitStep::fastest_pass(const StepState& from, const StepState& to, double h,
                                  const Candidate& of) const {
  double most = 0;
  for (const std::uint32_t a : {of.a, of.b}) {
    for (const std::uint32_t c : {of.c, of.d}) {
      const auto apart = [&](const StepState& at,
                             std::size_t (Mechanism::*part)(std::size_t) const) {
        return Vec3(vec(&at.state[(mechanism_.*part)(a)]) - vec(&at.state[(mechanism_.*part)(c)]));
      };
      const Vec3 first = apart(from, &Mechanism::velocity), last = apart(to, &Mechanism::velocity);
      const Vec3 way = apart(to, &Mechanism::position) - apart(from, &Mechanism::position);
      // The derivative of a cubic, as a Bezier curve, is within its corners.
      const Vec3 corner = 3 / h * way - first - last;
      most = std::max({most, first.norm(), corner.norm(), last.norm()});
    }
  }
  return most;
}

/// The share of a step after which two links that are apart at both ends have begun to pass through
/// each other; 1 where they do not. Then the normal turns round. Parts of the step in which it does
/// not, or in which the way is too short, are left to first_dip().
double ImplicitStep::first_pass(const StepState& from, const StepState& to, double h,
                                double touching, std::uint32_t candidate) {
  constexpr double kShortest = 1.0 / 4096;
  struct Part {
    double start = 0, end = 1;
    Gap first, last;
  };
  const double speed = fastest_pass(from, to, h, touches_.candidates()[candidate]);
  Part all;
  all.last = gap(candidate);
  if (all.last.gap > speed * h) return 1;
  all.first = gap(candidate, from.state);
  const auto is_safe = [&](const Part& part) {
    const double share = part.end - part.start;
    return part.first.gap + part.last.gap > speed * share * h || share < kShortest ||
           part.first.normal.dot(part.last.normal) > kSameSide;
  };
  if (is_safe(all)) return 1;
  double found = 1;
  std::vector<Part> parts{all};
  while (!parts.empty()) {
    const Part part = parts.back();
    parts.pop_back();
    if (is_safe(part)) continue;
    const double middle = (part.start + part.end) / 2;
    place_between(from, to, h, middle);
    const Gap now = gap(candidate);
    if (now.gap < -touching) {
      const double down = std::max(part.first.gap, 0.0);
      found = part.start + (middle - part.start) * down / (down - now.gap);
      break;
    }
    parts.push_back({middle, part.end, now, part.last});
    parts.push_back({part.start, middle, part.first, now});
  }
  place_between(from, to, h, 1);
  return found;
}

/// When the first thing arrives that was apart at the start: s, beyond h where nothing does.
double ImplicitStep::first_arrival(const StepState& from, const StepState& to, double h,
                                   double touching) {
  std::vector<std::uint32_t> reverses, leaving;
  double first = std::numeric_limits<double>::infinity();
  // The gap was `open`, grew at `rate`, and is `deep` inside: a parabola between.
  const auto note = [&](double open, double rate, double deep) {
    if (deep <= touching) return;
    if (open <= 0) {
      first = 0;
      return;
    }
    const double bends = -(deep + open + rate * h) / (h * h);
    const double root = std::sqrt(std::max(rate * rate - 4 * bends * open, 0.0));
    first = std::min(first, std::clamp(2 * open / std::max(root - rate, 1e-300), 0.0, h));
  };
  std::size_t known = 0;
  find_near(from, to);
  for (const std::uint32_t i : touches_.near()) {
    while (known < contacts_.size() && contacts_[known].candidate < i) ++known;
    if (known < contacts_.size() && contacts_[known].candidate == i) continue;
    if (std::ranges::binary_search(from.inside, i)) continue;
    const Gap now = gap(i);
    if (touches_.candidates()[i].is_at_rope()) {
      const double share = first_pass(from, to, h, touching, i);
      if (share < 1) {
        first = std::min(first, h * share);
        continue;
      }
    }
    if (now.gap >= -touching) {
      if (now.rate > 0 && now.gap < now.rate * h) leaving.push_back(i);
      continue;
    }
    if (!touches_.is_distinct(mechanism_, i, to.state.data())) continue;
    touches_.place(*world_, from.time);
    const Meeting was = touches_.meet(mechanism_, i, from.state.data());
    const Vec3 passes = touches_.passing(mechanism_, i, was, from.state.data());
    touches_.place(*world_, to.time);
    note(was.gap, was.normal.dot(passes), -now.gap);
  }
  for (const std::uint32_t i : leaving) {
    const double share = first_dip(from, to, h, touching, i);
    if (share < 1) first = std::min(first, h * share);
  }
  if (!leaving.empty()) place_between(from, to, h, 1);
  for (std::size_t c = 0; h >= kShortestSlide && c < contacts_.size(); ++c) {
    const Contact &was = from.contacts[c], &now = to.contacts[c];
    const Candidate& of = touches_.candidates()[was.candidate];
    const Meeting at = touches_.meet(mechanism_, was.candidate, to.state.data());
    if (!now.presses) continue;
    if (!was.slip.isZero(0)) {  // it comes to rest, or slides back
      const double speed = was.slip.norm();
      const Vec3 v = touches_.passing(mechanism_, was.candidate, at, to.state.data());
      const double ahead = v.dot(was.slip) / speed;
      if (ahead >= -lowest_slip_) continue;
      // Links that lie on each other tremble: a way that is too short to tell ends no step.
      if (of.is_at_rope() && std::max(speed, -ahead) * h < touching) continue;
      first = std::min(first, h * speed / (speed - ahead));
      reverses.push_back(was.candidate);
    } else if (was.sticks && of.stick != of.slide) {  // static friction no longer holds it
      const auto ratio = [&](const Vec3& force) {
        const double push = force.dot(at.normal);
        return (force - push * at.normal).norm() / std::max(of.stick * push, 1e-300);
      };
      const double before = std::min(ratio(was.force), 1.0), after = ratio(now.force);
      if (after > 1 + kBarely) first = std::min(first, h * (1 - before) / (after - before));
    }
  }
  for (std::size_t c = 0; h >= kShortestSlide && c < contacts_.size(); ++c) {
    const std::uint32_t i = contacts_[c].candidate;
    if (!touches_.candidates()[i].is_at_rope()) continue;
    const Vec3 was = touches_.meet(mechanism_, i, from.state.data()).normal;
    const Vec3 now = touches_.meet(mechanism_, i, to.state.data()).normal;
    if (was.dot(now) < kSameSide) first = std::min(first, h / 2);  // it may have passed through
  }
  if (!reverses.empty()) reversing_ = std::move(reverses);
  for (std::size_t p = 0; h >= kShortestSlide && p < pulley_.size(); ++p) {
    if (!mechanism_.has_friction(p) || std::abs(slid_[p]) <= lowest_slip_) continue;
    const double ahead = to.state[mechanism_.speed(p)];
    if (ahead * slid_[p] < 0 && std::abs(ahead) > lowest_slip_)
      first = std::min(first, h * slid_[p] / (slid_[p] - ahead));
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (!links_[k].pulls || on_[k] != 0) continue;
    const auto apart = [&](const StepState& at, std::size_t (Mechanism::*of)(std::size_t) const) {
      return Vec3(vec(&at.state[(mechanism_.*of)(links_[k].b)]) -
                  vec(&at.state[(mechanism_.*of)(links_[k].a)]));
    };
    const double rest = mechanism_.rows()[links_[k].row].rest;
    const Vec3 before = apart(from, &Mechanism::position);
    const double length = before.norm();
    const double rate = before.dot(apart(from, &Mechanism::velocity)) / std::max(length, 1e-300);
    note(rest - length, -rate, apart(to, &Mechanism::position).norm() - rest);
  }
  return first;
}

double ImplicitStep::next_arrival(const StepState& from, std::span<const double> rate,
                                  double touching) {
  double first = std::numeric_limits<double>::infinity();
  const auto note = [&](double open, double speed, double acceleration) {
    const double root = speed * speed - 2 * acceleration * open;
    if (open <= touching || root < 0) return;
    const double falls = std::sqrt(root) - speed;
    if (falls > 0) first = std::min(first, 2 * open / falls);
  };
  state_ = from.state;
  mechanism_.place_and_measure(from.time, state_.data());
  touches_.place(*world_, from.time);
  for (const std::uint32_t i : touches_.near()) {
    const Candidate& of = touches_.candidates()[i];
    const Meeting at = touches_.meet(mechanism_, i, state_.data());
    if (at.gap <= touching || !touches_.is_distinct(mechanism_, i, state_.data())) continue;
    const Vec3 passes = touches_.passing(mechanism_, i, at, state_.data());
    const Vec3 change = rate.empty() ? Vec3(Vec3::Zero()) : moves(relative(of, at), rate);
    note(at.gap, at.normal.dot(passes), at.normal.dot(change));
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    if (!links_[k].pulls || from.taut[k] != 0) continue;
    const auto apart = [&](std::size_t (Mechanism::*of)(std::size_t) const) {
      return Vec3(vec(&state_[(mechanism_.*of)(links_[k].b)]) -
                  vec(&state_[(mechanism_.*of)(links_[k].a)]));
    };
    const Vec3 way = apart(&Mechanism::position), passes = apart(&Mechanism::velocity);
    const double length = way.norm();
    if (length == 0) continue;
    const double speed = way.dot(passes) / length;
    double change = (passes.squaredNorm() - speed * speed) / length;
    if (!rate.empty()) {
      change += way.dot(moves(relative(links_[k].a, links_[k].b), rate)) / length;
    }
    note(mechanism_.rows()[links_[k].row].rest - length, -speed, -change);
  }
  return first;
}

/// Moves the velocities on by `time` (s) at a rate, as a start of Newton's method.
void ImplicitStep::guess(double time, const std::vector<double>& rate) {
  for (std::size_t u = 0; u < rate.size(); ++u) unknown_[u] += time * rate[u];
}

ImplicitStep::Result ImplicitStep::step(const StepState& from, double h, double touching,
                                        bool stops, StepState& to) {
  contacts_ = from.contacts;
  if (h < kShortestSlide) reversing_.clear();
  for (std::size_t p = 0; p < pulley_.size(); ++p) slid_[p] = from.state[mechanism_.speed(p)];
  measure_speed(from);
  lay_out(from);
  const double inner = kGamma * h, outer = (1 - kGamma) * h;
  std::vector<double> start(first_link_);
  gather(from.state, start);
  for (std::size_t b = 0; b < body_.size(); ++b) {
    start_turn_[b] = quaternion(&from.state[mechanism_.pose(b) + 3]);
    turn_[b].setZero();
  }
  base_ = from.state;
  wanted_ = start;
  loose_ = from.tension;
  std::ranges::copy(start, unknown_.begin());
  std::ranges::copy(from.tension, unknown_.begin() + static_cast<std::ptrdiff_t>(first_link_));
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    vec(&unknown_[first_contact_ + 3 * c]) = contacts_[c].force;
  }
  Problem problem{
      .inertia = 1 / inner, .advance = inner, .forces = true, .time = from.time + inner};
  stage_inertia_ = problem.inertia;
  settled_ = false;
  touches_.place(*world_, problem.time);
  guess(inner, from.rate);
  if (!solve(problem)) return Result::failed;
  // The second stage starts from what the first has done.
  const double ratio = outer / inner;
  to.rate.resize(first_link_);
  for (std::size_t u = 0; u < first_link_; ++u) {
    to.rate[u] = (unknown_[u] - start[u]) / inner;
    wanted_[u] = start[u] + outer * to.rate[u];
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {
    loose_[k] = from.tension[k] + ratio * (unknown_[first_link_ + k] - from.tension[k]);
  }
  for (std::size_t p = 0; p < mechanism_.points(); ++p) {
    if (mechanism_.inverse_mass()[p] == 0) continue;
    vec(&base_[mechanism_.position(p)]) += outer * vec(&unknown_[node_[p]]);
  }
  for (std::size_t b = 0; b < body_.size(); ++b) {
    vec(&base_[mechanism_.pose(b)]) += outer * vec(&unknown_[body_[b]]);
    turn_[b] = outer * vec(&unknown_[body_[b] + 3]);
  }
  for (std::size_t p = 0; p < pulley_.size(); ++p) {
    base_[mechanism_.passed(p)] += outer * unknown_[pulley_[p]];
  }
  problem.time = from.time + h;
  touches_.place(*world_, problem.time);
  guess(outer, to.rate);
  reuses_ = true;
  if (!solve(problem)) return Result::failed;
  column_scale_stage_ = column_scale_;
  for (std::size_t u = 0; u < first_link_; ++u) to.rate[u] = (unknown_[u] - wanted_[u]) / inner;
  to.time = from.time + h;
  to.state = state_;
  to.tension.assign(unknown_.begin() + static_cast<std::ptrdiff_t>(first_link_),
                    unknown_.begin() + static_cast<std::ptrdiff_t>(first_contact_));
  to.taut = from.taut;
  for (std::size_t k = 0; k < links_.size(); ++k) {
    const std::size_t at = first_link_ + k;
    if (!links_[k].pulls || on_[k] == 0) continue;
    const double shortens = -mechanism_.rate()[links_[k].row];
    if (to.tension[k] / column_scale_[at] <= shortens) to.tension[k] = 0;  // but for rounding
  }
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    contacts_[c].force = vec(&unknown_[first_contact_ + 3 * c]);
    Contact& contact = contacts_[c];
    const Candidate& of = touches_.candidates()[contact.candidate];
    const double push = contact.force.dot(meetings_[c].normal);
    const double pull = (contact.force - push * meetings_[c].normal).norm();
    contact.presses = presses(c);
    contact.grips = contact.sticks && pull < (1 - kSure) * of.stick * push;
  }
  to.contacts = contacts_;
  to.inside = from.inside;
  to.impulses.clear();
  to.slips.clear();
  for (const PulleyLaw& law : pulley_law_) to.slips.push_back(law.slip);
  if (!stops) return Result::done;
  arrival_ = first_arrival(from, to, h, touching);
  return std::isfinite(arrival_) ? Result::arrives : Result::done;
}

std::uint64_t StepState::pattern() const {
  std::uint64_t hash = 1469598103934665603u;
  const auto take = [&](std::uint64_t value) { hash = (hash ^ value) * 1099511628211u; };
  for (const Contact& contact : contacts) {
    if (!contact.presses) continue;
    take(contact.candidate);
    take(contact.slip.isZero(0) ? 1 : 0);
  }
  for (std::size_t k = 0; k < taut.size(); ++k) {
    if (taut[k] == 0) take(k);
  }
  for (const Mechanism::Slip slip : slips) take(static_cast<std::uint64_t>(slip));
  return hash;
}

bool ImplicitStep::finish(StepState& to, double touching, bool jumps) {
  jumped_ = false;
  contacts_ = to.contacts;
  for (std::size_t p = 0; p < pulley_.size(); ++p) pulley_law_[p].slip = to.slips[p];
  lay_out(to);
  touches_.place(*world_, to.time);
  hold_contacts();
  std::vector<double> before = to.state;
  if (!project(to, touching)) return false;
  if (!jumps) return true;
  // What stops moves others a little, which may arrive by that.
  for (int round = 0; round < kRounds; ++round) {
    bool arrives = false;
    std::vector<double> snap(links_.size(), 0.0);
    for (std::size_t k = 0; k < links_.size(); ++k) {
      if (!links_[k].pulls) continue;
      const Row& row = mechanism_.rows()[links_[k].row];
      const bool now = mechanism_.violation()[links_[k].row] >= -touching;
      const double speed = mechanism_.rate()[links_[k].row];
      if (now && !to.taut[k] && speed > 0) {
        arrives = true;
        const double back = world_->connectors[row.connector].restitution * speed;
        if (back > lowest_bounce_) snap[k] = back;
      }
      to.taut[k] = now;
    }
    std::vector<Contact> contacts;
    find_contacts(to, touching, contacts);
    std::vector<double> bounce;
    for (const Contact& contact : contacts) {
      const bool was =
          std::ranges::find(contacts_, contact.candidate, &Contact::candidate) != contacts_.end();
      const Meeting at = touches_.meet(mechanism_, contact.candidate, to.state.data());
      const double speed =
          at.normal.dot(touches_.passing(mechanism_, contact.candidate, at, to.state.data()));
      const Candidate& of = touches_.candidates()[contact.candidate];
      bounce.push_back(0);
      if (was || speed >= -lowest_slip_) continue;
      arrives = true;
      if (-speed * of.restitution > lowest_bounce_) bounce.back() = -speed * of.restitution;
    }
    contacts_ = std::move(contacts);
    lay_out(to);
    if (!arrives) {
      hold_contacts();
      if (!project(to, touching) || !project_velocities(to)) return false;
      // Projection moves others a little, too, which may come to touch by that.
      find_contacts(to, touching, contacts);
      const auto is_known = [&](const Contact& contact) {
        return std::ranges::binary_search(contacts_, contact.candidate, {}, &Contact::candidate);
      };
      if (std::ranges::all_of(contacts, is_known)) break;
      continue;
    }
    jumped_ = true;
    bounce_ = std::move(bounce);
    snap_ = std::move(snap);
    before = to.state;
    if (!jump(to, before)) return false;
    note_impulses(to);
    to.rate.clear();
    for (std::size_t c = 0; c < contacts_.size(); ++c) {
      contacts_[c].presses = presses(c) && bounce_[c] == 0;
    }
    hold_contacts();
    if (!project(to, touching)) return false;
  }
  for (std::size_t k = 0; k < links_.size(); ++k) {  // the tension of what is slack is its length's
    const Link& link = links_[k];
    if (!link.soft_string || to.tension[k] > 0) continue;
    const auto& stretch = mechanism_.material().stretches()[link.row];
    to.tension[k] = stretch.stiffness * (length_of(link, to.state) - stretch.rest);
  }
  find_inside(touching, false, to);
  keep_contacts(to);
  return true;
}

namespace {

using PlaceAt = Eigen::Map<const Vec3>;

constexpr double kShortestJam = 1e-6;   // s
constexpr double kLeastFriction = 0.2;  // of all of it, with which a jam is tried
constexpr double kFades = 8;            // steps so many times as long say that no jam is left
constexpr double kOrderOfHalves = 2;
/// A step of h seconds may err by kErrorRate h tolerances, within these bounds: errors of short
/// steps come from waves and changes, and die away.
constexpr double kErrorRate = 0.4, kLeastShare = 1e-3, kMostShare = 0.01;
/// The error of a velocity counts as the distance that it covers in so many steps: a wave that
/// steps hardly resolve goes no farther.
constexpr double kWaves = 10;
/// The share of the tolerance by which a step may err in which contacts or strings change.
constexpr double kChangeShare = 0.1;
/// The power of StepOptions::finer by which the error of a step falls, so that the error of the
/// whole falls enough to tell it by the difference.
constexpr double kFinerPower = 5;

}  // namespace

void Implicit::rebuild(const World& world) {
  built_ = true;
  topology_ = world.topology;
  step_.rebuild(world);
  rate_.clear();
  length_ = length_scale(world);
  shortest_ = length_;
  for (const Connector& connector : world.connectors) {
    for (const double rest : connector.rest) {
      if (rest > 0) shortest_ = std::min(shortest_, rest);
    }
  }
  // In a fixed step nothing falls farther.
  const double fall = world.gravity.norm() * options_.step * options_.step;
  const double tolerance =
      options_.step > 0 ? std::min(options_.tolerance, fall) : options_.tolerance;
  touching_ = std::clamp(1e-3 * tolerance, 1e-12 * length_, 1e-5 * length_);
  step_.set_lowest_speeds(std::sqrt(2 * world.gravity.norm() * 0.1 * tolerance),
                          touching_ / velocity_time_of(length_));
}

/// The error (m) that the halves of a step of h may make. Extrapolation leaves of it a part that
/// falls by the power 3/2 of the whole, in units of the length.
double Implicit::allowed_error(double h) const {
  const double share = std::clamp(kErrorRate * options_.finer * h, kLeastShare, kMostShare);
  const double rough = kConstants.turn * shortest_ / kConstants.share;
  const double most = std::min(options_.asked(length_), rough);
  const double gain = std::max(1.0, std::cbrt(length_ / most));
  return share * gain * most / std::pow(options_.finer, kFinerPower) +
         kConstants.roundings * 2.2e-16 * length_;
}

/// The error (m) that a step may make in which contacts or strings change: once, however short.
double Implicit::allowed_change() const {
  return kChangeShare * options_.asked(length_) / std::pow(options_.finer, kFinerPower) +
         kConstants.roundings * 2.2e-16 * length_;
}

/// The distance (m) of two states, RMS over all that moves freely, with velocities times `time`
/// (s).
double Implicit::size(const StepState& one, const StepState& other, double time) const {
  const Mechanism& mechanism = step_.mechanism();
  const auto apart = [&](std::size_t at) {
    return Vec3(PlaceAt(&one.state[at]) - PlaceAt(&other.state[at]));
  };
  double sum = 0, count = 0;
  for (std::size_t p = 0; p < mechanism.points(); ++p) {
    if (mechanism.inverse_mass()[p] == 0) continue;
    sum += apart(mechanism.position(p)).squaredNorm() +
           time * time * apart(mechanism.velocity(p)).squaredNorm();
    ++count;
  }
  for (std::size_t b = 0; b < mechanism.bodies().size(); ++b) {
    const auto& body = mechanism.bodies()[b];
    const double arm = std::sqrt(body.inertia.norm() * body.inverse_mass);
    const std::size_t pose = mechanism.pose(b), twist = mechanism.twist(b);
    double turn = 0;
    for (std::size_t i = 3; i < 7; ++i) {
      turn += std::pow(one.state[pose + i] - other.state[pose + i], 2);
    }
    const double place = apart(pose).norm() + 2 * arm * std::sqrt(turn);
    const double speed = apart(twist).norm() + arm * apart(twist + 3).norm();
    sum += place * place + time * time * speed * speed;
    ++count;
  }
  for (std::size_t p = 0; p < mechanism.pulleys(); ++p) {
    const std::size_t passed = mechanism.passed(p), speed = mechanism.speed(p);
    const double place = one.state[passed] - other.state[passed];
    sum += place * place + time * time * std::pow(one.state[speed] - other.state[speed], 2);
    ++count;
  }
  return std::sqrt(sum / std::max(count, 1.0));
}

void Implicit::advance(World& world, double until, std::vector<Event>& events) {
  const auto tell = [&] {
    const auto later =
        std::ranges::find_if(events_, [&](const Event& event) { return event.time > until; });
    events.insert(events.end(), events_.begin(), later);
    events_.erase(events_.begin(), later);
  };
  if (!has_spans(world)) {
    advance_strings(world, until);
    return tell();
  }
  if (!built_ || spans_topology_ != world.topology) {
    spans_topology_ = world.topology;
    spans_.rebuild(world);
  }
  spans_.read(world);
  advance_strings(spans_.world(), until);
  spans_.write(world);
  const std::size_t told = events.size();
  tell();
  for (std::size_t i = told; i < events.size(); ++i) {
    for (const auto& place : spans_.places()) {
      if (events[i].of_contact || events[i].connector != place.string) continue;
      events[i].connector = place.span.connector;
      events[i].span = place.span.index;
      break;
    }
  }
}

void Implicit::advance_strings(World& world, double until) {
  world_ = &world;
  const bool fresh = !built_ || topology_ != world.topology;
  if (fresh) rebuild(world);
  if (!fresh) {
    Mechanism& mechanism = step_.mechanism();
    mechanism.load(world, loaded_);
  }
  if (fresh || loaded_ != shown_) {
    if (!step_.load(world, now_, touching_)) give_up(world.time);
    events_.clear();
    from_ = now_;
    controller_.start(now_.time);
  }
  jam_ = std::max(jam_, kShortestJam);
  controller_.follow(*this, until, counters_);
  step_.store(at(until), world);
  step_.mechanism().load(world, shown_);
}

/// The state at a time (s) within the last step. Where no step leads there, as far as they do.
const StepState& Implicit::at(double time) {
  if (now_.time == time) return now_;
  if (now_.time - time < kConstants.shortest) {
    within_ = now_;
    within_.time = time;
    return within_;
  }
  double longest = (time - from_.time) / 2;
  within_ = from_;
  while (within_.time < time) {
    check_stop();
    const double left = time - within_.time, h = std::min(left, longest);
    if (h < kConstants.shortest) break;
    if (step_.step(within_, h, touching_, false, end_) == ImplicitStep::Result::failed ||
        !step_.finish(end_, touching_, true)) {
      longest = h / 2;
      continue;
    }
    std::swap(within_, end_);
    if (h == left) within_.time = time;
  }
  within_.time = time;
  return within_;
}

double Implicit::first_step() const {
  return 0.1 * std::sqrt(shortest_ / std::max(world_->gravity.norm(), 1.0));
}

double Implicit::longest_step(double) {
  return std::min(kConstants.longest_driven / options_.finer, arrival_ahead());
}

/// s, until something is expected to arrive: a step that ends there need not be done again. Fixed
/// steps are cut only by what does arrive.
double Implicit::arrival_ahead() {
  constexpr double kBriefly = 0.01;  // of the last step: what is nearer is left to the step
  if (options_.step > 0) return kNever;
  const double ahead = step_.next_arrival(now_, rate_, touching_);
  return ahead > kBriefly * (now_.time - from_.time) ? ahead : kNever;
}

bool Implicit::lands(double, double) const {
  return false;
}

Attempt Implicit::attempt(double time, double h, double) {
  if (h < kConstants.shortest) give_up(time);
  for (;;) {
    Attempt made = try_step(h);
    counters_.solves = step_.factorisations();
    // As long as a jam lasts, steps with less friction become longer from one to the next.
    if (friction_ < 1) made.least = 2 * jam_;
    if (made.solved || made.event < kNever || h > jam_ || runs_through_) return made;
    // Shorter steps have no solution either: this one goes with less friction.
    if (friction_ == 0) {  // friction is not the cause: a shorter step, with all of it
      friction_ = 1;
      step_.set_friction_share(friction_);
      return made;
    }
    friction_ = friction_ > kLeastFriction ? friction_ / 2 : 0;
    step_.set_friction_share(friction_);
    check_stop();
  }
}

/// The two halves, and the whole for what they err by.
Attempt Implicit::try_step(double h) {
  Attempt made;
  runs_through_ = false;
  const auto arrives = [&](double reached) {
    made.event = std::max(reached + step_.arrival(), 0.01 * h);
    return made;
  };
  using Result = ImplicitStep::Result;
  Result result = step_.step(now_, h / 2, touching_, true, middle_);
  if (result == Result::arrives) return arrives(0);
  if (result == Result::failed || !step_.finish(middle_, touching_, true)) return made;
  // What arrives there ends a step.
  if (step_.jumped() && h > 4 * kConstants.shortest) {
    made.event = h / 2;
    return made;
  }
  result = step_.step(middle_, h / 2, touching_, true, end_);
  if (result == Result::arrives) return arrives(h / 2);
  if (result == Result::failed) return made;
  made.limit = 1;
  if (options_.step == 0) {
    const std::uint64_t pattern = end_.pattern();
    if (step_.step(now_, h, touching_, false, whole_) == Result::failed) return made;
    const bool same = pattern == whole_.pattern() && pattern == middle_.pattern();
    const double share = same ? std::exp2(kOrderOfHalves) - 1 : 1;
    const double time = std::min(velocity_time_of(length_), kWaves * h);
    const double raw = size(end_, whole_, time) / share;
    made.error = std::min(raw, step_.distance(end_, whole_, time) / share);
    made.limit = same ? allowed_error(h) : allowed_change();
    order_ = same ? kOrderOfHalves + 1 : 2;
    made.may_grow = same;  // steps without changes have a smaller limit
    made.error =
        std::max(made.error, raw * made.limit / (kConstants.passed_over * options_.tolerance));
    made.solved = !(made.error <= made.limit);
    if (made.solved) return made;
    if (same) step_.extrapolate(1 / (std::exp2(kOrderOfHalves) - 1), end_);
  }
  made.solved = step_.finish(end_, touching_, true);
  if (!made.solved) return made;
  if (const auto rope = step_.mechanism().run_through(end_.time, end_.state.data())) {
    if (h < kConstants.brief) {
      throw Diverged("direct", now_.time, counters_.steps, world_->connectors[*rope].name, 0,
                     kRunThrough);
    }
    made.solved = false;
    runs_through_ = true;
  }
  return made;
}

void Implicit::accept(double time) {
  end_.time = time;
  step_.accept();
  std::swap(from_, now_);
  std::swap(now_, end_);
  note_events();
  if (!now_.rate.empty()) rate_ = now_.rate;
  if (friction_ < 1) {
    friction_ = 1;
    step_.set_friction_share(friction_);
    jam_ *= 2;
  } else if (time - from_.time > kFades * jam_) {
    jam_ = std::max(jam_ / 2, kShortestJam);
  }
  step_.mechanism().follow(time, now_.state);
}

/// The events of the last step, which are told at its end.
void Implicit::note_events() {
  using Contact = StepState::Contact;
  const auto& rows = step_.mechanism().rows();
  const auto of_contact = [&](Event::Kind kind, std::uint32_t candidate, const Vec3& place,
                              double size) {
    const auto [one, other] = step_.touches().sides(candidate);
    events_.push_back({.kind = kind,
                       .time = now_.time,
                       .size = size,
                       .one = one,
                       .other = other,
                       .place = place,
                       .of_contact = true});
  };
  const auto of_link = [&](Event::Kind kind, std::size_t link, double size) {
    const ImplicitStep::Link& of = step_.links()[link];
    const auto& stretches = step_.mechanism().material().stretches();
    events_.push_back({.kind = kind,
                       .time = now_.time,
                       .connector = of.soft ? stretches[of.row].connector : rows[of.row].connector,
                       .span = of.soft ? stretches[of.row].link : rows[of.row].link,
                       .size = size});
  };
  for (std::size_t k = 0; k < now_.taut.size(); ++k) {
    const ImplicitStep::Link& link = step_.links()[k];
    const auto is_taut = [&](const StepState& at) {
      return link.soft_string ? at.tension[k] > 0 : at.taut[k] != 0;
    };
    if (is_taut(from_) == is_taut(now_)) continue;
    of_link(is_taut(now_) ? Event::Kind::taut : Event::Kind::slack, k, 0);
  }
  for (const StepState::Impulse& impulse : now_.impulses) {
    if (impulse.contact) {
      const bool touched =
          std::ranges::binary_search(from_.contacts, impulse.of, {}, &Contact::candidate);
      of_contact(touched ? Event::Kind::impulse : Event::Kind::hit, impulse.of, impulse.place,
                 impulse.size);
    } else {
      of_link(Event::Kind::impulse, impulse.of, impulse.size);
    }
  }
  if (from_.contacts.empty()) return;
  step_.touches().place(*world_, now_.time);
  for (const Contact& was : from_.contacts) {
    if (!was.presses) continue;
    const auto now =
        std::ranges::lower_bound(now_.contacts, was.candidate, {}, &Contact::candidate);
    const bool is_there = now != now_.contacts.end() && now->candidate == was.candidate;
    const auto tell = [&](Event::Kind kind) {
      const Meeting at = step_.touches().meet(step_.mechanism(), was.candidate, now_.state.data());
      of_contact(kind, was.candidate, step_.place_of(was.candidate, at, now_.state), 0);
    };
    if (!is_there || !now->presses) {
      tell(Event::Kind::leave);
    } else if (was.slip.isZero(0) != now->slip.isZero(0)) {
      tell(now->slip.isZero(0) ? Event::Kind::stick : Event::Kind::slide);
    }
  }
}

void Implicit::give_up(double time) {
  throw no_step(*world_, step_.mechanism(), now_.state.data(), time, counters_.steps);
}

}  // namespace taut::direct
