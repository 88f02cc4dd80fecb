#include "render/export/gltf/gltf_motion.h"

#include <algorithm>
#include <cmath>

namespace taut::exporting {

HermiteWeights hermite_weights(double u, double span) {
  const double v = 1 - u;
  return {v * v * (1 + 2 * u), span * u * v * v, -span * u * u * v, u * u * (3 - 2 * u)};
}

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

namespace {

/// True where no component, of so many an item, changes by more than `most`.
template <typename Number>
bool stands(const std::vector<Number>& numbers, std::size_t size, double most) {
  for (std::size_t k = 0; k < size; ++k) {
    Number least = numbers[k], largest = numbers[k];
    for (std::size_t i = k; i < numbers.size(); i += size) {
      least = std::min(least, numbers[i]);
      largest = std::max(largest, numbers[i]);
    }
    if (double(largest) - double(least) > most) return false;
  }
  return true;
}

constexpr double kOne = 32767;  // of 16 bits

/// The keys of a track without those that are off the straight way between their neighbours by
/// `most` at most, in none of so many components an item.
template <typename Number>
std::vector<std::size_t> needed_keys(const std::vector<Number>& track, std::size_t size,
                                     double most, const std::vector<float>& times) {
  constexpr std::size_t kLongest = 128;  // keys from one to the next
  const auto straight = [&](std::size_t from, std::size_t to) {
    for (std::size_t i = from + 1; i < to; ++i) {
      const double share = double(times[i] - times[from]) / double(times[to] - times[from]);
      for (std::size_t k = 0; k < size; ++k) {
        const double on_line =
            std::lerp(double(track[size * from + k]), double(track[size * to + k]), share);
        if (std::abs(on_line - double(track[size * i + k])) > most) return false;
      }
    }
    return true;
  };
  std::vector<std::size_t> keys{0};
  while (keys.back() + 1 < times.size()) {
    std::size_t next = keys.back() + 1;
    const std::size_t last = std::min(times.size() - 1, keys.back() + kLongest);
    while (next < last && straight(keys.back(), next + 1)) ++next;
    keys.push_back(next);
  }
  return keys;
}

}  // namespace

void GltfMotion::translate(std::size_t node, const Vec3& to) {
  for (const double number : to) translations_[node].push_back(float(number));
}

void GltfMotion::turn(std::size_t node, const Quat& to) {
  std::vector<std::int16_t>& track = rotations_[node];
  Eigen::Vector4d q = to.normalized().coeffs();
  if (!track.empty()) {
    double dot = 0;
    for (std::size_t k = 0; k < 4; ++k) dot += double(track[track.size() - 4 + k]) * q[int(k)];
    if (dot < 0) q *= -1;
  }
  for (const double number : q) track.push_back(std::int16_t(std::lround(number * kOne)));
}

void GltfMotion::spline_translation(std::size_t node, const std::vector<float>& numbers) {
  spline(node, "translation", 3, numbers);
}

void GltfMotion::spline_rotation(std::size_t node, const std::vector<float>& numbers) {
  spline(node, "rotation", 4, numbers);
}

void GltfMotion::spline(std::size_t node, const char* path, std::size_t size,
                        const std::vector<float>& numbers) {
  if (stands(numbers, 3 * size, 0)) {
    const auto value = numbers.begin() + std::ptrdiff_t(size);
    const std::vector<float> one(value, value + std::ptrdiff_t(size));
    if (joints_.contains(node)) {
      still<float>(node, path, {GltfFile::f32, size == 3 ? "VEC3" : "VEC4"}, one);
    } else {
      file_.node(node)[path] = one;
    }
    return;
  }
  channel(node, path, "CUBICSPLINE",
          file_.add_numbers(std::span(numbers), {GltfFile::f32, size == 3 ? "VEC3" : "VEC4"}));
}

void GltfMotion::channel(std::size_t node, const char* path, const char* interpolation,
                         std::size_t output) {
  channels_.push_back(
      {{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
  samplers_.push_back({{"input", nullptr}, {"interpolation", interpolation}, {"output", output}});
}

std::size_t GltfMotion::input(const std::vector<float>& times) {
  return file_.add_numbers(std::span(times),
                           {GltfFile::f32, "SCALAR", GltfFile::Use::animation, false, true});
}

template <typename Number>
void GltfMotion::straight(std::size_t node, const char* path, const GltfFile::Numbers& about,
                          std::size_t size, double most, const std::vector<Number>& track,
                          const std::vector<float>& times) {
  const auto add = [&](const std::vector<Number>& numbers) {
    channel(node, path, "LINEAR", file_.add_numbers(std::span<const Number>(numbers), about));
  };
  const std::vector<std::size_t> keys = needed_keys(track, size, most, times);
  const std::size_t value_bytes = size * sizeof(Number);
  if (keys.size() * (value_bytes + sizeof(float)) >= times.size() * value_bytes) return add(track);
  std::vector<float> own;
  std::vector<Number> values;
  for (const std::size_t key : keys) {
    own.push_back(times[key]);
    const auto value = track.begin() + std::ptrdiff_t(size * key);
    values.insert(values.end(), value, value + std::ptrdiff_t(size));
  }
  add(values);
  samplers_.back()["input"] = input(own);
}

template <typename Number>
void GltfMotion::still(std::size_t node, const char* path, const GltfFile::Numbers& about,
                       std::span<const Number> value) {
  channel(node, path, "STEP", file_.add_numbers(value, about));
  if (!start_) start_ = input({0});
  samplers_.back()["input"] = *start_;
}

void GltfMotion::finish(const std::string& name, const std::vector<float>& times) {
  for (const auto& [node, numbers] : translations_) {
    constexpr double kStill = 1e-7, kOff = 2e-5;  // m
    const GltfFile::Numbers about{GltfFile::f32, "VEC3"};
    if (!stands(numbers, 3, kStill)) {
      straight(node, "translation", about, 3, kOff, numbers, times);
    } else if (joints_.contains(node)) {
      still(node, "translation", about, std::span<const float>(numbers).first(3));
    } else {
      file_.place(node, {Vec3(numbers[0], numbers[1], numbers[2]), Quat::Identity()});
    }
  }
  for (const auto& [node, numbers] : rotations_) {
    constexpr double kSteps = 2;  // of 16 bits: 6e-5 rad
    const GltfFile::Numbers about{GltfFile::i16, "VEC4", GltfFile::Use::animation, true};
    if (!stands(numbers, 4, kSteps)) {
      straight(node, "rotation", about, 4, kSteps, numbers, times);
    } else if (joints_.contains(node)) {
      still(node, "rotation", about, std::span<const std::int16_t>(numbers).first(4));
    } else {
      file_.place(node, {Vec3::Zero(), Quat(numbers[3], numbers[0], numbers[1], numbers[2])});
    }
  }
  if (channels_.empty()) return;
  const std::size_t all = input(times);
  for (GltfFile::Json& sampler : samplers_)
    if (sampler["input"].is_null()) sampler["input"] = all;
  file_.add(
      "animations",
      {{"name", name}, {"channels", std::move(channels_)}, {"samplers", std::move(samplers_)}});
}

}  // namespace taut::exporting
