// Strings among the rows: which are taut, and which of these pull.
#include <algorithm>
#include <cmath>

#include "sim/contact/contact_motion.h"

namespace taut::contact {
namespace {

constexpr double kSeparating = 1e-10;  // m/s, at which ends part
/// m/s: a bead in a corner of two strings bounces between them, ever slower. Ends that approach
/// more slowly than this and are pulled apart again approach by less than a picometre.
constexpr double kSlow = 1e-6;
constexpr double kSpareTension = 1e-9;  // of the tension by which the ends move as they do

}  // namespace

/// The rows' directions; zero for strings that do not pull, so that systems leave these out.
std::span<const Vec3> ContactMotion::pulling() {
  const std::vector<Vec3>& all = mechanism_.direction();
  if (!mechanism_.has_strings()) return all;
  for (std::size_t r = 0; r < all.size(); ++r) {
    along_[r] = pulls_[r] ? all[r] : Vec3(Vec3::Zero());
  }
  return along_;
}

void ContactMotion::begin(double time, State& state) {
  const State before = state;
  mechanism_.update(time, state.data());
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    pulls_[r] = !mechanism_.rows()[r].pulls || mechanism_.violation()[r] >= -touching_;
  }
  project(time, state);
  if (mechanism_.has_strings()) {  // which stop nothing that comes together
    const auto velocities = static_cast<std::ptrdiff_t>(mechanism_.velocity(0));
    std::copy(before.begin() + velocities, before.end(), state.begin() + velocities);
  }
  resolve(time, state);
}

/// Tells the strings that are as long as they may be and not about to be shorter; whether the
/// length of a rod is about to change, or that of such a string to grow.
bool ContactMotion::find_taut(double time, State& state) {
  if (!mechanism_.has_strings()) return false;
  mechanism_.update(time, state.data());
  bool any = false;
  for (std::size_t r = 0; r < taut_.size(); ++r) {
    const double separating = mechanism_.rate()[r];
    if (!mechanism_.rows()[r].pulls) {
      any = any || std::abs(separating) > kSeparating;
      continue;
    }
    taut_[r] = mechanism_.violation()[r] >= -touching_ && separating >= -kSlow;
    if (!taut_[r]) {
      pulls_[r] = false;
      tension_[r] = 0;
    }
    any = any || (taut_[r] && separating > kSeparating);
  }
  return any;
}

/// Lets those strings pull that would part otherwise, under tensions as they are, and no others.
void ContactMotion::sort_strings() {
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    const Row& row = mechanism_.rows()[r];
    if (!row.pulls) continue;
    const double separating =
        (inverse_mass(row.a) + inverse_mass(row.b)) * tension_[r] + change_[r];
    pulls_[r] = taut_[r] && separating > 0;
    if (!pulls_[r]) tension_[r] = 0;
  }
}

/// Of a point, or of the body that carries it, 1/kg.
double ContactMotion::inverse_mass(std::size_t point) const {
  if (!is_carried_[point]) return mechanism_.inverse_mass()[point];
  const auto carried =
      std::ranges::find(mechanism_.body_points(), point, &Mechanism::BodyPoint::point);
  return mechanism_.bodies()[carried->body].inverse_mass;
}

/// By how much (N) a string may push, as roundings do, before it goes slack.
double ContactMotion::spare(std::size_t row) const {
  const Row& at = mechanism_.rows()[row];
  const std::size_t point = inverse_mass(at.a) > inverse_mass(at.b) ? at.a : at.b;
  if (!(inverse_mass(point) > 0)) return 1;
  return kSpareTension * (free_[point].norm() + pulled_[point].norm()) / inverse_mass(point);
}

}  // namespace taut::contact
