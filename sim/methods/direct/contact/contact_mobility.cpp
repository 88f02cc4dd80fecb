// How beads respond to the pulls of their links.
#include <algorithm>
#include <array>
#include <cmath>

#include "sim/contact/creep.h"
#include "sim/methods/direct/contact/contact_step.h"
#include "sim/motion/hash.h"

namespace taut::direct {
namespace {

constexpr double kRounding = 4e-16;  // of what is summed
constexpr int kTrials = 8;           // for the pull of one row
constexpr int kSweeps = 4;           // of all that touches links
constexpr double kImmobile = 1e-15;  // of the mobility of free beads
constexpr double kRelaxed = 1e-14;   // of the speeds

}  // namespace

/// Adds to velocities what a `share` of the rows' impulses makes of them.
void ContactStep::spread(std::span<const double> impulse, std::span<const Vec3> along, double share,
                         std::span<Vec3> velocity) {
  const auto& rows = mechanism_.rows();
  const auto& mobile = mechanism_.inverse_mass();
  for (std::size_t p = 0; p < noise_.size(); ++p) {
    noise_[p] = kRounding * velocity[p].lpNorm<1>();
  }
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const Vec3 pull = share * impulse[r] * along[r];
    const double noise = kRounding * std::abs(share * impulse[r]);
    velocity[rows[r].a] += mobile[rows[r].a] * pull;
    velocity[rows[r].b] -= mobile[rows[r].b] * pull;
    noise_[rows[r].a] += mobile[rows[r].a] * noise;
    noise_[rows[r].b] += mobile[rows[r].b] * noise;
  }
  for (const BeadTouch& at : touches_) {
    noise_[at.point] +=
        kRounding * (at.touch.pushed.lpNorm<1>() + at.touch.friction_before.lpNorm<1>());
  }
  // Where pulls are so large that roundings could be seen, the step is too long.
  for (double& noise : noise_) noise = std::min(noise, touching_ / h_);
}

/// Lets each bead respond to its touches, and notes how it does.
void ContactStep::respond_all(std::span<Vec3> velocity) {
  const auto& mobile = mechanism_.inverse_mass();
  links_.give(mobile, velocity);
  beads_.give(mobile, velocity);
  std::ranges::copy(velocity, bare_.begin());
  for (std::size_t p = 0; p < mobility_.size(); ++p) mobility_[p] = mobile[p] * Mat3::Identity();
  for (std::size_t i = 0; i < touches_.size();) {
    std::size_t count = 0;
    while (i + count < touches_.size() && touches_[i + count].point == touches_[i].point) ++count;
    respond_at(i, count, velocity);
    i += count;
  }
  // One alone then obeys its law exactly.
  const int once = relaxes_ || links_.is_one() ? 1 : 0;
  const int sweeps = relaxes_all_ ? kSweeps : once;
  for (int i = 0; links_.any() && i < sweeps; ++i) relax_links(velocity);
  relaxes_ = false;
}

/// Lets the bead of the `first` of so many touches respond to these.
void ContactStep::respond_at(std::size_t first, std::size_t count, std::span<Vec3> velocity) {
  const std::size_t point = touches_[first].point;
  std::array<contact::Touch, 3> touches;
  for (std::size_t k = 0; k < count; ++k) touches[k] = touches_[first + k].touch;
  const contact::Response response =
      contact::respond(bare_[point], std::span(touches).first(count), creep_);
  velocity[point] = response.velocity;
  mobility_[point] = mechanism_.inverse_mass()[point] * response.derivative;
  for (std::size_t k = 0; k < count; ++k) touches_[first + k].touch = touches[k];
}

/// Lets what touches links give what it should, one after another.
void ContactStep::relax_links(std::span<Vec3> velocity) {
  links_.relax(mechanism_.inverse_mass(), bare_, velocity, creep_, [&](std::uint32_t point) {
    if (mechanism_.inverse_mass()[point] == 0) return;
    const auto first = std::ranges::lower_bound(touches_, point, {}, &BeadTouch::point);
    const auto last = std::ranges::upper_bound(touches_, point, {}, &BeadTouch::point);
    if (first == last) {
      velocity[point] = bare_[point];
      return;
    }
    respond_at(static_cast<std::size_t>(first - touches_.begin()),
               static_cast<std::size_t>(last - first), velocity);
  });
}

/// Newton's change of the pulls, and of what touches links and bodies, where `change_` has by how
/// much the rows part too fast; of an impulse a `share` makes these velocities.
void ContactStep::solve_with_touches(std::span<const Vec3> along, double share) {
  for (double& change : change_) change = -change;
  mask();
  std::ranges::fill(stiffness_, Mat3::Zero());
  std::ranges::fill(bend_, Mat3::Zero());
  std::ranges::fill(behind_, Vec3::Zero());
  mobilize_carried();
  links_.linearize();
  beads_.linearize();
  const bool strings = mechanism_.has_strings();
  glide_system_.assemble(mechanism_, {.h = 0,
                                      .mobility = mobility_,
                                      .bend = bend_,
                                      .turn = stiffness_,
                                      .along = strings ? right_ : along,
                                      .to = strings ? left_ : to_,
                                      .bodies = bodies_.coupled(),
                                      .touches = links_.linear(),
                                      .beads = beads_.linear()});
  glide_system_.solve(behind_, change_, links_.missing(), beads_.missing());
  for (double& change : change_) change *= 0.5 / share;  // it speaks of mean velocities
}

void ContactStep::advance_touches(double share) {
  links_.advance(share);
  beads_.advance(share);
}

/// How points that bodies carry respond.
void ContactStep::mobilize_carried() {
  for (const auto& carried : mechanism_.body_points()) {
    if (bodies_.any()) {
      mobility_[carried.point] =
          contact::mobility(bodies_.coupled()->own(carried.body), carried.arm, carried.arm);
      continue;
    }
    const auto& body = mechanism_.bodies()[carried.body];
    Mat3 lever;
    lever << 0, -carried.arm.z(), carried.arm.y(), carried.arm.z(), 0, -carried.arm.x(),
        -carried.arm.y(), carried.arm.x(), 0;
    mobility_[carried.point] =
        body.inverse_mass * Mat3::Identity() - lever * body.world_inverse * lever;
  }
}

/// Whether no bead that sticks creeps so far in the step that one could see it. Between surfaces
/// that carry its ends apart, or toward each other, a link may have no other solution.
bool ContactStep::sticks() const {
  if (creep_ > contact::kCreep) return true;
  const double most_stuck = std::max(links_.most_stuck(), beads_.most_stuck());
  if (h_ * creep_ * most_stuck > touching_) return false;
  return std::ranges::all_of(touches_, [&](const BeadTouch& at) {
    return at.touch.state != contact::Touch::State::sticks ||
           h_ * creep_ * at.touch.friction.norm() <= touching_;
  });
}

/// A hash of the states of all touches.
std::uint64_t ContactStep::pattern() const {
  Hash hash;
  for (const BeadTouch& at : touches_) {
    hash.word(std::uint64_t(at.point))
        .word(std::uint64_t(at.obstacle))
        .word(static_cast<std::uint64_t>(at.touch.state));
  }
  if (bodies_.any()) hash.word(bodies_.pattern());
  if (links_.any()) hash.word(links_.pattern());
  if (beads_.any()) hash.word(beads_.pattern());
  if (mechanism_.has_strings()) {
    for (const char pulls : pulls_) hash.word(std::uint64_t(pulls != 0));
  }
  return hash.value();
}

std::span<const ContactStep::BeadTouch> ContactStep::touches_of(std::size_t point) const {
  const auto first = std::ranges::lower_bound(touches_, point, {}, &BeadTouch::point);
  return {first, std::ranges::upper_bound(first, touches_.end(), point, {}, &BeadTouch::point)};
}

/// Nonlinear Gauss-Seidel, once along the rows and once back: each row in turn gets the pull at
/// which its ends, as they respond, part as they should (Jean 1999, section 5). Rows at bodies
/// stay.
void ContactStep::relax(std::span<const Vec3> along, double share, std::span<const Vec3> velocity) {
  const auto& rows = mechanism_.rows();
  before_pull_.assign(pull_.begin(), pull_.end());
  for (std::size_t r = 0; r < rows.size(); ++r) {
    change_[r] = to_[r].dot(velocity[rows[r].b] - velocity[rows[r].a]) - change_[r];  // as wanted
  }
  for (std::size_t r = 0; r < rows.size(); ++r) relax_row(r, along[r], share);
  for (std::size_t r = rows.size(); r-- > 0;) relax_row(r, along[r], share);
  for (std::size_t r = 0; r < rows.size(); ++r) change_[r] = pull_[r] - before_pull_[r];
}

/// Newton's method on the pull of one row, whose ends are to part at `change_`.
void ContactStep::relax_row(std::size_t row, const Vec3& along, double share) {
  const std::size_t a = mechanism_.rows()[row].a, b = mechanism_.rows()[row].b;
  const double mobile_a = share * mechanism_.inverse_mass()[a];
  const double mobile_b = share * mechanism_.inverse_mass()[b];
  if (is_carried_[a] || is_carried_[b] || mobile_a + mobile_b == 0 || !taut_[row]) return;
  const auto response = [&](std::size_t point, const Vec3& velocity) {
    const std::span<const BeadTouch> near = touches_of(point);
    if (near.empty()) return contact::Response{velocity};
    if (near.size() == 1) {
      contact::Touch touch = near[0].touch;
      return contact::respond(velocity, std::span(&touch, 1), creep_);
    }
    std::array<contact::Touch, 3> touches;
    std::size_t count = 0;
    for (const BeadTouch& at : near) touches[count++] = at.touch;
    return contact::respond(velocity, std::span(touches).first(count), creep_);
  };
  const auto mobility = [&](double mobile, const contact::Response& found) {
    const double gives = to_[row].dot(found.derivative * along);
    return std::abs(gives) > kImmobile ? mobile * gives : 0;
  };
  Vec3 velocity_a = bare_[a], velocity_b = bare_[b];
  double more = 0;
  for (int i = 0; i < kTrials; ++i) {
    const contact::Response at_a = response(a, velocity_a), at_b = response(b, velocity_b);
    const double apart = to_[row].dot(at_b.velocity - at_a.velocity) - change_[row];
    if (std::abs(apart) <= kRelaxed * (1 + at_a.velocity.norm())) break;
    const double slope = mobility(mobile_a, at_a) + mobility(mobile_b, at_b);
    if (!(slope > 0)) break;  // no pull moves either end
    const double last = more;
    more += apart / slope;
    if (mechanism_.rows()[row].pulls) more = std::max(more, -given_[row] - pull_[row]);
    if (more == last) break;
    velocity_a = bare_[a] + mobile_a * more * along;
    velocity_b = bare_[b] - mobile_b * more * along;
  }
  pull_[row] += more;
  bare_[a] = velocity_a;
  bare_[b] = velocity_b;
}

}  // namespace taut::direct
