// Trajectories as tables: a row for each frame.
#pragma once

#include <optional>
#include <span>
#include <string>

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

/// t (s), what (tension, hold, moment, contact, or an event: taut, impulse, slack), of (the
/// connector or body), part (a particle: 3, a link: 3-4, a span: 0), with (what holds or touches
/// it), with_part, x y z (m), fx fy fz (N, on `of`; of a tension: on the first particle of its
/// link; of a clamp's moment N m), size (N; of a moment N m, of an impulse N s).
std::string forces_header();

/// The rows of a state and of the events before it.
std::string forces_rows(const World& world, const Forces& forces, std::span<const Event> events);

}  // namespace taut::exporting
