// Trajectories as arrays, as numpy.load() reads them.
#pragma once

#include "render/export/frame_writer.h"

namespace taut::exporting {

/// An archive of arrays of float64, a row for each frame: `times`; for every connector
/// `connectors/NAME/positions` and `connectors/NAME/velocities` (frames, particles, 3); for every
/// body `bodies/NAME/positions` (frames, 3), of its own frame, and `bodies/NAME/rotations`
/// (frames, 4), quaternions w, x, y, z.
std::unique_ptr<FrameWriter> npz_writer(const scenes::Scene& scene, WriteBytes write);

}  // namespace taut::exporting
