// The input of every format of an export, and the sink of its bytes.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "scenes/scene/scene.h"

namespace taut::exporting {

/// Takes an export's bytes, in order.
using WriteBytes = std::function<void(std::string_view)>;

/// A state of a simulation.
struct ExportState {
  bool frame = true;  // else it lies between two frames
  Snapshot state;
  std::vector<std::vector<Vec3>> velocities;  // [connector][particle], m/s; at frames
};

/// A format's figures on a file: names that end with a unit, and numbers.
using Figures = std::vector<std::pair<std::string, std::variant<std::size_t, double>>>;

/// A format. One scene's states come in the order of their times, the first and the last at frames.
class FrameWriter {
 public:
  virtual ~FrameWriter() = default;
  /// Into how many parts it wants a frame's time divided; 0: it wants nothing but the times.
  virtual int states_per_frame() const { return 1; }
  virtual void add(const ExportState& state) = 0;
  virtual void finish() = 0;
  virtual Figures figures() const { return {}; }
};

/// Simulates the scene and gives the writer its states, then finishes it; calls `tick` with the
/// number of frames that are done. Frames are those of a simulation that stops at nothing else.
void play(const scenes::Scene& scene, FrameWriter& writer, const std::function<void(int)>& tick);

}  // namespace taut::exporting
