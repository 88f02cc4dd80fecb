// Trajectories, forces and events as tables.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "render/export/frame_writer.h"
#include "sim/run/forces.h"
#include "sim/run/method.h"

namespace taut::exporting {

/// The names of the columns, without a line's end: t, every particle of every connector, every
/// body's own frame.
std::string csv_header(const scenes::Scene& scene);
/// The numbers below them, with as many digits as bring back the same number.
std::string csv_row(const Snapshot& state);

std::unique_ptr<FrameWriter> csv_writer(const scenes::Scene& scene, WriteBytes write);

// Forces and events as a table: a row for each.

/// A file of rows: t (s), what (tension, hold, moment, contact, or an event: taut, impulse, slack),
/// of (the connector or body), part (a particle: 3, a link: 3-4, a span: 0), with (what holds or
/// touches it), with_part, x y z (m), fx fy fz (N, on `of`; of a tension: on the first particle of
/// its link; of a clamp's moment N m), size (N; of a moment N m, of an impulse N s).
class ForceWriter {
 public:
  virtual ~ForceWriter() = default;
  /// The rows of the events before a state, and of its forces.
  void add(const World& world, const Forces& forces, std::span<const Event> events);
  virtual void finish() {}

 protected:
  struct Row {
    double time = 0;
    std::string_view what;
    Named of = {}, with = {};
    std::optional<Vec3> place = {}, force = {};
    std::optional<double> size = {};
  };
  virtual void add(const Row& row) = 0;
};

/// By the suffix of the file's name: .npz, arrays for numpy.load(), t, what, of, part, with and
/// with_part (rows), place and force (rows, 3), size (rows), NaN where there is none; .json, a list
/// of objects with the columns as keys, null where there is none; else CSV.
std::unique_ptr<ForceWriter> force_writer(std::string_view file, WriteBytes write);

}  // namespace taut::exporting
