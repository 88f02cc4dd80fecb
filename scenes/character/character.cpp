#include "scenes/character/character.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>
#include <vector>

#include "scenes/character/acting.h"
#include "scenes/character/cloth.h"
#include "scenes/character/hand.h"
#include "scenes/character/skeleton.h"
#include "scenes/character/track.h"
#include "sim/motion/side_by_side.h"

namespace taut::scenes {
namespace {

class Player : public Performance {
 public:
  Player(std::shared_ptr<const Model> model, const HeldStick& stick, double duration,
         const Path* head)
      : model_(std::move(model)),
        path_(stick.path),
        figure_(*model_, stick.diameter / 2),
        cues_(foresee(*path_, stick.free, duration)),
        controls_(act(figure_, *path_, duration, cues_)),
        duration_(duration),
        cloth_(*model_, figure_.skeleton()) {
    look_about(figure_, *path_, controls_, cues_);
    play_face(figure_, *path_, controls_, cues_);
    plan_arm(figure_, *path_, controls_);
    sink_to_the_feet(figure_, controls_);
    for (Eigen::Index i = 0; head && i < controls_.count(); ++i) {
      controls_.samples().col(i).segment<3>(head_yaw) += head->at(controls_.time(i)).position;
    }
  }

  std::vector<Pose> bones_at(double time) const override {
    Placement all = placed(time);
    std::call_once(has_cloth_, [&] {
      cloth_.simulate(duration_, acting_rate, [&](double t) { return placed(t); });
    });
    cloth_.hang(time, all);
    return figure_.skeleton().poses(all);
  }

  Pose limb_at(std::size_t bone, double time) const override {
    return figure_.skeleton().poses(placed(time)).at(bone);
  }

  /// How far the pelvis is from over its feet, beyond what a stance allows, and what the arm is
  /// short of even so.
  double beyond_reach(double time) const {
    constexpr double kStance = 0.45;  // m, of a figure of 1.78 m: a lunge
    const Controls c = controls_.at(time);
    const Vec3 pelvis(c[root_x], 0, c[root_z]);
    const Vec3 right(c[right_step_x], 0, c[right_step_z]), left(c[left_step_x], 0, c[left_step_z]);
    const Placement torso = figure_.skeleton().place(figure_.torso(c));
    const ArmState arm = figure_.right_arm(figure_.right_shoulder(torso), figure_.chest_turn(torso),
                                           path_->at(time).pose(), c[hand_roll], c[elbow_swivel]);
    const double off = (pelvis - (right + left) / 2).norm();
    return std::max(0.0, off - kStance * figure_.scale()) + arm.shortfall;
  }

 private:
  Placement placed(double time) const {
    return figure_.pose(controls_.at(time), path_->at(time).pose());
  }

  std::shared_ptr<const Model> model_;
  std::shared_ptr<const Path> path_;
  Figure figure_;
  Cues cues_;
  Track controls_;
  double duration_;  // s
  mutable std::once_flag has_cloth_;
  mutable HangingCloth cloth_;
};

}  // namespace

std::shared_ptr<const Performance> make_performance(std::shared_ptr<const Model> model,
                                                    const HeldStick& right_hand, double duration,
                                                    const Path* head) {
  return std::make_shared<Player>(std::move(model), right_hand, duration, head);
}

double beyond_reach(const Performance& performance, double time) {
  const auto* player = dynamic_cast<const Player*>(&performance);
  return player ? player->beyond_reach(time) : 0;
}

void check_figure(const Model& model, const HeldStick& right_hand) {
  Figure(model, right_hand.diameter / 2);
}

Path bone_path(const Performance& performance, std::size_t bone, double duration) {
  std::vector<PathKey> keys;
  for (int i = 0; keys.empty() || keys.back().time < duration; ++i) {
    const double time = i / acting_rate;
    const Pose pose = performance.limb_at(bone, time);
    keys.push_back({time, pose.position, pose.rotation});
  }
  return Path(std::move(keys));
}

// The right arm has two freedoms left once the path holds the stick: the hand may roll about it,
// and the elbow may swivel. Both are chosen by dynamic programming over the whole path on a grid of
// angles, then smoothed.

namespace {

constexpr int roll_count = 48, swivel_count = 15;  // roll all round
constexpr double roll_step = 2 * M_PI / roll_count;
constexpr double swivel_first = -28 * degree, swivel_step = 8 * degree;
constexpr int state_count = roll_count * swivel_count;
constexpr int most_roll = 3, most_swivel = 2;  // steps on the grid from one instant to the next
constexpr Eigen::Index every = 2;              // samples of the acting from one instant to the next

/// Discomfort of an arm in degrees of wrist bend squared, roughly: angles in a joint's easy range
/// cost little, those near its limit a lot.
double discomfort(const ArmState& arm, const Quat& chest, double swivel) {
  const double bend = arm.bend / degree, twist = arm.twist / degree, flexion = arm.flexion / degree;
  const Vec3 upper = chest.conjugate() * (arm.elbow - arm.shoulder).normalized();
  double cost = squared(bend) + 85 * squared(beyond(bend, 35));
  cost += 0.1 * squared(twist) + 10 * squared(beyond(std::abs(twist), 70));
  cost += 10 * squared(beyond(flexion, 130)) + 0.15 * squared(swivel / degree);
  // The elbow neither goes far behind the back, nor across the chest, nor above the shoulder.
  cost += 4e4 * (squared(beyond(-upper.z(), 0.5)) + squared(beyond(upper.x(), 0.2)) +
                 squared(beyond(upper.y(), 0.1)));
  return cost;
}

/// The least costly walk through the states; one state per instant.
std::vector<int> cheapest_walk(const std::vector<float>& cost, std::size_t instants) {
  std::vector<std::int16_t> from(cost.size());
  std::vector<float> total(cost.begin(), cost.begin() + state_count), next(state_count);
  const float roll_price = static_cast<float>(squared(roll_step / degree) * 2),
              swivel_price = static_cast<float>(squared(swivel_step / degree) * 2);
  for (std::size_t k = 1; k < instants; ++k) {
    for (int s = 0; s < state_count; ++s) {
      const int roll = s / swivel_count, swivel = s % swivel_count;
      float least = std::numeric_limits<float>::infinity();
      int best = s;
      for (int dr = -most_roll; dr <= most_roll; ++dr) {
        const int row = (roll + dr + roll_count) % roll_count * swivel_count;
        for (int w = std::max(0, swivel - most_swivel);
             w <= std::min(swivel_count - 1, swivel + most_swivel); ++w) {
          const int dw = w - swivel;
          const float price = total[static_cast<std::size_t>(row + w)] +
                              roll_price * static_cast<float>(dr * dr) +
                              swivel_price * static_cast<float>(dw * dw);
          if (price < least) {
            least = price;
            best = row + w;
          }
        }
      }
      const auto at = k * state_count + static_cast<std::size_t>(s);
      next[static_cast<std::size_t>(s)] = least + cost[at];
      from[at] = static_cast<std::int16_t>(best);
    }
    total.swap(next);
  }
  std::vector<int> walk(instants);
  walk.back() = static_cast<int>(std::min_element(total.begin(), total.end()) - total.begin());
  for (std::size_t k = instants - 1; k > 0; --k)
    walk[k - 1] = from[k * state_count + static_cast<std::size_t>(walk[k])];
  return walk;
}

/// Shifts the pelvis toward the hand where the arm, at ease, would be short of it.
void close_the_gap(const Figure& figure, const Path& path, Track& controls) {
  Track gap(Eigen::MatrixXd::Zero(3, controls.count()), controls.rate());
  for (Eigen::Index i = 0; i < controls.count(); ++i) {
    const Controls c = controls[i];
    const Placement torso = figure.skeleton().place(figure.torso(c));
    const ArmState arm =
        figure.right_arm(figure.right_shoulder(torso), figure.chest_turn(torso),
                         path.at(controls.time(i)).pose(), c[hand_roll], c[elbow_swivel]);
    const Vec3 reach = arm.wrist - arm.shoulder;
    gap.samples().col(i) = beyond(reach.norm(), 0.985 * figure.right_reach()) * reach.normalized();
  }
  // Smoothing lowers peaks; half as much again makes up for it.
  controls.samples().middleRows<3>(root_x) += 1.5 * gap.smoothed(0.06).samples();
}

}  // namespace

void plan_arm(const Figure& figure, const Path& path, Track& controls) {
  const auto instants = static_cast<std::size_t>((controls.count() - 1) / every + 1);
  std::vector<float> cost(instants * state_count);
  side_by_side(instants, [&](std::size_t k) {
    const Eigen::Index i = static_cast<Eigen::Index>(k) * every;
    const Placement torso = figure.skeleton().place(figure.torso(controls[i]));
    const Vec3 shoulder = figure.right_shoulder(torso);
    const Quat chest = figure.chest_turn(torso);
    const Pose stick = path.at(controls.time(i)).pose();
    for (int s = 0; s < state_count; ++s) {
      const double swivel = swivel_first + swivel_step * (s % swivel_count);
      const ArmState arm =
          figure.right_arm(shoulder, chest, stick, roll_step * (s / swivel_count), swivel);
      cost[k * state_count + static_cast<std::size_t>(s)] =
          static_cast<float>(discomfort(arm, chest, swivel) + 1e6 * squared(arm.shortfall));
    }
  });
  const std::vector<int> walk = cheapest_walk(cost, instants);

  Track angles(Eigen::MatrixXd(2, static_cast<Eigen::Index>(instants)),
               controls.rate() / static_cast<double>(every));
  int roll = walk[0] / swivel_count;
  for (std::size_t k = 0; k < instants; ++k) {
    // The nearer way round, so that the roll is continuous.
    const int step = walk[k] / swivel_count - (roll % roll_count + roll_count) % roll_count;
    roll += (step + 3 * roll_count / 2) % roll_count - roll_count / 2;
    angles.samples().col(static_cast<Eigen::Index>(k)) =
        Eigen::Vector2d(roll * roll_step, swivel_first + swivel_step * (walk[k] % swivel_count));
  }
  const Track smooth = angles.smoothed(0.07);
  for (Eigen::Index i = 0; i < controls.count(); ++i)
    controls.samples().col(i).segment<2>(hand_roll) = smooth.at(controls.time(i));
  close_the_gap(figure, path, controls);
}

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
