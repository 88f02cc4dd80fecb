// Scenes as animated binary glTF 2.0.
#pragma once

#include "render/export/frame_writer.h"

namespace taut::exporting {

/// Bodies, characters, connectors, scenery, cameras and the key light. A particle's node is where
/// the simulation had it: to float's rounding at every frame, and within 0.1 mm between. The scene
/// may be without a stage, but must outlive the writer. Throws BadScene where a connector has more
/// particles than a skin has joints.
std::unique_ptr<FrameWriter> glb_writer(const scenes::Scene& scene, WriteBytes write);

}  // namespace taut::exporting
