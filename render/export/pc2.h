// Point caches, as Blender's Mesh Cache modifier reads them.
#pragma once

#include "render/export/frame_writer.h"

namespace taut::exporting {

/// The particles of all connectors, one connector after another, as points; one sample a frame.
std::unique_ptr<FrameWriter> pc2_writer(const scenes::Scene& scene, WriteBytes write);

}  // namespace taut::exporting
