// The formats of an export: the states that a format receives, what several formats need, and a
// writer of each format.
#pragma once

#include <bit>
#include <cstring>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "scenes/scene/scene.h"
#include "sim/run/trajectory.h"

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

// Which states a motion needs that goes straight from one to the next.

/// Takes states in the order of their times. Every frame is a key, and whatever else brings the
/// straight lines within the limit of the other states.
class LinearKeys {
 public:
  static constexpr double kLimit = 5e-5;  // m

  /// `radii` tell of each body how far from its origin there is something to see, m.
  explicit LinearKeys(std::vector<double> radii) : radii_(std::move(radii)) {}

  void add(Snapshot state, bool is_frame, const std::function<void(const Snapshot&)>& key);

  double error() const { return error_; }  // the largest distance, m

 private:
  double off(const Snapshot& from, const Snapshot& to, const Snapshot& state) const;
  void divide(std::size_t from, std::size_t to, const std::function<void(const Snapshot&)>& key);

  std::vector<double> radii_;
  std::vector<Snapshot> pending_;  // from the last frame on
  double error_ = 0;
};

// The looks of moving things by the scene's stage; plain where it has none.

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

// Numbers as bytes, the lowest first.

static_assert(std::endian::native == std::endian::little, "written as they are in memory");

template <typename... Numbers>
std::string little_endian(Numbers... numbers) {
  std::string bytes;
  const auto add = [&bytes](auto number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  (add(numbers), ...);
  return bytes;
}

template <typename Number>
std::string_view bytes_of(std::span<const Number> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

// The writers of the formats; csv.h and npz.h have theirs.

/// Animated binary glTF 2.0: bodies, characters, connectors, scenery, cameras and the key light. A
/// particle's node is where the simulation had it, to float's rounding at every frame and within
/// 0.1 mm between frames. The scene needs no stage, and must outlive the writer. Throws BadScene if
/// a connector has more particles than a skin may have joints.
std::unique_ptr<FrameWriter> glb_writer(const scenes::Scene& scene, WriteBytes write);

/// A character's motion as BVH: the skeleton at rest, and for every frame the position of its root
/// (m) and the rotations of its bones (degrees, about z, x and y). Throws BadScene unless the stage
/// has exactly one character, with one root.
std::unique_ptr<FrameWriter> bvh_writer(const scenes::Scene& scene, WriteBytes write);

/// PC2 point caches, for Blender's Mesh Cache modifier: the particles of all connectors, one
/// connector after another; one sample a frame.
std::unique_ptr<FrameWriter> pc2_writer(const scenes::Scene& scene, WriteBytes write);

/// USD in text: connectors as BasisCurves of their particles, bodies with their meshes, cameras and
/// the key light. Time codes are frames, with more between them if a motion is off a straight line
/// by more than 0.1 mm. The scene needs no stage, and must outlive the writer.
std::unique_ptr<FrameWriter> usda_writer(const scenes::Scene& scene, WriteBytes write);

}  // namespace taut::exporting
