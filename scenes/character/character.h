// A martial artist who holds a stick: poses worked out from the hand's path alone, so that moving
// one key of the path moves hand, arm, body and stick together.
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

}  // namespace taut::scenes
