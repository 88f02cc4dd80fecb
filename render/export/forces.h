// Forces and events as a table: a row for each.
#pragma once

#include <span>
#include <string>

#include "sim/run/forces.h"
#include "sim/run/method.h"

namespace taut::exporting {

/// t (s), what (tension, hold, moment, contact, or an event: taut, impulse, slack), of (the
/// connector or body), part (a particle: 3, a link: 3-4, a span: 0), with (what holds or touches
/// it), with_part, x y z (m), fx fy fz (N, on `of`; of a tension: on the first particle of its
/// link; of a clamp's moment N m), size (N; of a moment N m, of an impulse N s).
std::string forces_header();

/// The rows of a state and of the events before it.
std::string forces_rows(const World& world, const Forces& forces, std::span<const Event> events);

}  // namespace taut::exporting
