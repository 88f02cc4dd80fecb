// The stage of pictures where the scene's file says nothing of it.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::scenes {

/// Gives a scene that was read with its stage what its file leaves open: all of a stage; a camera
/// that has in its picture, over the whole clip, what moves; where no camera is written also a
/// cove whose floor is at the lowest point, looks by what connectors weigh, and boxes for bodies
/// without a shape. Cameras that follow something get keys that lead there. A simulation of the
/// scene finds all this and calls `tick` now and then; where a camera is written that follows
/// nothing, nothing is done. The simulation ends early where it takes much work, counted so that
/// every machine has the same camera: returns a sentence about what was left out, or nothing.
/// `changes` are those that the scene was read with. Throws BadScene.
std::string complete_stage(Scene& scene, const std::vector<SceneChange>& changes,
                           const std::function<void()>& tick);

/// Something that moves, with points around it (m).
struct Outline {
  std::string name;  // "body held"
  std::vector<Vec3> points;
};

/// The outlines of every connector and body of a scene, which must outlive this; bodies as their
/// models or their inertia have them.
class Outlines {
 public:
  explicit Outlines(const Scene& scene);
  std::vector<Outline> of(const Snapshot& state) const;

 private:
  std::vector<std::string> connectors_, bodies_;  // their names
  std::vector<Eigen::AlignedBox3d> boxes_;        // of the bodies, in their frames
};

}  // namespace taut::scenes
