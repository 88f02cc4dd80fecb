// The animation of a glTF file: channels over one list of keys, or over their own part of it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "render/export/gltf/gltf_file.h"
#include "sim/motion/types.h"

namespace taut::exporting {

// Motions between two keys as glTF's cubic splines, fitted to the states between them.

/// The slopes (per second) of a cubic from one key to the next: as it leaves the one and comes to
/// the other.
template <int kSize>
struct Slopes {
  using Value = Eigen::Matrix<double, kSize, 1>;
  Value leaving, arriving;
};

/// The weights of a cubic's key values and slopes at the share `u` of an interval of `span` s
/// (glTF 2.0, appendix C).
struct HermiteWeights {
  double first, leaving, arriving, last;
};
HermiteWeights hermite_weights(double u, double span);

/// The slopes with which a cubic from the first to the last value comes nearest to those between
/// (least squares). `times` rise. Where too few are between to tell, the straight line.
template <int kSize>
Slopes<kSize> fit_slopes(std::span<const double> times,
                         std::span<const Eigen::Matrix<double, kSize, 1>> values) {
  using Value = Eigen::Matrix<double, kSize, 1>;
  const double start = times.front(), span = times.back() - start;
  const Value line = (values.back() - values.front()) / span;
  // Unknowns: by how much the slopes differ from the line's. A little weight on that decides where
  // nothing else does.
  constexpr double kTowardsLine = 1e-6;
  const double towards = kTowardsLine * span * span;
  double a = towards, b = 0, d = towards;
  Value p = Value::Zero(), q = Value::Zero();
  for (std::size_t i = 1; i + 1 < times.size(); ++i) {
    const double u = (times[i] - start) / span;
    const HermiteWeights w = hermite_weights(u, span);
    const Value rest = values[i] - values.front() - u * span * line;
    a += w.leaving * w.leaving;
    b += w.leaving * w.arriving;
    d += w.arriving * w.arriving;
    p += w.leaving * rest;
    q += w.arriving * rest;
  }
  const double determinant = a * d - b * b;
  return {line + (d * p - b * q) / determinant, line + (a * q - b * p) / determinant};
}

/// The cubic's value at the share `u` of the interval.
template <int kSize>
Eigen::Matrix<double, kSize, 1> on_cubic(const Eigen::Matrix<double, kSize, 1>& first,
                                         const Eigen::Matrix<double, kSize, 1>& last,
                                         const Slopes<kSize>& slopes, double u, double span) {
  const HermiteWeights w = hermite_weights(u, span);
  return w.first * first + w.leaving * slopes.leaving + w.arriving * slopes.arriving +
         w.last * last;
}

// Moving points and frames as cubic splines over one list of keys.

/// Takes states in the order of their times and keeps as few of them as keys as bring the splines
/// near the others: every frame is one, and whatever the limit needs between.
class SplineTracks {
 public:
  struct State {
    double time = 0;  // s
    std::vector<Vec3> points;
    std::vector<Pose> frames;
  };
  static constexpr double kLimit = 5e-5;  // m, by which splines may be off the states given

  /// `radii` tell of each frame how far from its origin there is something to see, m.
  SplineTracks(std::size_t points, std::vector<double> radii);

  /// Calls `key` with the index of each state that becomes one, counted from the first ever added.
  void add(State state, bool is_frame, const std::function<void(std::size_t)>& key);

  const std::vector<float>& times() const { return times_; }
  /// For every key: the slope before it, its value and the slope behind it, as glTF wants them.
  const std::vector<float>& point(std::size_t i) const { return points_[i]; }
  const std::vector<float>& position(std::size_t frame) const { return positions_[frame]; }
  /// Quaternions x, y, z, w.
  const std::vector<float>& rotation(std::size_t frame) const { return rotations_[frame]; }

  /// The largest distance of a point from its states, and of what is to see of a frame, m.
  double point_error() const { return point_error_; }
  double frame_error() const { return frame_error_; }

 private:
  using Vec4 = Eigen::Vector4d;
  struct Span;
  Span fit(std::size_t from, std::size_t to) const;
  void divide(std::size_t from, std::size_t to, const std::function<void(std::size_t)>& key);
  void first_key();

  std::vector<double> radii_;
  std::vector<State> pending_;  // from the last frame on
  std::size_t before_ = 0;      // states before these
  std::vector<float> times_;
  std::vector<std::vector<float>> points_, positions_, rotations_;
  double point_error_ = 0, frame_error_ = 0;
};

class GltfMotion {
 public:
  explicit GltfMotion(GltfFile& file) : file_(file) {}

  /// The node's own place is that of a joint as its mesh was made, and stays in the file.
  void keep(std::size_t node) { joints_.insert(node); }

  /// Where a node is at the next key, against its parent; straight between keys. Of each node at
  /// every key or never. Rotations are kept in 16 bits a number, to 6e-5 rad.
  void translate(std::size_t node, const Vec3& to);
  void turn(std::size_t node, const Quat& to);

  /// The same for all keys at once as cubic splines: slope before, value, slope behind.
  void spline_translation(std::size_t node, const std::vector<float>& numbers);
  void spline_rotation(std::size_t node, const std::vector<float>& numbers);

  /// Adds the animation to the file. A constant value becomes its node's place instead, unless that
  /// is kept. Nothing can be added then.
  void finish(const std::string& name, const std::vector<float>& times);

 private:
  void spline(std::size_t node, const char* path, std::size_t size,
              const std::vector<float>& numbers);
  /// A track of so many components an item, over the keys that it needs to be off by `most` at
  /// most, where that takes less room.
  template <typename Number>
  void straight(std::size_t node, const char* path, const GltfFile::Numbers& about,
                std::size_t size, double most, const std::vector<Number>& track,
                const std::vector<float>& times);
  /// A track of one key.
  template <typename Number>
  void still(std::size_t node, const char* path, const GltfFile::Numbers& about,
             std::span<const Number> value);
  std::size_t input(const std::vector<float>& times);
  void channel(std::size_t node, const char* path, const char* interpolation, std::size_t output);

  struct Spline {
    std::size_t node;
    const char* path;
    std::vector<float> numbers;
  };
  GltfFile& file_;
  std::map<std::size_t, std::vector<float>> translations_;
  std::map<std::size_t, std::vector<std::int16_t>> rotations_;
  std::set<std::size_t> joints_;      // whose places are kept
  std::optional<std::size_t> start_;  // the accessor of a list of one key
  GltfFile::Json channels_ = GltfFile::Json::array(), samplers_ = GltfFile::Json::array();
};

}  // namespace taut::exporting
