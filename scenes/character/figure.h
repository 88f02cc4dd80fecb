// A human figure: its bones by name, and whole poses from a few numbers.
#pragma once

#include <array>
#include <vector>

#include "scenes/character/hand.h"
#include "scenes/character/skeleton.h"

namespace taut::scenes {

/// The controls of a figure. Angles in rad; yaw turns the figure to its left, lean bends it
/// forward, tilt to its right. Lengths in m.
enum Control {
  root_x,
  root_y,
  root_z,  // of the pelvis, from its rest
  pelvis_yaw,
  pelvis_lean,
  pelvis_tilt,
  spine_yaw,
  spine_lean,
  spine_tilt,  // shared by the three joints of the spine
  right_shoulder_forward,
  right_shoulder_up,
  left_shoulder_forward,
  left_shoulder_up,
  head_yaw,
  head_lean,
  head_tilt,  // shared by neck and head
  eye_yaw,
  eye_lean,  // of both eyes against the head
  lids,      // how far the upper lids are down: 0 open, 1 closed
  brows,     // raised; negative: lowered
  frown,     // their inner ends down
  smile,     // the corners of the mouth up and back
  jaw,       // the mouth open
  right_step_x,
  right_step_y,
  right_step_z,
  left_step_x,
  left_step_y,
  left_step_z,  // of the feet, from their stands
  guard_x,
  guard_y,
  guard_z,  // of the left wrist's place, from the chest
  guard_elbow_x,
  guard_elbow_y,
  guard_elbow_z,  // the side to which the left elbow bends
  guard_thumb_x,
  guard_thumb_y,
  guard_thumb_z,  // the side to which the left thumb is
  hand_roll,      // of the right hand about the stick
  elbow_swivel,   // of the right elbow about the line from shoulder to wrist
  control_count
};
using Controls = Eigen::Matrix<double, control_count, 1>;

/// The right arm at one instant.
struct ArmState {
  Vec3 shoulder, elbow, wrist;  // m
  Quat upper, lower, hand;      // turns
  double bend = 0;              // of the wrist: angle between forearm and hand, rad
  double twist = 0;             // of the hand about the forearm, thumb inward positive, rad
  double flexion = 0;           // of the elbow, 0 when straight, rad
  double shortfall = 0;         // m, by which the arm is too short
};

class Figure {
 public:
  /// `stick_radius` in m. Throws BadAsset when the model lacks bones that it needs.
  Figure(const Model& model, double stick_radius);

  /// Pelvis, spine, head, eyes, shoulders and hands; legs and arms as at rest.
  Posture torso(const Controls& controls) const;
  /// Where the right arm begins in that posture, and how its chest is turned.
  Vec3 right_shoulder(const Placement& torso) const { return torso.position[arm_[1]]; }
  const Quat& chest_turn(const Placement& torso) const { return torso.turn[chest_]; }

  /// The turn of the right hand that holds a stick of that orientation (its y axis) with that roll.
  Quat hand_turn(const Quat& stick, double roll) const;
  /// The arm that brings the grip's centre to `stick.position`.
  ArmState right_arm(const Vec3& shoulder, const Quat& chest, const Pose& stick, double roll,
                     double swivel) const;
  /// Every bone, with the grip's centre exactly at the stick's: where the arm is too short, the
  /// pelvis carries the body over.
  Placement pose(const Controls& controls, const Pose& stick) const;

  /// By how much (m) the pelvis has to sink before both legs reach the floor.
  double above_its_feet(const Controls& controls) const;

  const Skeleton& skeleton() const { return skeleton_; }
  const Grip& grip() const { return grip_; }
  /// Height of the pelvis over that of a figure of 1.78 m: lengths of the acting scale with it.
  double scale() const { return skeleton_.rest(hips_).y() / 0.965; }
  double right_reach() const { return arms_[1].reach(); }
  std::size_t head_bone() const { return head_; }
  /// Half way between the eyes at rest, from the head's joint (m).
  const Vec3& between_eyes() const { return between_eyes_; }

 private:
  void set_face(const Controls& controls, Posture& posture) const;
  void aim_left_arm(const Controls& controls, Posture& posture) const;
  Vec3 ankle(const Controls& controls, std::size_t side) const;
  void plant_feet(const Controls& controls, Posture& posture) const;

  Skeleton skeleton_;
  Grip grip_;
  FingerTurns left_fist_;
  /// The turn of what a bone hangs on.
  Quat turn_above(const Placement& placed, std::size_t bone) const {
    const int above = skeleton_.parent(bone);
    return above < 0 ? Quat::Identity() : placed.turn[std::size_t(above)];
  }
  /// Throws BadAsset where a limb has no length, or the feet do not stand on y = 0.
  void check_size(const Model& model) const;

  // By side, left then right.
  std::array<std::size_t, 2> arm_, forearm_, hand_, thigh_, shin_, foot_;
  std::array<int, 2> clavicle_, eye_, lid_, brow_, mouth_;  // -1 where the model has none
  std::vector<std::size_t> spine_;                          // upwards
  int neck_, jaw_;                                          // -1 where the model has none
  std::size_t hips_, chest_, head_;
  Vec3 between_eyes_;
  std::array<Limb, 2> arms_, legs_;
  Mat3 grip_frame_;  // columns: stick's axis, hand's direction square to it, their cross; at rest
  Vec3 hand_along_;  // at rest
  HandAxes left_axes_;
};

}  // namespace taut::scenes
