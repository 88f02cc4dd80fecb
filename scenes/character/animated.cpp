#include "scenes/character/animated.h"

#include <algorithm>
#include <optional>

#include "scenes/character/acting.h"
#include "scenes/character/hand.h"

namespace taut::scenes {
namespace {

/// The numbers of a track at a time of its own.
Eigen::Vector4d value_at(const BoneTrack& track, double time) {
  using Between = BoneTrack::Between;
  const std::size_t size = track.size();
  const auto number = [&](std::size_t key, std::size_t part) {
    const std::size_t first = track.between == Between::cubic ? 3 * key + part : key;
    Eigen::Vector4d value = Eigen::Vector4d::Zero();
    for (std::size_t e = 0; e < size; ++e)
      value[Eigen::Index(e)] = double{track.values[first * size + e]};
    return value;
  };
  const auto after = std::ranges::upper_bound(track.times, time);
  if (after == track.times.begin()) return number(0, 1);
  const auto k = std::size_t(after - track.times.begin()) - 1;
  if (after == track.times.end() || track.between == Between::step) return number(k, 1);
  const double span = track.times[k + 1] - track.times[k];  // above 0, as the next is after `time`
  const double u = (time - track.times[k]) / span;
  if (track.between == Between::cubic) {
    const double u2 = u * u, u3 = u2 * u;
    return (2 * u3 - 3 * u2 + 1) * number(k, 1) + span * (u3 - 2 * u2 + u) * number(k, 2) +
           (3 * u2 - 2 * u3) * number(k + 1, 1) + span * (u3 - u2) * number(k + 1, 0);
  }
  const Eigen::Vector4d from = number(k, 0), to = number(k + 1, 0);
  if (track.of == BoneTrack::Of::position) return (1 - u) * from + u * to;
  return Quat(from).normalized().slerp(u, Quat(to).normalized()).coeffs();
}

class Animated : public Performance {
 public:
  Animated(std::shared_ptr<const Model> model, const Playback& playback, double held_diameter)
      : model_(std::move(model)), playback_(playback), skeleton_(*model_) {
    if (held_diameter > 0 && has_fingers(skeleton_, Side::right))
      fingers_ = grip_stick(*model_, skeleton_, Side::right, held_diameter / 2).fingers;
  }

  std::vector<Pose> bones_at(double time) const override {
    std::vector<Pose> poses;
    for (const Bone& bone : model_->bones) poses.push_back(bone.rest);
    const double at = playback_.from + playback_.speed * time;
    for (const BoneTrack& track : model_->animations[playback_.animation].tracks) {
      const Eigen::Vector4d value = value_at(track, at);
      Pose& pose = poses[track.bone];
      if (track.of == BoneTrack::Of::position) pose.position = value.head<3>();
      if (track.of == BoneTrack::Of::rotation && !value.isZero()) pose.rotation = Quat(value);
    }
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const int parent = model_->bones[i].parent;
      const Pose& above = parent < 0 ? playback_.place : poses[std::size_t(parent)];
      poses[i] = {above.position + above.rotation * poses[i].position,
                  (above.rotation * poses[i].rotation).normalized()};
    }
    for (const auto& [bone, turn] : fingers_) close(bone, turn, poses);
    return poses;
  }

 private:
  /// Turns a bone of a finger against what it hangs on, which is at its place already.
  void close(std::size_t bone, const Quat& turn, std::vector<Pose>& poses) const {
    const int parent = model_->bones[bone].parent;
    if (parent < 0) return;
    const auto above = std::size_t(parent);
    const Quat of_above = poses[above].rotation * skeleton_.rest_rotation(above).conjugate();
    poses[bone] = {
        poses[above].position + of_above * (skeleton_.rest(bone) - skeleton_.rest(above)),
        of_above * turn * skeleton_.rest_rotation(bone)};
  }

  std::shared_ptr<const Model> model_;
  Playback playback_;
  Skeleton skeleton_;
  FingerTurns fingers_;  // parents first
};

}  // namespace

std::shared_ptr<const Performance> play_animation(std::shared_ptr<const Model> model,
                                                  const Playback& playback, double held_diameter) {
  return std::make_shared<Animated>(std::move(model), playback, held_diameter);
}

Path held_path(const Performance& performance, const Model& model, double diameter,
               double duration) {
  const Skeleton skeleton(model);
  const std::size_t hand = skeleton.find("RightHand");
  const Grip grip = grip_stick(model, skeleton, Side::right, diameter / 2);
  const Vec3 along = hand_axes(skeleton, Side::right).along;
  Mat3 stick;  // its axes at rest
  stick.col(1) = grip.axis;
  const Vec3 aside = along - along.dot(grip.axis) * grip.axis;
  stick.col(0) = aside.norm() > 1e-9 ? aside.normalized() : grip.axis.unitOrthogonal();
  stick.col(2) = stick.col(0).cross(stick.col(1));
  std::vector<PathKey> keys;
  for (int i = 0; keys.empty() || keys.back().time < duration; ++i) {
    const double time = i / acting_rate;
    const Pose pose = performance.limb_at(hand, time);
    const Quat turn = pose.rotation * skeleton.rest_rotation(hand).conjugate();
    keys.push_back({time, pose.position + turn * grip.centre, turn * Quat(stick)});
  }
  return Path(std::move(keys));
}

}  // namespace taut::scenes
