// Strings in a step: which may pull, which do, and when they get to their length.
#include <algorithm>
#include <cmath>

#include "sim/methods/direct/contact/contact_step.h"
#include "sim/methods/direct/contact/entry.h"

namespace taut::direct {
namespace {

using ConstMap = Eigen::Map<const Vec3>;

constexpr double kNearly = 100;  // times touching(): a string so much shorter may pull

}  // namespace

void ContactStep::rebuild_strings() {
  const auto& rows = mechanism_.rows();
  for (auto* array : {&left_, &right_}) array->assign(rows.size(), Vec3::Zero());
  for (auto* array : {&given_, &dropped_}) array->assign(rows.size(), 0);
  for (auto* array : {&taut_, &pulls_}) array->assign(rows.size(), true);
  slack_.assign(rows.size(), false);
  ease_.clear();
  const auto& mobile = mechanism_.inverse_mass();
  for (const Row& row : rows) ease_.push_back(mobile[row.a] + mobile[row.b]);
  for (const auto& end : mechanism_.row_ends()) {
    const auto& carried = mechanism_.body_points()[end.body_point];
    ease_[end.row] += mechanism_.bodies()[carried.body].inverse_mass;
  }
}

/// Tells which strings may pull, if need be `all`: those that are slack by more have to get to
/// their length first.
void ContactStep::find_taut(bool all) {
  if (!mechanism_.has_strings()) return;
  for (std::size_t r = 0; r < taut_.size(); ++r) {
    slack_[r] = mechanism_.rows()[r].pulls && mechanism_.violation()[r] < -kNearly * touching_;
    taut_[r] = all || !slack_[r];
  }
}

/// Finds the strings that are too long where the last glide() ends, and when they have their length
/// on the way. False: none.
bool ContactStep::find_snaps(double h) {
  snaps_.clear();
  if (!mechanism_.has_strings()) return false;
  for (std::size_t r = 0; r < taut_.size(); ++r) {
    if (taut_[r]) continue;
    const Row& row = mechanism_.rows()[r];
    const Vec3 start = position(state_, row.b) - position(state_, row.a);
    const Vec3 way = position(next_, row.b) - position(next_, row.a) - start;
    if (!((start + way).norm() > row.rest)) continue;
    const Vec3 straight = h * (ConstMap(&state_[mechanism_.velocity(row.b)]) -
                               ConstMap(&state_[mechanism_.velocity(row.a)]));
    const auto too_long = [&](double share) {
      return (start + share * straight + share * share * (way - straight)).norm() > row.rest;
    };
    snaps_.push_back({.share = first_inside(0, 1, too_long), .row = r});
  }
  return !snaps_.empty();
}

/// The directions of a string whose ends are `gap` apart at the end. Along the mean of how they are
/// apart before and after, its pull turns nothing, and takes energy where it gets longer.
void ContactStep::mean_direction(std::size_t r, const Vec3& gap) {
  const Row& row = mechanism_.rows()[r];
  const double length = gap.norm();
  to_[r] = length > 0 ? Vec3(gap / length) : Vec3(Vec3::UnitX());
  const Vec3 mean = gap + position(state_, row.b) - position(state_, row.a);
  along_[r] = mean.squaredNorm() > 0 ? Vec3(mean.normalized()) : to_[r];
  if (pulls_[r] && !slack_[r]) turn_ = std::max(turn_, (to_[r] - from_[r]).norm());
}

/// Lets those strings pull whose ends part otherwise at `change_`, of which an impulse makes a
/// `share` of its own, and takes back what others pull. Whether it took any: `dropped_`.
bool ContactStep::sort_strings(double share) {
  if (!mechanism_.has_strings()) return false;
  bool drops = false;
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    if (!mechanism_.rows()[r].pulls) continue;
    const double least = -given_[r];
    pulls_[r] = taut_[r] && share * ease_[r] * (pull_[r] - least) + change_[r] > 0;
    dropped_[r] = pulls_[r] ? 0 : least - pull_[r];
    if (dropped_[r] == 0) continue;
    pull_[r] = least;
    drops = true;
  }
  return drops;
}

/// Before the second stage: strings that have their length may pull. They may take back what they
/// have given, of which what snapped within the step threw their ends back; but an impact at its
/// end is one of its own.
void ContactStep::keep_taut() {
  if (!mechanism_.has_strings()) return;
  measure();
  snaps_now_ = false;
  for (std::size_t r = 0; r < taut_.size(); ++r) {
    if (!mechanism_.rows()[r].pulls) continue;
    taut_[r] = taut_[r] && rest_[r] >= -(slack_[r] ? kNearly : 1) * touching_;
    snaps_now_ = snaps_now_ || (slack_[r] && taut_[r]);
    given_[r] = located_ ? 0 : pull_[r];
  }
  hits_ = hits_ || snaps_now_;
}

/// By how much a row with that error is wrong: strings may be shorter, where they do not pull.
double ContactStep::wrong(std::size_t row, double error) const {
  if (pulls_[row]) return std::abs(error);
  return taut_[row] ? error : 0;
}

/// The directions of the rows that pull; errors of others are none.
void ContactStep::mask() {
  if (!mechanism_.has_strings()) return;
  for (std::size_t r = 0; r < pulls_.size(); ++r) {
    left_[r] = pulls_[r] ? to_[r] : Vec3(Vec3::Zero());
    right_[r] = pulls_[r] ? along_[r] : Vec3(Vec3::Zero());
    if (!pulls_[r]) change_[r] = 0;
  }
}

}  // namespace taut::direct
