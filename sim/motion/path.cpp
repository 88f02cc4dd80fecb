#include "sim/motion/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sim/motion/hash.h"
#include "sim/motion/rotation.h"

namespace taut {

FrameMotion motion(const Circle& circle, double time) {
  const double speed = 2 * std::numbers::pi * circle.frequency;  // rad/s, after the ramp
  const double u = std::clamp(time / circle.ramp, 0.0, 1.0);
  const double after = std::max(time - circle.ramp, 0.0);
  const double angle = speed * (circle.ramp * u * u * u * (1 - u / 2) + after);
  const double rate = speed * u * u * (3 - 2 * u);            // rad/s
  const double gain = speed / circle.ramp * 6 * u * (1 - u);  // rad/s^2
  const double cosine = std::cos(angle), sine = std::sin(angle);
  const Vec3 first = circle.start - circle.centre, across = circle.axis.cross(first);
  const Vec3 radius = cosine * first + sine * across, tangent = cosine * across - sine * first;

  FrameMotion motion;
  motion.position = circle.centre + radius;
  motion.velocity = rate * tangent;
  motion.acceleration = gain * tangent - rate * rate * radius;
  return motion;
}

namespace {

using KeyRow = Eigen::Matrix<double, 7, 1>;

bool eases(const std::vector<PathKey>& keys, std::size_t i) {
  return i == 0 || i + 1 == keys.size() || keys[i].ease;
}

/// Rates between the keys first and last of the cubic spline that has `rate` at both; Thomas's
/// algorithm on the conditions that the second derivative is continuous at every key between them.
void section_rates(const std::vector<PathKey>& keys, const std::vector<KeyRow>& value,
                   std::size_t first, std::size_t last, std::vector<KeyRow>& rate) {
  std::vector<double> above(last - first + 1, 0.0);
  const auto upper = [&](std::size_t i) -> double& { return above[i - first]; };
  for (std::size_t i = first + 1; i < last; ++i) {
    const double before = keys[i].time - keys[i - 1].time;
    const double after = keys[i + 1].time - keys[i].time;
    const KeyRow right = 3 * ((value[i] - value[i - 1]) / (before * before) +
                              (value[i + 1] - value[i]) / (after * after));
    const double pivot = 2 / before + 2 / after - upper(i - 1) / before;
    upper(i) = 1 / (after * pivot);
    rate[i] = (right - rate[i - 1] / before) / pivot;
  }
  for (std::size_t i = last - 1; i > first; --i) rate[i] -= upper(i) * rate[i + 1];
}

template <int kRows>
struct Jet {
  Eigen::Matrix<double, kRows, 1> value, rate, rate2;
};

/// The quintic over [0, h] that leaves `value` with the first two derivatives given, at u h.
template <typename Rows>
auto quintic(const Rows& value, const Rows& rate, const Rows& rate2, const Rows& c3, const Rows& c4,
             const Rows& c5, double h, double u) {
  const double u2 = u * u;
  return Jet<Rows::RowsAtCompileTime>{
      value + u * h * rate + u2 * (h * h / 2 * rate2 + u * (c3 + u * (c4 + u * c5))),
      rate + u * h * rate2 + u2 / h * (3 * c3 + u * (4 * c4 + u * 5 * c5)),
      rate2 + u / (h * h) * (6 * c3 + u * (12 * c4 + u * 20 * c5))};
}

/// The rotation is the normalised 4-vector p = n q, so p' = n'q + n q', p'' = n''q + 2n'q' + n q''.
/// For a unit q the spin is the vector part of 2 q' q*, and its rate that of 2 q'' q*.
FrameMotion frame_motion(const Jet<3>& place, const Jet<4>& turn) {
  const Eigen::Vector4d &p = turn.value, &p1 = turn.rate, &p2 = turn.rate2;
  const auto quat = [](const Eigen::Vector4d& c) { return Quat(c[0], c[1], c[2], c[3]); };
  const double n = p.norm();
  const Eigen::Vector4d q = p / n;
  FrameMotion motion{place.value, place.rate, place.rate2, quat(q)};
  const double n1 = q.dot(p1);
  const Eigen::Vector4d q1 = (p1 - n1 * q) / n;
  const double n2 = (p1.squaredNorm() + p.dot(p2) - n1 * n1) / n;
  const Eigen::Vector4d q2 = (p2 - n2 * q - 2 * n1 * q1) / n;
  motion.spin = 2 * (quat(q1) * motion.rotation.conjugate()).vec();
  motion.spin_rate = 2 * (quat(q2) * motion.rotation.conjugate()).vec();
  return motion;
}

FrameMotion motion(const Axle& axle, double time) {
  const FrameMotion angle = axle.angle->at(time);
  const double along = axle.pitch / (2 * std::numbers::pi);  // m per radian
  const auto about = [&](const Vec3& of) -> Vec3 { return of.x() * axle.axis; };
  const Eigen::AngleAxisd turn(angle.position.x(), Vec3::UnitY());
  return {axle.position + along * about(angle.position),
          along * about(angle.velocity),
          along * about(angle.acceleration),
          rotation_between(Vec3::UnitY(), axle.axis) * Quat(turn),
          about(angle.velocity),
          about(angle.acceleration)};
}

}  // namespace

Path::Path(std::vector<PathKey> keys) : keys_(std::move(keys)) {
  if (keys_.empty()) throw std::invalid_argument("a path needs at least one key");
  for (std::size_t i = 1; i < keys_.size(); ++i) {
    if (!(keys_[i - 1].time < keys_[i].time)) {
      throw std::invalid_argument("the times of a path's keys must rise");
    }
  }
  const std::size_t n = keys_.size();
  value_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector4d q(keys_[i].rotation.w(), keys_[i].rotation.x(), keys_[i].rotation.y(),
                      keys_[i].rotation.z());
    q.normalize();
    // q and -q are one rotation: take the sign nearer to the key before.
    if (i > 0 && q.dot(value_[i - 1].tail<4>()) < 0) q = -q;
    value_[i] << keys_[i].position, q;
  }
  rate_.assign(n, KeyRow::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    if (eases(keys_, i)) rate_[i].head<3>() = keys_[i].velocity;
  }
  rate2_.assign(n, KeyRow::Zero());
  for (std::size_t first = 0, i = 1; i < n; ++i) {
    if (!eases(keys_, i)) continue;
    section_rates(keys_, value_, first, i, rate_);
    for (std::size_t k = first + 1; k < i; ++k) {
      const double h = keys_[k + 1].time - keys_[k].time;
      rate2_[k] = (6 * (value_[k + 1] - value_[k]) / h - 4 * rate_[k] - 2 * rate_[k + 1]) / h;
    }
    first = i;
  }
  for (const KeyRow& row : value_) {
    const Eigen::Vector4d q = row.tail<4>() / row.tail<4>().norm();
    rotation_.emplace_back(q[0], q[1], q[2], q[3]);
  }
  for (std::size_t i = 0; i + 1 < n; ++i) sections_.push_back(section(i));
  Hash hash;
  for (const PathKey& key : keys_) {
    hash.word(key.time).word(std::uint64_t{key.ease});
    for (const double c : key.position) hash.word(c);
    for (const double c : key.rotation.coeffs()) hash.word(c);
    if (key.velocity.isZero(0)) continue;
    for (const double c : key.velocity) hash.word(c);
  }
  fingerprint_ = hash.value();
}

/// The quintic with the values and first two derivatives that the keys have.
Path::Section Path::section(std::size_t first) const {
  const std::size_t a = first, b = first + 1;
  const double h = keys_[b].time - keys_[a].time;
  const KeyRow d = value_[b] - value_[a] - h * rate_[a] - h * h / 2 * rate2_[a];
  const KeyRow e = h * (rate_[b] - rate_[a]) - h * h * rate2_[a];
  const KeyRow f = h * h * (rate2_[b] - rate2_[a]);
  const auto moves = [](const KeyRow& row) { return !row.tail<4>().isZero(0); };
  return {10 * d - 4 * e + f / 2, -15 * d + 7 * e - f, 6 * d - 3 * e + f / 2,
          moves(value_[b] - value_[a]) || moves(rate_[a]) || moves(rate_[b]) || moves(rate2_[a]) ||
              moves(rate2_[b])};
}

Path Path::round(const Circle& circle) {
  Path path;
  path.circle_ = circle;
  const double third = 1 / (3 * circle.frequency);
  for (const double time :
       {0.0, circle.ramp, circle.ramp + third, circle.ramp + 2 * third, circle.ramp + 3 * third}) {
    path.keys_.push_back({time, motion(circle, time).position});
  }
  Hash hash;
  for (const Vec3* vector : {&circle.centre, &circle.start, &circle.axis}) {
    for (const double c : *vector) hash.word(c);
  }
  path.fingerprint_ = hash.word(circle.frequency).word(circle.ramp).value();
  return path;
}

Path Path::about(const Axle& axle) {
  Path path;
  path.axle_ = axle;
  for (const PathKey& key : axle.angle->keys()) {
    const FrameMotion frame = motion(axle, key.time);
    path.keys_.push_back({key.time, frame.position, frame.rotation, key.ease});
  }
  Hash hash;
  for (const Vec3* vector : {&axle.position, &axle.axis}) {
    for (const double c : *vector) hash.word(c);
  }
  path.fingerprint_ = hash.word(axle.pitch).word(axle.angle->fingerprint()).value();
  return path;
}

Path Path::moved(const Vec3& by, double delay) const {
  Path path = *this;
  for (PathKey& key : path.keys_) {
    key.time += delay;
    key.position += by;
  }
  if (!circle_ && !axle_) return Path(std::move(path.keys_));
  if (circle_) {
    path.circle_->centre += by;
    path.circle_->start += by;
  }
  if (axle_) path.axle_->position += by;
  path.delay_ += delay;
  Hash hash;
  for (const double c : by) hash.word(c);
  path.fingerprint_ = hash.word(delay).word(fingerprint_).value();
  return path;
}

FrameMotion Path::at(double time) const {
  if (circle_) return motion(*circle_, time - delay_);
  if (axle_) return motion(*axle_, time - delay_);
  const auto after = std::upper_bound(keys_.begin(), keys_.end(), time,
                                      [](double t, const PathKey& key) { return t < key.time; });
  const auto beyond = [&](std::size_t i) -> FrameMotion {
    const Vec3& velocity = keys_[i].velocity;
    return {keys_[i].position + (time - keys_[i].time) * velocity, velocity, Vec3::Zero(),
            rotation_[i]};
  };
  if (after == keys_.begin()) return beyond(0);
  const auto b = static_cast<std::size_t>(after - keys_.begin()), a = b - 1;
  if (after == keys_.end()) return beyond(a);
  const double h = keys_[b].time - keys_[a].time, u = (time - keys_[a].time) / h;
  const Section& s = sections_[a];
  const auto rows = [&](auto part) {
    return quintic(part(value_[a]), part(rate_[a]), part(rate2_[a]), part(s.c3), part(s.c4),
                   part(s.c5), h, u);
  };
  const Jet<3> place = rows([](const KeyRow& row) -> Vec3 { return row.head<3>(); });
  if (!s.turns) return {place.value, place.rate, place.rate2, rotation_[a]};
  return frame_motion(place,
                      rows([](const KeyRow& row) -> Eigen::Vector4d { return row.tail<4>(); }));
}

}  // namespace taut
