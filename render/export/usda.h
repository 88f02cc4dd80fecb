// Scenes as USD in text.
#pragma once

#include "render/export/frame_writer.h"

namespace taut::exporting {

/// Connectors as BasisCurves of their particles, bodies with their meshes, cameras and the key
/// light. Time codes are frames; where something does not move straight within 0.1 mm, there are
/// more between them. The scene may be without a stage, but must outlive the writer.
std::unique_ptr<FrameWriter> usda_writer(const scenes::Scene& scene, WriteBytes write);

}  // namespace taut::exporting
