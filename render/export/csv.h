// Trajectories as tables: a row for each frame.
#pragma once

#include <optional>
#include <string>

#include "render/export/frame_writer.h"

namespace taut::exporting {

/// The names of the columns, without a line's end: t, every particle of every connector, every
/// body's own frame.
std::string csv_header(const scenes::Scene& scene);
/// The numbers below them, with as many digits as bring back the same number.
std::string csv_row(const Snapshot& state);

std::unique_ptr<FrameWriter> csv_writer(const scenes::Scene& scene, WriteBytes write);

}  // namespace taut::exporting
