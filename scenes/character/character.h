// Characters as functions of time: one who holds a stick, posed from the hand's path alone, so that
// a changed key moves hand, arm, body and stick together; and one who moves as an animation of its
// file says.
#pragma once

#include <memory>

#include "scenes/character/acting.h"
#include "scenes/character/skeleton.h"
#include "scenes/model/model.h"
#include "sim/motion/path.h"

namespace taut::scenes {

/// A stick in a hand. The path carries the grip's centre, on the stick's axis in the palm; its y
/// axis is the stick's and points out of the thumb's side of the hand. The hand is free to roll
/// about that axis: the roll that bends the wrist least is found from the path.
struct HeldStick {
  std::shared_ptr<const Path> path;
  double diameter = 0.028;                       // m
  std::optional<FreeStick> free = std::nullopt;  // what hangs from it
};

/// Poses of `model` over [0, duration] (s); before and after, the first and the last pose. `head`
/// turns the head beyond what the hand's path makes it do: x, y and z of its position are yaw to
/// the left, lean forward and tilt to the right (rad). Throws BadAsset when the model lacks a bone
/// that the performance moves, naming it.
std::shared_ptr<const Performance> make_performance(std::shared_ptr<const Model> model,
                                                    const HeldStick& right_hand, double duration,
                                                    const Path* head = nullptr);

/// Throws BadAsset as make_performance() does, at little cost.
void check_figure(const Model& model, const HeldStick& right_hand);

/// The path of a bone over [0, duration] (s), so that what hangs on it can be simulated.
Path bone_path(const Performance& performance, std::size_t bone, double duration);

// A character that plays an animation of its file, and the stick in its hand.

/// How an animation is played.
struct Playback {
  std::size_t animation = 0;  // index into Model::animations
  double from = 0;            // s: the animation's time at the start of the scene
  double speed = 1;           // seconds of the animation per second of the scene
  Pose place;                 // where the model's origin stands
};

/// The poses of the animation; before its start its first, after its end its last. A right hand
/// with fingers is closed around a stick of `held_diameter` (m; 0: no stick). Throws BadAsset if
/// the model lacks a bone that this needs.
std::shared_ptr<const Performance> play_animation(std::shared_ptr<const Model> model,
                                                  const Playback& playback, double held_diameter);

/// The path of a stick of that diameter in the right hand, its y axis along the stick, over
/// [0, duration] (s). Throws BadAsset when the model lacks a bone that this takes.
Path held_path(const Performance& performance, const Model& model, double diameter,
               double duration);

}  // namespace taut::scenes
