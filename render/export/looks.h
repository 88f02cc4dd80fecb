// The looks of moving things by the scene's stage; plain where it has none.
#pragma once

#include "scenes/scene/scene.h"

namespace taut::exporting {

/// A model for each body; null: nothing is seen of it.
std::vector<std::shared_ptr<const scenes::Model>> body_models(const scenes::Scene& scene);
/// How far from its origin there is something to see of each body, m.
std::vector<double> bounding_radii(const scenes::Scene& scene);

/// Of a connector of the scene's world as it is divided().
scenes::ConnectorLook look_of(const scenes::Scene& scene, std::size_t connector);

/// A camera of the stage.
struct NamedCamera {
  std::string name;
  const std::vector<scenes::CameraKey>& keys;  // the stage's own
  double start;                                // s, from which on it is used
};
/// The stage's camera and, where they have others, those of the shots.
std::vector<NamedCamera> cameras(const scenes::Scene& scene);

/// The rotation of what looks along its own -z, its x level, as cameras and lights do.
Quat looking(const Vec3& direction);

/// Into how many parts to divide a frame to see what happens meanwhile: a method of equal steps
/// shows as many of its own as that; one that chooses its steps has to stop for each.
int parts_of_frame(const scenes::Scene& scene);

}  // namespace taut::exporting
