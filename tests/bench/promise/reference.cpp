#include "tests/bench/promise/reference.h"

#include <algorithm>
#include <cmath>

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/run/simulation.h"
#include "sim/truth/truth.h"

namespace taut::promise {
namespace {

constexpr double kLocalError =
    1e-12;                         // of the length; least growths leave it below every tolerance
constexpr double kFinest = 1e-15;  // m, the least that the solver takes
constexpr int kSlices = 16;        // of a frame, between two looks at the clock

double distance(const Vec3& a, const Vec3& b, double) {
  return (a - b).norm();
}

/// The world with its particles moved, and its free bodies: turned by what moves their radius of
/// gyration as far or, `rough`, moved.
World twin(World world, double distance, bool rough) {
  const Vec3 side = Vec3(2, -1, 0.5).normalized();  // across what particles are moved along
  for (Body& body : world.bodies) {
    const MassProperties& properties = body.mass_properties;
    const double radius = std::sqrt(properties.inertia.trace() / 2 / properties.mass);
    if (rough) {
      body.position += distance * side;
    } else {
      body.rotation = Quat(Eigen::AngleAxisd(distance / radius, side)) * body.rotation;
    }
  }
  return truth::nudged(std::move(world), distance, rough);
}

/// Whether something of the timeline happens after `from`, until `until`.
bool happens(const Timeline& timeline, double from, double until) {
  const auto is_in = [&](double time) { return time > from && time <= until; };
  return std::ranges::any_of(timeline.cuts, is_in, &TimedCut::time) ||
         std::ranges::any_of(timeline.pins, [&](const TimedPin& pin) {
           return is_in(pin.from) || is_in(pin.until);
         });
}

}  // namespace

Reference make_reference(const Drawn& drawn, double cap) {
  return make_reference({drawn.world, study::frame_times(kDuration, kFps)}, drawn.length, cap);
}

Reference make_reference(const study::Problem& problem, double length, double cap) {
  const double nudge = kNudge * length;
  const Settings settings{{"local_error", std::max(kFinest, kLocalError * length)}};
  const auto made = [&](World world) {
    return Simulation(std::move(world), make_method("truth", settings), problem.timeline);
  };
  Simulation truth = made(problem.world);
  Simulation smooth = made(twin(problem.world, nudge, false));
  Simulation rough = made(twin(problem.world, nudge, true));
  Reference reference;
  const double start = thread_seconds();
  double before = 0;
  try {
    for (const double time : problem.times) {
      for (int slice = 1; slice <= kSlices; ++slice) {
        const double until = slice == kSlices ? time : before + (time - before) * slice / kSlices;
        const double from = truth.world().time;
        for (Simulation* simulation : {&truth, &smooth, &rough}) simulation->advance_to(until);
        // A pin takes away what twins differ by beside it, and makes links of its own.
        if (happens(problem.timeline, from, until)) {
          smooth.world() = twin(smooth.world(), nudge, false);
          rough.world() = twin(rough.world(), nudge, true);
        }
        reference.cpu = thread_seconds() - start;
        if (reference.cpu > cap) {
          reference.end = Reference::End::over_cap;
          return reference;
        }
      }
      before = time;
      Snapshot frame = truth.state();
      const double parted = std::max(study::frame_error(smooth.state(), frame, distance),
                                     study::frame_error(rough.state(), frame, distance)) /
                            nudge;
      if (parted > kGrowth) break;
      frame.bodies.clear();
      reference.frames.push_back(std::move(frame));
      reference.growth = parted;
    }
  } catch (const Diverged&) {
    reference.end = Reference::End::failed;
  } catch (const BadIntervention&) {
    reference.end = Reference::End::failed;
  }
  return reference;
}

}  // namespace taut::promise
