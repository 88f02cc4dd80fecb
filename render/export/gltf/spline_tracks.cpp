#include "render/export/gltf/spline_tracks.h"

#include <algorithm>

#include "render/export/gltf/curve_fit.h"

namespace taut::exporting {
namespace {

using Vec4 = Eigen::Vector4d;

/// A key without slopes, behind those that there are.
template <typename Value>
void add_key(std::vector<float>& track, const Value& value) {
  for (int k = 0; k < 3; ++k)
    for (const double number : value) track.push_back(k == 1 ? float(number) : 0.0f);
}

template <int kSize>
void add_span(std::vector<float>& track, const Slopes<kSize>& slopes,
              const Eigen::Matrix<double, kSize, 1>& last) {
  float* const leaving = track.data() + track.size() - kSize;
  for (int k = 0; k < kSize; ++k) leaving[k] = float(slopes.leaving[k]);
  add_key(track, last);
  float* const arriving = track.data() + track.size() - 3 * kSize;
  for (int k = 0; k < kSize; ++k) arriving[k] = float(slopes.arriving[k]);
}

}  // namespace

/// The splines from one state to another, and how near they come to those between.
struct SplineTracks::Span {
  std::vector<Slopes<3>> points, positions;
  std::vector<Slopes<4>> rotations;
  double point_error = 0, frame_error = 0;
  std::size_t worst = 0;  // the state that is off most
};

SplineTracks::SplineTracks(std::size_t points, std::vector<double> radii)
    : radii_(std::move(radii)),
      points_(points),
      positions_(radii_.size()),
      rotations_(radii_.size()) {}

void SplineTracks::add(State state, bool is_frame, const std::function<void(std::size_t)>& key) {
  // q and -q are one rotation: of the two, the one that is near the state before.
  for (std::size_t i = 0; !pending_.empty() && i < state.frames.size(); ++i) {
    Quat& q = state.frames[i].rotation;
    if (q.dot(pending_.back().frames[i].rotation) < 0) q.coeffs() *= -1;
  }
  pending_.push_back(std::move(state));
  if (times_.empty()) {
    first_key();
    key(0);
  } else if (is_frame) {
    divide(0, pending_.size() - 1, key);
    before_ += pending_.size() - 1;
    pending_.erase(pending_.begin(), pending_.end() - 1);
  }
}

void SplineTracks::first_key() {
  const State& state = pending_.front();
  times_.push_back(float(state.time));
  for (std::size_t i = 0; i < points_.size(); ++i) add_key(points_[i], state.points[i]);
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    add_key(positions_[i], state.frames[i].position);
    add_key(rotations_[i], state.frames[i].rotation.coeffs());
  }
}

SplineTracks::Span SplineTracks::fit(std::size_t from, std::size_t to) const {
  Span span;
  const std::size_t count = to - from + 1;
  std::vector<double> times;
  for (std::size_t i = from; i <= to; ++i) times.push_back(pending_[i].time);
  const double length = times.back() - times.front();
  double largest = 0;
  std::vector<Vec3> points(count);
  std::vector<Vec4> turns(count);
  const auto off = [&](std::size_t i, double distance, double& error) {
    error = std::max(error, distance);
    if (distance > largest) {
      largest = distance;
      span.worst = from + i;
    }
  };
  const auto follow = [&](double& error) {
    const Slopes<3> slopes = fit_slopes<3>(times, points);
    for (std::size_t i = 1; i + 1 < count; ++i) {
      const double u = (times[i] - times.front()) / length;
      off(i, (on_cubic<3>(points.front(), points.back(), slopes, u, length) - points[i]).norm(),
          error);
    }
    return slopes;
  };
  for (std::size_t p = 0; p < points_.size(); ++p) {
    for (std::size_t i = 0; i < count; ++i) points[i] = pending_[from + i].points[p];
    span.points.push_back(follow(span.point_error));
  }
  for (std::size_t f = 0; f < radii_.size(); ++f) {
    for (std::size_t i = 0; i < count; ++i) {
      points[i] = pending_[from + i].frames[f].position;
      turns[i] = pending_[from + i].frames[f].rotation.coeffs();
    }
    span.positions.push_back(follow(span.frame_error));
    const Slopes<4> slopes = fit_slopes<4>(times, turns);
    for (std::size_t i = 1; i + 1 < count; ++i) {
      const double u = (times[i] - times.front()) / length;
      const Vec4 turn = on_cubic<4>(turns.front(), turns.back(), slopes, u, length).normalized();
      off(i, 2 * (turn - turns[i]).norm() * radii_[f], span.frame_error);
    }
    span.rotations.push_back(slopes);
  }
  return span;
}

void SplineTracks::divide(std::size_t from, std::size_t to,
                          const std::function<void(std::size_t)>& key) {
  const Span span = fit(from, to);
  if (std::max(span.point_error, span.frame_error) > kLimit) {
    divide(from, span.worst, key);
    return divide(span.worst, to, key);
  }
  point_error_ = std::max(point_error_, span.point_error);
  frame_error_ = std::max(frame_error_, span.frame_error);
  const State& state = pending_[to];
  times_.push_back(float(state.time));
  for (std::size_t i = 0; i < points_.size(); ++i)
    add_span<3>(points_[i], span.points[i], state.points[i]);
  for (std::size_t i = 0; i < radii_.size(); ++i) {
    add_span<3>(positions_[i], span.positions[i], state.frames[i].position);
    add_span<4>(rotations_[i], span.rotations[i], state.frames[i].rotation.coeffs());
  }
  key(before_ + to);
}

}  // namespace taut::exporting
