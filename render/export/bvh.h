// A character's motion as BVH.
#pragma once

#include "render/export/frame_writer.h"

namespace taut::exporting {

/// The skeleton at rest, and for every frame the place of its root (m) and the turns of its bones
/// (degrees, about z, x and y). Throws BadScene where the stage has not exactly one character, or
/// that has several roots.
std::unique_ptr<FrameWriter> bvh_writer(const scenes::Scene& scene, WriteBytes write);

}  // namespace taut::exporting
