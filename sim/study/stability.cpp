#include "sim/study/stability.h"

#include <algorithm>
#include <cmath>

#include "sim/evaluation/accuracy.h"
#include "sim/measure/measure.h"

namespace taut::study {
namespace {

/// The lowest that potential energy (J) can get: every particle as far below a prescribed hold as
/// the links between them allow, free bodies below the particle that they hold. Not finite where
/// nothing is prescribed.
double lowest_potential(const World& world) {
  const double g = world.gravity.norm();
  if (g == 0) return 0;
  const Vec3 up = -world.gravity / g;
  double energy = 0;
  std::vector<double> body_floor(world.bodies.size(), -INFINITY);  // m, height of the lowest centre
  for (const Connector& connector : world.connectors) {
    std::vector<double> along(connector.particles(), 0.0);
    for (std::size_t i = 0; i + 1 < connector.particles(); ++i) {
      along[i + 1] = along[i] + connector.rest[i];
    }
    const auto floor_of = [&](std::size_t particle) {
      double height = -INFINITY;
      for (const Hold& hold : connector.holds) {
        if (!is_prescribed(world, hold.to)) continue;
        const double length = std::abs(along[particle] - along[hold.particle]);
        height = std::max(height, up.dot(connector.position[hold.particle]) - length);
      }
      return height;
    };
    auto hold = connector.holds.begin();
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (hold != connector.holds.end() && hold->particle == i) {
        if (hold->to.kind == Attachment::Kind::body && !world.bodies[hold->to.body].driven()) {
          const Body& body = world.bodies[hold->to.body];
          const double lever = (hold->to.point - body.mass_properties.centre).norm();
          double& floor = body_floor[hold->to.body];
          floor = std::max(floor, floor_of(i) - lever);
        }
        ++hold;
        continue;
      }
      const bool end = i == 0 || i + 1 == connector.particles();
      if (connector.model == ConnectorModel::span && !end) continue;  // carries nothing
      energy += connector.particle_mass[i] * g * floor_of(i);
    }
  }
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    if (world.bodies[b].driven()) continue;
    energy += world.bodies[b].mass_properties.mass * g * body_floor[b];
  }
  return energy;
}

bool stretches(const Connector& connector) {
  return std::ranges::any_of(connector.sections, [](const Section& section) {
    return std::isfinite(section.axial_stiffness);
  });
}

/// The largest change of a link's length in a state, as a share of its rest length.
double stretch_of(const World& world, const Snapshot& state) {
  double most = 0;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const std::vector<Vec3>& at = state.connectors[c];
    for (std::size_t k = 0; k + 1 < at.size(); ++k) {
      const double rest = world.connectors[c].rest[k];
      if (rest > 0) most = std::max(most, std::abs((at[k + 1] - at[k]).norm() / rest - 1));
    }
  }
  return most;
}

/// The stretch that is an error: all of it where links are rigid; where some stretch by their
/// material, as much as they stretch more than in the reference.
double wrong_stretch(const World& world, const Run& run, const truth::Reference* reference) {
  if (std::ranges::none_of(world.connectors, stretches)) return run.stretch_max;
  double most = 0;
  for (std::size_t k = 0; reference && k < reference->frames.size(); ++k) {
    if (k >= run.stretch.size() || reference->frames[k].time > reference->horizon) break;
    most = std::max(most, run.stretch[k] - stretch_of(world, reference->frames[k]));
  }
  return most;
}

}  // namespace

double total_length(const World& world) {
  double length = 0;
  for (const Connector& connector : world.connectors) length += connector.length;
  return length > 0 ? length : length_scale(world);
}

double available_energy(const World& world) {
  const double fall = moving_mass(world) * world.gravity.norm() * total_length(world);
  const double kinetic = kinetic_energy(world);
  const double lowest = lowest_potential(world);
  if (!std::isfinite(lowest)) return kinetic + fall;
  return std::max(kinetic + potential_energy(world) - lowest, 1e-3 * fall);
}

Classification classify(const Problem& problem, const Run& run, const truth::Reference* reference,
                        const ClassLimits& limits) {
  Classification classification;
  classification.stretch = wrong_stretch(problem.world, run, reference);
  if (is_closed(problem.world) && problem.timeline.empty()) {
    const double scale = available_energy(problem.world);
    const auto share = [scale](double energy) { return energy > 0 ? energy / scale : 0; };
    classification.gain = share(run.energy_gain);
    // Impacts and friction take energy, and so do strings that snap.
    const bool may_lose = has_contact(problem.world) || has_strings(problem.world);
    classification.loss = may_lose ? 0 : share(run.energy_loss);
  }
  if (reference) {
    const Metric metric = share_of_length(total_length(problem.world));
    classification.error =
        rms_error(run.frames, reference->frames, reference->horizon, metric.distance);
  }
  classification.motion_class = [&] {
    if (run.end == Run::End::diverged || classification.gain > limits.gain)
      return MotionClass::failed;
    if (classification.stretch > limits.stretch) return MotionClass::stretched;
    if (classification.loss > limits.loss) return MotionClass::over_damped;
    if (run.end == Run::End::over_cap) return MotionClass::over_cap;
    if (classification.error <= limits.accurate) return MotionClass::accurate;
    return MotionClass::plausible;
  }();
  return classification;
}

std::string_view name_of(MotionClass motion_class) {
  switch (motion_class) {
    case MotionClass::over_cap:
      return "over the CPU cap";
    case MotionClass::failed:
      return "failed";
    case MotionClass::stretched:
      return "stretched";
    case MotionClass::over_damped:
      return "over-damped";
    case MotionClass::accurate:
      return "accurate";
    case MotionClass::plausible:
      return "plausible";
  }
  return "";
}

}  // namespace taut::study
