#include "scenes/character/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/character/skeleton.h"
#include "scenes/files/files.h"
#include "sim/motion/side_by_side.h"

namespace taut::scenes {
namespace {

Quat turn(const Vec3& axis, double angle) {
  return Quat(Eigen::AngleAxisd(angle, axis));
}
const Vec3 x_axis = Vec3::UnitX(), y_axis = Vec3::UnitY(), z_axis = Vec3::UnitZ();

/// The share of the hand's twist that the forearm's bone takes over, so that the skin of the wrist
/// shares it with the skin of the elbow.
constexpr double forearm_share = 0.55;

/// The tangent of the angle by which the left hand is bent to its thumb's side.
constexpr double cocked = 0.30;

/// The turn that brings an upper lid down on the lower one, rad; and the share of the eye's that it
/// makes when the eye looks down.
constexpr double lid_closes = 0.70, lid_follows = 0.45;

/// The turns (rad) of a whole movement of the face's bones: about 4 mm of the skin, and 5 of the
/// chin.
constexpr double brow_rises = 0.065, brow_draws = 0.030, brow_tilts = 0.26;
constexpr double corner_rises = 0.085, corner_widens = 0.060, jaw_opens = 0.090;

/// A fighting stance: where the ankles stand (m, for a figure of 1.78 m) and how the feet point.
struct Stand {
  double x, z, yaw;
};
constexpr std::array<Stand, 2> stands = {Stand{0.20, -0.25, 0.95}, Stand{-0.17, 0.24, 0.20}};

/// From the ankle to the ball of the foot (m, for a figure of 1.78 m); and the share of its height
/// by which the ball of a lifted foot is lower than the ankle.
constexpr double ball = 0.14, lifted_toes = 0.6;

/// The share of a leg's reach at which its knee still bends visibly.
constexpr double not_straight = 0.995;

Mat3 square(const Vec3& first, const Vec3& second) {
  Mat3 m;
  m.col(0) = first.normalized();
  m.col(1) = (second - second.dot(m.col(0)) * m.col(0)).normalized();
  m.col(2) = m.col(0).cross(m.col(1));
  return m;
}

/// Twists a forearm by its share of the turn that the hand makes about it; the hand's whole twist.
double share_twist(Quat& lower, const Quat& hand, const Vec3& rest_along) {
  const Vec3 along = lower * rest_along.normalized();
  const double twist = twist_about(hand * lower.conjugate(), along);
  lower = turn(along, forearm_share * twist) * lower;
  return twist;
}

Quat hips_turn(const Controls& c) {
  return turn(y_axis, c[pelvis_yaw]) * turn(x_axis, c[pelvis_lean]) * turn(z_axis, -c[pelvis_tilt]);
}

}  // namespace

Figure::Figure(const Model& model, double stick_radius) : skeleton_(model) {
  check_bones(model);
  const std::array<std::string, 2> sides = {"Left", "Right"};
  for (std::size_t i = 0; i < 2; ++i) {
    const auto find = [&](const char* name) { return skeleton_.find(sides[i] + name); };
    clavicle_[i] = skeleton_.maybe(sides[i] + "Shoulder");
    arm_[i] = find("Arm");
    forearm_[i] = find("ForeArm");
    hand_[i] = find("Hand");
    thigh_[i] = find("UpLeg");
    shin_[i] = find("Leg");
    foot_[i] = find("Foot");
    eye_[i] = skeleton_.maybe(sides[i] + "Eye");
    lid_[i] = skeleton_.maybe(sides[i] + "Lid");
    brow_[i] = skeleton_.maybe(sides[i] + "Brow");
    mouth_[i] = skeleton_.maybe(sides[i] + "Mouth");
    const auto bone = [&](std::size_t a, std::size_t b) {
      return Vec3(skeleton_.rest(b) - skeleton_.rest(a));
    };
    arms_[i] = {bone(arm_[i], forearm_[i]), bone(forearm_[i], hand_[i]), z_axis};
    legs_[i] = {bone(thigh_[i], shin_[i]), bone(shin_[i], foot_[i]), -z_axis};
  }
  jaw_ = skeleton_.maybe("Jaw");
  hips_ = skeleton_.find("Hips");
  for (const char* name : {"Spine", "Spine1", "Chest"})
    if (const int bone = skeleton_.maybe(name); bone >= 0) spine_.push_back(std::size_t(bone));
  chest_ = spine_.back();
  neck_ = skeleton_.maybe("Neck");
  head_ = skeleton_.find("Head");
  between_eyes_ = Vec3(0, 0.09, 0.07) * scale();
  if (eye_[0] >= 0 && eye_[1] >= 0)
    between_eyes_ =
        (skeleton_.rest(std::size_t(eye_[0])) + skeleton_.rest(std::size_t(eye_[1]))) / 2 -
        skeleton_.rest(head_);
  hand_along_ = hand_axes(skeleton_, Side::right).along;
  left_axes_ = hand_axes(skeleton_, Side::left);
  check_size(model);
  side_by_side(2, [&](std::size_t hand) {
    if (hand == 0) grip_ = grip_stick(model, skeleton_, Side::right, stick_radius);
    if (hand == 1) left_fist_ = fist(model, skeleton_, Side::left);
  });
  grip_frame_ = square(grip_.axis, hand_along_);
}

void Figure::check_size(const Model& model) const {
  constexpr double kLeast = 0.05, kMost = 20;  // m, of the height of the hips
  const double hips = skeleton_.rest(hips_).y();
  if (!(hips >= kLeast && hips <= kMost)) {
    throw bad_asset(
        model.name,
        fmt::format("its Hips are {:.3g} m above y = 0, expected {} to {} m: feet stand "
                    "on y = 0, and scale = 0.01 makes metres of centimetres",
                    hips, kLeast, kMost));
  }
  for (std::size_t i = 0; i < 2; ++i)
    for (const auto& [limb, name] : {std::pair{arms_[i], "arm"}, {legs_[i], "leg"}})
      if (!(std::min(limb.upper.norm(), limb.lower.norm()) > 1e-4 * hips))
        throw bad_asset(model.name, fmt::format("its {} {} has a bone without length",
                                                i == 0 ? "left" : "right", name));
}

Posture Figure::torso(const Controls& c) const {
  Posture p = skeleton_.upright();
  p.shift = c.segment<3>(root_x);
  p.turn[hips_] = hips_turn(c);
  const auto joints = static_cast<double>(spine_.size());
  for (const std::size_t bone : spine_)
    p.turn[bone] = turn(y_axis, c[spine_yaw] / joints) * turn(x_axis, c[spine_lean] / joints) *
                   turn(z_axis, -c[spine_tilt] / joints);
  const auto turn_head = [&](std::size_t bone, double share) {
    p.turn[bone] = turn(y_axis, share * c[head_yaw]) * turn(x_axis, share * c[head_lean]) *
                   turn(z_axis, -share * c[head_tilt]);
  };
  if (neck_ >= 0) turn_head(std::size_t(neck_), 0.4);
  turn_head(head_, neck_ >= 0 ? 0.6 : 1);
  set_face(c, p);
  if (clavicle_[0] >= 0)
    p.turn[std::size_t(clavicle_[0])] =
        turn(y_axis, -c[left_shoulder_forward]) * turn(z_axis, c[left_shoulder_up]);
  if (clavicle_[1] >= 0)
    p.turn[std::size_t(clavicle_[1])] =
        turn(y_axis, c[right_shoulder_forward]) * turn(z_axis, -c[right_shoulder_up]);
  for (const auto& [bone, closed] : grip_.fingers) p.turn[bone] = closed;
  for (const auto& [bone, closed] : left_fist_) p.turn[bone] = closed;
  return p;
}

void Figure::set_face(const Controls& c, Posture& p) const {
  const auto set = [&](int bone, const Quat& turned) {
    if (bone >= 0) p.turn[std::size_t(bone)] = turned;
  };
  for (std::size_t i = 0; i < 2; ++i) {
    const double left = i == 0 ? 1 : -1;
    set(eye_[i], turn(y_axis, c[eye_yaw]) * turn(x_axis, c[eye_lean]));
    // An eye that looks down takes its lid along: effort narrows it no further.
    const double down = lid_follows * std::max(c[eye_lean], 0.0);
    set(lid_[i], turn(x_axis, std::max(down, c[lids] * lid_closes)));
    set(brow_[i], turn(x_axis, -brow_rises * c[brows]) *
                      turn(y_axis, -left * brow_draws * c[frown]) *
                      turn(z_axis, left * brow_tilts * c[frown]));
    set(mouth_[i],
        turn(x_axis, -corner_rises * c[smile]) * turn(y_axis, left * corner_widens * c[smile]));
  }
  set(jaw_, turn(x_axis, jaw_opens * c[jaw]));
}

Quat Figure::hand_turn(const Quat& stick, double roll) const {
  Mat3 held;  // the grip's frame in the stick's axes: y along the stick
  held << 0, std::cos(roll), std::sin(roll), 1, 0, 0, 0, std::sin(roll), -std::cos(roll);
  return stick * Quat(Mat3(held * grip_frame_.transpose()));
}

ArmState Figure::right_arm(const Vec3& shoulder, const Quat& chest, const Pose& stick, double roll,
                           double swivel) const {
  ArmState arm;
  arm.shoulder = shoulder;
  arm.hand = hand_turn(stick.rotation, roll);
  arm.wrist = stick.position - arm.hand * grip_.centre;
  const Vec3 reach = arm.wrist - shoulder;
  const Vec3 along = reach.normalized();
  // The elbow hangs down and out; positive swivel lifts it outward.
  const Vec3 down = chest * Vec3(-0.30, -1, -0.30);
  const Vec3 pole = turn(along, -swivel) * (down - down.dot(along) * along);
  const LimbTurns turns = bend_limb(arms_[1], shoulder, arm.wrist, pole);
  arm.elbow = turns.middle;
  arm.upper = turns.upper;
  arm.lower = turns.lower;
  const Vec3 forearm = arm.lower * arms_[1].lower.normalized();
  arm.twist = share_twist(arm.lower, arm.hand, arms_[1].lower);
  arm.bend = std::acos(std::clamp(forearm.dot(arm.hand * hand_along_), -1.0, 1.0));
  arm.flexion = std::acos(std::clamp(forearm.dot((arm.elbow - shoulder).normalized()), -1.0, 1.0));
  arm.shortfall = std::max(0.0, reach.norm() - arms_[1].reach());
  return arm;
}

Placement Figure::pose(const Controls& controls, const Pose& stick) const {
  Posture p = torso(controls);
  Placement placed = skeleton_.place(p);
  const double roll = controls[hand_roll], swivel = controls[elbow_swivel];
  ArmState arm = right_arm(right_shoulder(placed), chest_turn(placed), stick, roll, swivel);
  if (arm.shortfall > 0) {
    p.shift += arm.shortfall * (arm.wrist - arm.shoulder).normalized();
    placed = skeleton_.place(p);
    arm = right_arm(right_shoulder(placed), chest_turn(placed), stick, roll, swivel);
  }
  p.turn[arm_[1]] = turn_above(placed, arm_[1]).conjugate() * arm.upper;
  p.turn[forearm_[1]] = arm.upper.conjugate() * arm.lower;
  p.turn[hand_[1]] = arm.lower.conjugate() * arm.hand;
  aim_left_arm(controls, p);
  plant_feet(controls, p);
  return skeleton_.place(p);
}

void Figure::aim_left_arm(const Controls& controls, Posture& p) const {
  const Placement placed = skeleton_.place(p);
  const auto of_chest = [&](Control first) -> Vec3 {
    return placed.turn[chest_] * controls.segment<3>(first);
  };
  const Vec3 target = placed.position[chest_] + of_chest(guard_x);
  LimbTurns turns = bend_limb(arms_[0], placed.position[arm_[0]], target, of_chest(guard_elbow_x));
  // The fist goes on from the forearm, cocked a little to the thumb's side.
  const Vec3 forearm = (target - turns.middle).normalized();
  const Vec3 across = of_chest(guard_thumb_x).normalized();
  const Vec3 along = forearm + cocked * across;
  const Quat hand(square(along, across) * square(left_axes_.along, left_axes_.across).transpose());
  share_twist(turns.lower, hand, arms_[0].lower);
  p.turn[arm_[0]] = turn_above(placed, arm_[0]).conjugate() * turns.upper;
  p.turn[forearm_[0]] = turns.upper.conjugate() * turns.lower;
  p.turn[hand_[0]] = turns.lower.conjugate() * hand;
}

Vec3 Figure::ankle(const Controls& controls, std::size_t side) const {
  const Vec3 step = controls.segment<3>(side == 0 ? left_step_x : right_step_x);
  return Vec3(scale() * stands[side].x, skeleton_.rest(foot_[side]).y(), scale() * stands[side].z) +
         step;
}

double Figure::above_its_feet(const Controls& controls) const {
  Posture p = skeleton_.upright();
  p.shift = controls.segment<3>(root_x);
  p.turn[hips_] = hips_turn(controls);
  const Placement placed = skeleton_.place(p);
  double above = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3 leg = placed.position[thigh_[i]] - ankle(controls, i);
    const double reach = not_straight * legs_[i].reach();
    const double aside = std::min(std::hypot(leg.x(), leg.z()), reach);
    above = std::max(above, leg.y() - std::sqrt(reach * reach - aside * aside));
  }
  return above;
}

void Figure::plant_feet(const Controls& controls, Posture& p) const {
  const Placement placed = skeleton_.place(p);
  for (std::size_t i = 0; i < 2; ++i) {
    const Stand& stand = stands[i];
    const double lifted = controls[i == 0 ? left_step_y : right_step_y];
    // The heel leaves the floor before the toes: a lifted foot hangs by a share of its height.
    const double hangs = std::asin(std::min(lifted_toes * lifted / scale() / ball, 1.0));
    const Quat foot = turn(y_axis, stand.yaw) * turn(x_axis, hangs);
    // The knee goes where the foot points.
    const LimbTurns turns = bend_limb(legs_[i], placed.position[thigh_[i]], ankle(controls, i),
                                      turn(y_axis, stand.yaw) * Vec3(0, 0.1, 1));
    p.turn[thigh_[i]] = turn_above(placed, thigh_[i]).conjugate() * turns.upper;
    p.turn[shin_[i]] = turns.upper.conjugate() * turns.lower;
    p.turn[foot_[i]] = turns.lower.conjugate() * foot;
  }
}

}  // namespace taut::scenes
