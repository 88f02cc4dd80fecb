#include "sim/contact/body_system.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/links/linear_systems.h"
#include "sim/motion/rotation.h"
#include "sim/motion/stop.h"

namespace taut::contact {
namespace {

constexpr double kSlack = 1e-13;      // of the speeds: a law broken by rounding
constexpr double kSeveral = 1000;     // times that, of bodies that touch each other
constexpr int kSweeps = 400;          // of Gauss-Seidel
constexpr int kNewtons = 8;           // from states that seem to be right
constexpr double kDependent = 1e-11;  // of the largest pivot: touches that say the same

constexpr double kLeastPart = 1e-6;  // of what presses most
constexpr double kFirst = 1e5;       // normals before friction, where both cannot be had
constexpr double kYields = 1e-3;     // of what friction could change: what sticks may part by less
constexpr double kHeldBack = 1e-6;   // of the inverse mass
constexpr double kImmobile = 1e-12;  // of the mobility of the free body

Eigen::Index row(std::size_t touch) {
  return 3 * static_cast<Eigen::Index>(touch);
}

}  // namespace

std::uint32_t BodySystem::index_of(std::uint32_t body, std::span<const Mat6> mobility) {
  const auto found = std::ranges::find(bodies_, body);
  const auto index = static_cast<std::uint32_t>(found - bodies_.begin());
  if (found == bodies_.end()) {
    bodies_.push_back(body);
    mobility_.push_back(mobility[body]);
  }
  return index;
}

void BodySystem::assemble(std::span<const Mat6> mobility, std::span<const BodyTouch> touches,
                          double share) {
  share_ = share;
  bodies_.clear();
  mobility_.clear();
  sides_.clear();
  inverse_mass_.clear();
  for (const BodyTouch& at : touches) {
    auto& [own, other] = sides_.emplace_back();
    own.index = index_of(at.body, mobility);
    own.lever.leftCols<3>().setIdentity();
    own.lever.rightCols<3>() = -cross_matrix(at.arm);
    double inverse_mass = mobility[at.body](0, 0);
    if (at.other != kNoBody) {
      other.index = index_of(at.other, mobility);
      other.lever.leftCols<3>() = -Mat3::Identity();
      other.lever.rightCols<3>() = cross_matrix(at.other_arm);
      inverse_mass += mobility[at.other](0, 0);
    }
    inverse_mass_.push_back(share * inverse_mass);
  }
  several_ = bodies_.size() > 1;
  linked_ = false;
  const Eigen::Index size = row(touches.size());
  coupling_.resize(size, size);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    for (std::size_t k = 0; k < touches.size(); ++k) {
      Mat3 sum = Mat3::Zero();
      for (const Side& at : sides_[i]) {
        for (const Side& by : sides_[k]) {
          if (at.index == kNoBody || at.index != by.index) continue;
          sum += share * at.lever * mobility_[at.index] * by.lever.transpose();
        }
      }
      coupling_.block<3, 3>(row(i), row(k)) = sum;
    }
  }
}

void BodySystem::assemble(const Eigen::MatrixXd& coupling, std::span<const double> inverse_mass) {
  share_ = 1;
  bodies_.clear();
  several_ = linked_ = true;
  coupling_ = coupling;
  inverse_mass_.assign(inverse_mass.begin(), inverse_mass.end());
}

/// 1/kg: in sweeps a touch that links hold changes what it gives as if it moved by so much more.
double BodySystem::held_back(std::size_t i) const {
  return linked_ ? kHeldBack * inverse_mass_[i] : 0;
}

Mat3 BodySystem::coupling(std::size_t i, std::size_t k) const {
  return coupling_.block<3, 3>(row(i), row(k));
}

Vec3 BodySystem::velocity(std::size_t i, std::span<const Vec3> bare) const {
  Vec3 sum = bare[i];
  for (std::size_t k = 0; k < given_.size(); ++k) sum += coupling(i, k) * given_[k];
  return sum;
}

// One touch of bodies, where all others give what they do.

namespace {

constexpr double kClosed = 1e-13;  // of the speeds: less is no approach but rounding
constexpr int kTurns = 20;         // of Newton's method on the way of sliding
constexpr int kWays = 32;          // looked at where that fails
constexpr int kHalvings = 60;

}  // namespace

/// One touch alone, where the others give what they do. False: friction jams it.
bool BodySystem::solve_one(std::size_t i, const Vec3& bare, BodyTouch& at) const {
  const Touch& touch = at.touch;
  const Vec3& n = touch.normal;
  const double short_of = touch.least - n.dot(bare);
  if (!(short_of > kClosed * (1 + bare.norm()))) {
    set(at, Touch::State::open, Vec3::Zero());
    return true;
  }
  const Mat3 mobility = coupling(i, i) + held_back(i) * Mat3::Identity();
  if (touch.stick == 0 && touch.slide == 0) {
    set(at, Touch::State::slides, short_of / n.dot(mobility * n) * n);
    return true;
  }
  if (at.ahead.isZero(0)) {
    const Mat3 tangent = across(n);
    const Vec3 slip = tangent * (bare - touch.surface);
    const Mat3 creeps = mobility + creep_ * inverse_mass_[i] * tangent;
    const Vec3 given = creeps.partialPivLu().solve(short_of * n - slip);
    const double push = n.dot(given);
    if (push > 0 && (given - push * n).norm() <= friction_of(touch, slip) * push) {
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
  const Mat3 mobility = coupling(i, i) + held_back(i) * Mat3::Identity();
  const double short_of = touch.least - n.dot(bare);
  const auto given = [&](const Vec3& way) -> Vec3 {
    const Vec3 force = n - touch.slide * way;
    const double gives = n.dot(mobility * force);
    return gives > 0 ? Vec3(short_of / gives * force) : Vec3(Vec3::Zero());
  };
  const auto slip = [&](const Vec3& way) -> Vec3 {
    return across(n) * (bare + mobility * given(way) - touch.surface);
  };
  if (!at.ahead.isZero(0)) {
    set(at, Touch::State::slides, given(at.ahead));
    return touch.push > 0;
  }
  Vec3 first = across(n) * (bare - touch.surface);
  if (!(first.norm() > 0)) first = touch.sliding - n.dot(touch.sliding) * n;
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

// All touches at once.

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
    const double inverse_mass = inverse_mass_[i];
    const Mat3 tangent = across(n);
    const Vec3 moves = velocity(i, bare);
    const Vec3 slip = tangent * (moves - touch.surface);
    Mat3 by_velocity = n * n.transpose() / inverse_mass, by_given;
    Vec3 error = (n.dot(moves) - touch.least) / inverse_mass * n;
    if (touch.state == Touch::State::sticks) {
      by_velocity = Mat3::Identity() / inverse_mass;
      by_given = creep_ * tangent;
      error += slip / inverse_mass + creep_ * tangent * given_[i];
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

/// The touches' impulses by the linear laws. Where these leave the friction of touches that stick
/// undetermined, each takes a part in proportion to its present normal impulse.
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
    check_stop();
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
  tried_ = given_;
  given_ = kept;
  return false;
}

/// Whether the touches obey the laws in the states that they had last: of several bodies that is
/// found sooner than from sticking.
bool BodySystem::goes_on(std::span<const Vec3> bare, std::span<BodyTouch> touches) {
  const auto is_open = [](const BodyTouch& at) { return at.touch.state == Touch::State::open; };
  return !std::ranges::all_of(touches, is_open) && polish(bare, touches);
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
  // Of several bodies some may be about to part, and the others stick.
  for (bool opens = several_; opens;) {
    opens = false;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const bool pulls = !(touches[i].touch.normal.dot(tried_[i]) > 0);
      if (touches[i].touch.state == Touch::State::open || !pulls) continue;
      touches[i].touch.state = Touch::State::open;
      opens = true;
    }
    if (opens && polish(bare, touches)) return true;
  }
  std::ranges::copy(kept, touches.begin());
  return false;
}

bool BodySystem::is_solved(std::span<const Vec3> bare, std::span<const BodyTouch> touches) const {
  double speed = 1;
  for (const Vec3& moves : bare) speed = std::max(speed, moves.norm());
  const double slack = (several_ ? kSeveral : 10) * kSlack * speed;
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch& touch = touches[i].touch;
    const double inverse_mass = inverse_mass_[i], weak = slack / inverse_mass;
    const Vec3 moves = velocity(i, bare);
    const Vec3 slip = across(touch.normal) * (moves - touch.surface);
    const double past = touch.normal.dot(moves) - touch.least;
    const double push = touch.normal.dot(given_[i]);
    const double friction = (given_[i] - push * touch.normal).norm();
    if (past < -slack || push < -weak) return false;
    if (touch.state == Touch::State::open) continue;
    if (past > slack) return false;
    if (touch.state == Touch::State::sticks) {
      const Vec3 slips = across(touch.normal) * (bare[i] - touch.surface);
      if (friction > friction_of(touch, slips) * push + weak) return false;
      const double yields =
          touches.size() > 1 && !linked_ ? kYields * inverse_mass * touch.stick * push : 0;
      if (slip.norm() > slack + yields + 2 * creep_ * inverse_mass * friction) return false;
    } else if (std::abs(friction - touch.slide * push) > weak ||
               slip.dot(given_[i] - push * touch.normal) > weak * (slack + slip.norm())) {
      if (touches[i].ahead.isZero(0)) return false;
    }
  }
  return true;
}

bool BodySystem::solve(std::span<const Vec3> bare, std::span<BodyTouch> touches, double creep) {
  if (touches.empty()) return true;
  creep_ = creep;
  bare_.assign(bare.begin(), bare.end());
  given_.clear();
  for (const BodyTouch& at : touches) given_.push_back(at.given);
  if (several_ && goes_on(bare, touches)) return true;
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
    check_stop();
    bool finds = true;
    double change = 0, most = 0;
    for (std::size_t i = 0; i < touches.size(); ++i) {
      const Vec3 others = velocity(i, bare) - coupling(i, i) * given_[i] - held_back(i) * given_[i];
      finds = solve_one(i, others, touches[i]) && finds;
      change = std::max(change, (touches[i].given - given_[i]).norm());
      given_[i] = touches[i].given;
      most = std::max(most, given_[i].norm());
    }
    if (!finds && touches.size() == 1) return false;
    if (finds && !linked_ && (touches.size() == 1 || change <= 1e-16 * most)) return true;
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
  if (touches.empty()) return;
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

Vec6 BodySystem::twist(std::span<const BodyTouch> touches, std::size_t index) const {
  Vec6 sum = Vec6::Zero();
  for (std::size_t i = 0; i < touches.size(); ++i) {
    for (const Side& side : sides_[i]) {
      if (side.index == index) sum += side.lever.transpose() * touches[i].given;
    }
  }
  return mobility_[index] * sum;
}

void BodySystem::couple(std::span<const BodyTouch> touches, BodyMobility& mobility) {
  linearize(bare_, touches);
  LeastSquares decomposed(kDependent);
  decomposed.compute(matrix_);
  const std::size_t count = bodies_.size();
  blocks_.assign(count * count, Mat6::Zero());
  std::vector<Eigen::MatrixXd> levers(count);
  for (std::size_t b = 0; b < count; ++b) {
    levers[b].setZero(row(touches.size()), 6);
    for (std::size_t i = 0; i < touches.size(); ++i) {
      for (const Side& side : sides_[i]) {
        if (side.index == b) levers[b].block<3, 6>(row(i), 0) = side.lever;
      }
    }
  }
  for (std::size_t b = 0; b < count; ++b) {
    const Eigen::MatrixXd gives = decomposed.solve(Eigen::MatrixXd(slope_ * levers[b]));
    for (std::size_t a = 0; a < count; ++a) {
      const Mat6 free = a == b ? mobility_[a] : Mat6(Mat6::Zero());
      const Mat6 found =
          free - share_ * mobility_[a] * (levers[a].transpose() * gives) * mobility_[b];
      // A body that cannot move at all does not move by rounding either.
      const double most =
          std::sqrt(mobility_[a].cwiseAbs().maxCoeff() * mobility_[b].cwiseAbs().maxCoeff());
      if (found.cwiseAbs().maxCoeff() > kImmobile * most) blocks_[a * count + b] = found;
    }
  }
  mobility.set(bodies_, blocks_);
}

}  // namespace taut::contact
