// A path: positions and orientations through keys, round a circle or about an axle, C2 in time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sim/motion/types.h"

namespace taut {

// A point that goes round a circle, its angular speed reached smoothly from rest.

/// From rest at `start` at time 0 about `centre`, right-handed about `axis`: the angular speed is
/// 2 pi frequency s(t/ramp) with the smoothstep s(u) = 3u^2 - 2u^3, and constant after the ramp.
struct Circle {
  Vec3 centre = Vec3::Zero();  // m
  Vec3 start = Vec3::UnitX();  // m; start - centre is at right angles to the axis
  Vec3 axis = Vec3::UnitZ();   // unit vector
  double frequency = 1;        // turns per second, above 0
  double ramp = 1;             // s, above 0
};

/// The motion at `time` (s), in closed form; the frame keeps the world's axes.
FrameMotion motion(const Circle& circle, double time);

/// A key of a path. `ease` has the path pass the key with `velocity` and no acceleration, at rest
/// by default; two neighbouring keys that ease and share their pose are a hold. The first and the
/// last key of a path always ease.
struct PathKey {
  double time = 0;  // s
  Vec3 position = Vec3::Zero();
  Quat rotation = Quat::Identity();
  bool ease = false;
  Vec3 velocity = Vec3::Zero();  // m/s, where it eases
};

class Path;

/// A frame that turns about its own y axis.
struct Axle {
  Vec3 position = Vec3::Zero();       // m
  Vec3 axis = Vec3::UnitZ();          // unit vector, the y axis of the frame
  std::shared_ptr<const Path> angle;  // rad, the x of its positions; right-handed
  double pitch = 0;                   // m along the axis per turn, as of a screw
};

/// Position and orientation as functions of time, twice continuously differentiable, passing
/// through every key. Before the first key and after the last the path keeps the velocity of that
/// key, which is rest unless the key says otherwise; a circle goes on.
class Path {
 public:
  /// Keys need strictly rising times; throws std::invalid_argument otherwise or when empty.
  explicit Path(std::vector<PathKey> keys);

  static Path round(const Circle& circle);
  static Path about(const Axle& axle);

  /// The same motion beside (m) and later (s); its frame keeps its directions.
  Path moved(const Vec3& by, double delay) const;

  /// The motion at `time` (s), analytic: a spline's derivatives are those of the spline, not
  /// differences.
  FrameMotion at(double time) const;

  /// Of a circle: its start, the end of its ramp, and the thirds of the turn after it; of an axle
  /// the keys of its angle. All times at which the third derivative jumps are among the keys.
  const std::vector<PathKey>& keys() const { return keys_; }

  /// A hash of the keys or the circle: paths that share it are the same motion.
  std::uint64_t fingerprint() const { return fingerprint_; }

 private:
  Path() = default;
  std::uint64_t fingerprint_ = 0;
  std::vector<PathKey> keys_;
  std::optional<Circle> circle_;
  std::optional<Axle> axle_;
  double delay_ = 0;  // s, of a circle or an axle
  // Values and their first two derivatives at the keys, 7 rows: x y z, then quaternion w x y z.
  using Row = Eigen::Matrix<double, 7, 1>;
  std::vector<Row> value_, rate_, rate2_;
  std::vector<Quat> rotation_;  // at the keys

  /// From a key to the next.
  struct Section {
    Row c3, c4, c5;      // of the quintic in the share of the way, for its powers from the third on
    bool turns = false;  // else the rotation stays
  };
  Section section(std::size_t first) const;
  std::vector<Section> sections_;
};

}  // namespace taut
