// A character that moves as an animation of its file says, and what its hand carries.
#pragma once

#include <memory>

#include "scenes/character/skeleton.h"
#include "scenes/model/model.h"
#include "sim/motion/path.h"

namespace taut::scenes {

/// How an animation is played.
struct Playback {
  std::size_t animation = 0;  // index into Model::animations
  double from = 0;            // s: its time when the scene begins
  double speed = 1;           // its seconds for each of the scene's
  Pose place;                 // where the model's origin stands
};

/// The poses of the animation; before its beginning and after its end its first and last. If the
/// right hand holds a stick of that diameter (m; 0: none) and has fingers, these are closed round
/// it. Throws BadAsset when the model lacks a bone that this takes.
std::shared_ptr<const Performance> play_animation(std::shared_ptr<const Model> model,
                                                  const Playback& playback, double held_diameter);

/// The path of a stick of that diameter in the right hand, its y axis along the stick, over
/// [0, duration] (s). Throws BadAsset when the model lacks a bone that this takes.
Path held_path(const Performance& performance, const Model& model, double diameter,
               double duration);

}  // namespace taut::scenes
