#include "sim/contact/body_system.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/links/dense.h"

namespace taut::contact {
namespace {

constexpr double kSlack = 1e-13;  // of the speeds: a law broken by rounding
constexpr int kSweeps = 400;      // of Gauss-Seidel
constexpr int kNewtons = 8;       // from states that seem to be right
constexpr int kTurns = 20;        // of Newton's method on the way of sliding
constexpr int kWays = 32;         // looked at where that fails
constexpr int kHalvings = 60;
constexpr double kDependent = 1e-11;  // of the largest pivot: touches that say the same

constexpr double kLeastPart = 1e-6;  // of what presses most
constexpr double kFirst = 1e5;       // normals before friction, where both cannot be had
constexpr double kYields = 1e-3;     // of what friction could change: what sticks may part by less
constexpr double kImmobile = 1e-12;  // of the mobility of the free body

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Index row(std::size_t touch) {
  return 3 * static_cast<Eigen::Index>(touch);
}

Mat3 across(const Vec3& normal) {
  return Mat3::Identity() - normal * normal.transpose();
}

double hold_of(const Touch& touch, const Vec3& slip) {
  return touch.slid.dot(slip) > 0 ? touch.slide : touch.stick;
}

void set(BodyTouch& at, Touch::State state, const Vec3& given) {
  at.given = given;
  at.touch.state = state;
  at.touch.push = at.touch.normal.dot(given);
  at.touch.rub = given - at.touch.push * at.touch.normal;
}

}  // namespace

Vec3 velocity_at(const Vec6& twist, const Vec3& arm) {
  return twist.head<3>() + twist.tail<3>().cross(arm);
}

Mat6 mobility(double inverse_mass, const Mat3& inverse_inertia) {
  Mat6 m = Mat6::Zero();
  m.topLeftCorner<3, 3>() = inverse_mass * Mat3::Identity();
  m.bottomRightCorner<3, 3>() = inverse_inertia;
  return m;
}

Mat3 mobility(const Mat6& answer, const Vec3& arm, const Vec3& pulled) {
  const Mat3 at = cross_matrix(arm), by = cross_matrix(pulled);
  return answer.topLeftCorner<3, 3>() + answer.topRightCorner<3, 3>() * by -
         at * answer.bottomLeftCorner<3, 3>() - at * answer.bottomRightCorner<3, 3>() * by;
}

void BodySystem::assemble(const Mat6& mobility, std::span<const BodyTouch> touches, double share) {
  mobility_ = mobility;
  share_ = share;
  ease_ = share * mobility(0, 0);
  lever_.clear();
  for (const BodyTouch& at : touches) {
    Block& lever = lever_.emplace_back();
    lever.leftCols<3>().setIdentity();
    lever.rightCols<3>() = -cross_matrix(at.arm);
  }
  const Eigen::Index size = row(touches.size());
  coupling_.resize(size, size);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    for (std::size_t k = 0; k < touches.size(); ++k) {
      coupling_.block<3, 3>(row(i), row(k)) = share * lever_[i] * mobility * lever_[k].transpose();
    }
  }
}

Mat3 BodySystem::coupling(std::size_t i, std::size_t k) const {
  return coupling_.block<3, 3>(row(i), row(k));
}

Vec3 BodySystem::velocity(std::size_t i, std::span<const Vec3> bare) const {
  Vec3 sum = bare[i];
  for (std::size_t k = 0; k < given_.size(); ++k) sum += coupling(i, k) * given_[k];
  return sum;
}

/// One touch alone, where the others give what they do. False: friction jams it.
bool BodySystem::solve_one(std::size_t i, const Vec3& bare, BodyTouch& at) const {
  const Touch& touch = at.touch;
  const Vec3& n = touch.normal;
  const double short_of = touch.least - n.dot(bare);
  if (!(short_of > kSlack * (1 + bare.norm()))) {
    set(at, Touch::State::open, Vec3::Zero());
    return true;
  }
  const Mat3 eases = coupling(i, i);
  if (touch.stick == 0 && touch.slide == 0) {
    set(at, Touch::State::slides, short_of / n.dot(eases * n) * n);
    return true;
  }
  if (at.ahead.isZero(0)) {
    const Mat3 tangent = across(n);
    const Vec3 slip = tangent * (bare - touch.surface);
    const Mat3 creeps = eases + creep_ * ease_ * tangent;
    const Vec3 given = creeps.partialPivLu().solve(short_of * n - slip);
    const double push = n.dot(given);
    if (push > 0 && (given - push * n).norm() <= hold_of(touch, slip) * push) {
      set(at, Touch::State::sticks, given);
      return true;
    }
  }
  return slide_one(i, bare, at);
}

/// The way of sliding under which friction is against it: a root of one angle.
bool BodySystem::slide_one(std::size_t i, const Vec3& bare, BodyTouch& at) const {
  const Touch& touch = at.touch;
  const Vec3& n = touch.normal;
  const Mat3 eases = coupling(i, i);
  const double short_of = touch.least - n.dot(bare);
  const auto given = [&](const Vec3& way) -> Vec3 {
    const Vec3 force = n - touch.slide * way;
    const double answers = n.dot(eases * force);
    return answers > 0 ? Vec3(short_of / answers * force) : Vec3(Vec3::Zero());
  };
  const auto slip = [&](const Vec3& way) -> Vec3 {
    return across(n) * (bare + eases * given(way) - touch.surface);
  };
  if (!at.ahead.isZero(0)) {
    set(at, Touch::State::slides, given(at.ahead));
    return touch.push > 0;
  }
  Vec3 first = across(n) * (bare - touch.surface);
  if (!(first.norm() > 0)) first = touch.slid - n.dot(touch.slid) * n;
  if (!(first.norm() > 0)) first = n.unitOrthogonal();
  first.normalize();
  const Vec3 aside = n.cross(first);
  Vec3 way = first;
  for (int turn = 0; turn < kTurns; ++turn) {  // mostly a contraction
    const Vec3 goes = slip(way);
    const double speed = goes.norm();
    if (!(speed > 0) || !(way.dot(goes) > 0)) break;
    const Vec3 next = goes / speed;
    const double moved = (next - way).norm();
    way = next;
    if (moved > 1e-15) continue;
    set(at, Touch::State::slides, given(way));
    return touch.push > 0;
  }
  const auto towards = [&](double angle) -> Vec3 {
    return std::cos(angle) * first + std::sin(angle) * aside;
  };
  const auto off = [&](double angle) {
    return slip(towards(angle)).dot(towards(angle + std::numbers::pi / 2));
  };
  constexpr double kStep = 2 * std::numbers::pi / kWays;
  for (int k = 0; k < kWays; ++k) {
    double low = (k - 0.5) * kStep, high = low + kStep;
    const double at_low = off(low);
    if (at_low * off(high) > 0) continue;
    for (int halving = 0; halving < kHalvings; ++halving) {
      const double middle = (low + high) / 2;
      (at_low * off(middle) > 0 ? low : high) = middle;
    }
    way = towards((low + high) / 2);
    const Vec3 found = given(way);
    if (!(n.dot(found) > 0) || !(slip(way).dot(way) >= 0)) continue;
    set(at, Touch::State::slides, found);
    return true;
  }
  return false;
}

/// The laws of the touches in their states, by what is given and by the velocities without.
void BodySystem::linearize(std::span<const Vec3> bare, std::span<const BodyTouch> touches) {
  const Eigen::Index size = row(touches.size());
  matrix_.setZero(size, size);
  slope_.setZero(size, size);
  error_.setZero(size);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch& touch = touches[i].touch;
    const Eigen::Index at = row(i);
    if (touch.state == Touch::State::open) {
      matrix_.block<3, 3>(at, at).setIdentity();
      error_.segment<3>(at) = given_[i];
      continue;
    }
    const Vec3& n = touch.normal;
    const Mat3 tangent = across(n);
    const Vec3 moves = velocity(i, bare);
    const Vec3 slip = tangent * (moves - touch.surface);
    Mat3 by_velocity = n * n.transpose() / ease_, by_given;
    Vec3 error = (n.dot(moves) - touch.least) / ease_ * n;
    if (touch.state == Touch::State::sticks) {
      by_velocity = Mat3::Identity() / ease_;
      by_given = creep_ * tangent;
      error += slip / ease_ + creep_ * tangent * given_[i];
    } else {
      const double speed = slip.norm();
      const bool known = !touches[i].ahead.isZero(0);
      const Vec3 way =
          known ? touches[i].ahead : (speed > 0 ? Vec3(slip / speed) : Vec3(Vec3::Zero()));
      const double push = n.dot(given_[i]);
      by_given = tangent + touch.slide * way * n.transpose();
      error += tangent * given_[i] + touch.slide * push * way;
      if (!known && speed > 0) {
        by_velocity += touch.slide * push / speed * (tangent - way * way.transpose());
      }
    }
    slope_.block<3, 3>(at, at) = by_velocity;
    error_.segment<3>(at) = error;
    matrix_.block<3, 3>(at, at) += by_given;
    for (std::size_t k = 0; k < touches.size(); ++k) {
      matrix_.block<3, 3>(at, row(k)) += by_velocity * coupling(i, k);
    }
  }
}

/// What is given by the linear laws. Where they leave that open, between touches that stick, each
/// takes its part of the friction by what presses it now.
std::vector<Vec3> BodySystem::solve_linear(std::span<const BodyTouch> touches) const {
  double most = 0;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    most = std::max(most, touches[i].touch.normal.dot(given_[i]));
  }
  const Eigen::Index size = row(touches.size());
  Eigen::VectorXd right = -error_;
  Eigen::MatrixXd weights = Eigen::MatrixXd::Identity(size, size), rows = weights;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Vec3& n = touches[i].touch.normal;
    right += matrix_.middleCols<3>(row(i)) * given_[i];
    const double part = most > 0 ? std::max(n.dot(given_[i]) / most, kLeastPart) : 1;
    weights.block<3, 3>(row(i), row(i)) = n * n.transpose() + part * across(n);
    rows.block<3, 3>(row(i), row(i)) = kFirst * n * n.transpose() + across(n);
  }
  LeastSquares decomposed(kDependent);
  decomposed.compute(rows * matrix_ * weights);
  const Eigen::VectorXd found = weights * decomposed.solve(Eigen::VectorXd(rows * right));
  std::vector<Vec3> given;
  for (std::size_t i = 0; i < touches.size(); ++i) given.push_back(found.segment<3>(row(i)));
  return given;
}

/// Newton's method on what is given, with the states as they are; whether that obeys the laws.
bool BodySystem::polish(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  const std::vector<Vec3> kept = given_;
  double before = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kNewtons; ++i) {
    linearize(bare, touches);
    const std::vector<Vec3> next = solve_linear(touches);
    double most = 0, change = 0;
    for (std::size_t k = 0; k < touches.size(); ++k) {
      most = std::max(most, next[k].norm());
      change = std::max(change, (next[k] - given_[k]).norm());
    }
    if (!std::isfinite(change)) break;
    given_ = next;
    if (change <= 1e-15 * most || change > before / 2) break;
    before = change;
  }
  if (is_solved(bare, touches)) {
    for (std::size_t k = 0; k < touches.size(); ++k) {
      set(touches[k], touches[k].touch.state, given_[k]);
    }
    return true;
  }
  given_ = kept;
  return false;
}

/// Whether the body is held at all that touches it: where that is a solution, static friction may
/// be more than kinetic, and no way through states that slide leads there.
bool BodySystem::sticks(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  if (touches.size() < 2) return false;
  for (const BodyTouch& at : touches) {
    if (at.touch.stick == 0 || !at.ahead.isZero(0)) return false;
  }
  const std::vector<BodyTouch> kept(touches.begin(), touches.end());
  for (BodyTouch& at : touches) at.touch.state = Touch::State::sticks;
  if (polish(bare, touches)) return true;
  std::ranges::copy(kept, touches.begin());
  return false;
}

bool BodySystem::is_solved(std::span<const Vec3> bare, std::span<const BodyTouch> touches) const {
  double speed = 1;
  for (const Vec3& moves : bare) speed = std::max(speed, moves.norm());
  const double slack = 10 * kSlack * speed, weak = slack / ease_;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch& touch = touches[i].touch;
    const Vec3 moves = velocity(i, bare);
    const Vec3 slip = across(touch.normal) * (moves - touch.surface);
    const double past = touch.normal.dot(moves) - touch.least;
    const double push = touch.normal.dot(given_[i]);
    const double rub = (given_[i] - push * touch.normal).norm();
    if (past < -slack || push < -weak) return false;
    if (touch.state == Touch::State::open) continue;
    if (past > slack) return false;
    if (touch.state == Touch::State::sticks) {
      const Vec3 slips = across(touch.normal) * (bare[i] - touch.surface);
      if (rub > hold_of(touch, slips) * push + weak) return false;
      const double yields = touches.size() > 1 ? kYields * ease_ * touch.stick * push : 0;
      if (slip.norm() > slack + yields + 2 * creep_ * ease_ * rub) return false;
    } else if (std::abs(rub - touch.slide * push) > weak ||
               slip.dot(given_[i] - push * touch.normal) > slack * weak) {
      if (touches[i].ahead.isZero(0)) return false;
    }
  }
  return true;
}

bool BodySystem::solve(std::span<const Vec3> bare, std::span<BodyTouch> touches, double creep) {
  creep_ = creep;
  bare_.assign(bare.begin(), bare.end());
  given_.clear();
  for (const BodyTouch& at : touches) given_.push_back(at.given);
  if (sticks(bare, touches)) return true;
  const auto states = [&] {
    std::size_t number = 0;
    for (const BodyTouch& at : touches) {
      number = 3 * number + static_cast<std::size_t>(at.touch.state);
    }
    return number;
  };
  std::size_t before = states();
  int same = 0, wait = 1;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    bool finds = true;
    double change = 0, most = 0;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const Vec3 others = velocity(i, bare) - coupling(i, i) * given_[i];
      finds = solve_one(i, others, touches[i]) && finds;
      change = std::max(change, (touches[i].given - given_[i]).norm());
      given_[i] = touches[i].given;
      most = std::max(most, given_[i].norm());
    }
    if (!finds && touches.size() == 1) return false;
    if (finds && (touches.size() == 1 || change <= 1e-16 * most)) return true;
    const std::size_t now = states();
    same = now == before ? same + 1 : 0;
    before = now;
    if (!finds || same < wait) continue;
    if (polish(bare, touches)) return true;
    same = 0;
    wait *= 2;
  }
  return is_solved(bare, touches);
}

void BodySystem::hold(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  creep_ = 0;
  bare_.assign(bare.begin(), bare.end());
  given_.assign(touches.size(), Vec3::Zero());
  for (int i = 0; i < 2; ++i) {  // the second time with what presses known
    linearize(bare, touches);
    given_ = solve_linear(touches);
  }
  for (std::size_t i = 0; i < touches.size(); ++i) {
    set(touches[i], touches[i].touch.state, given_[i]);
  }
}

Vec6 BodySystem::twist(std::span<const BodyTouch> touches) const {
  Vec6 wrench = Vec6::Zero();
  for (std::size_t i = 0; i < touches.size(); ++i) {
    wrench += lever_[i].transpose() * touches[i].given;
  }
  return mobility_ * wrench;
}

Mat6 BodySystem::answer(std::span<const BodyTouch> touches) {
  if (touches.empty()) return mobility_;
  linearize(bare_, touches);
  LeastSquares decomposed(kDependent);
  decomposed.compute(matrix_);
  Eigen::MatrixXd levers(row(touches.size()), 6);
  for (std::size_t i = 0; i < touches.size(); ++i) levers.block<3, 6>(row(i), 0) = lever_[i];
  const Eigen::MatrixXd gives = decomposed.solve(Eigen::MatrixXd(slope_ * levers));
  const Mat6 answer = mobility_ - share_ * mobility_ * (levers.transpose() * gives) * mobility_;
  // What cannot move at all does not move by rounding either.
  return answer.cwiseAbs().maxCoeff() > kImmobile * mobility_.cwiseAbs().maxCoeff()
             ? answer
             : Mat6(Mat6::Zero());
}

}  // namespace taut::contact
