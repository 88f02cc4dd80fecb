#include "sim/truth/truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "sim/run/simulation.h"

namespace taut::truth {
namespace {

// s/m, the second solver's step among obstacles over the scored error: of first order, and on ropes
// of a metre off by about 0.01 m per second of step.
constexpr double kContactStep = 0.2;

// The tolerance of the second solver where connectors stretch, bend, meet the air, are joined or
// have winches.
constexpr double kMaterialTolerance = 1e-3;  // of the scored error

using Frames = std::vector<Snapshot>;

/// Frames up to the first that `enough` says no to, or that the method cannot reach.
Frames run(const World& world, std::string_view method, const Settings& settings,
           const Timeline& timeline, std::span<const double> times,
           const std::function<bool(std::size_t, const Snapshot&)>& enough) {
  Frames frames;
  Simulation simulation(world, make_method(method, settings), timeline);
  try {
    for (const double time : times) {
      simulation.advance_to(time);
      Snapshot frame = simulation.state();
      if (!enough(frames.size(), frame)) break;
      frames.push_back(std::move(frame));
    }
  } catch (const Diverged&) {
    // The frames reached are those that can be compared.
  }
  return frames;
}

/// The ends of a world's free bodies, where it has no connectors.
std::vector<std::pair<std::size_t, std::array<Vec3, 6>>> ends_of_bodies(const World& world) {
  std::vector<std::pair<std::size_t, std::array<Vec3, 6>>> ends;
  for (std::size_t b = 0; b < world.bodies.size() && world.connectors.empty(); ++b) {
    if (!world.bodies[b].driven()) ends.emplace_back(b, box_ends(world.bodies[b].bare));
  }
  return ends;
}

/// The largest distance (m) of any particle; without connectors, of the free bodies' ends.
double largest_distance(const World& world, const Snapshot& a, const Snapshot& b) {
  double largest = 0;
  for (const auto& [body, ends] : ends_of_bodies(world)) {
    for (const Vec3& end : ends) {
      const Vec3 apart = a.bodies[body].to_world(end) - b.bodies[body].to_world(end);
      largest = std::max(largest, apart.norm());
    }
  }
  for (std::size_t c = 0; c < a.connectors.size(); ++c) {
    for (std::size_t i = 0; i < a.connectors[c].size(); ++i) {
      largest = std::max(largest, (a.connectors[c][i] - b.connectors[c][i]).norm());
    }
  }
  return largest;
}

}  // namespace

World nudged(World world, double distance, bool rough) {
  const Vec3 side = Vec3(1, 2, 0.5).normalized();  // along no axis that a scene is likely to have
  for (Connector& connector : world.connectors) {
    const double last = static_cast<double>(connector.particles() - 1);
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      const double smooth = static_cast<double>(i) / last;
      connector.position[i] += distance * (rough ? (i % 2 == 0 ? 1 : -1) : smooth) * side;
    }
  }
  for (Body& body : world.bodies) {
    if (world.connectors.empty() && !body.driven()) body.position += distance * side;
  }
  place_held(world, world.time);
  return world;
}

Reference solve_truth(const World& world, std::span<const double> times,
                      const TruthOptions& options, const Timeline& timeline,
                      const std::function<void()>& tick) {
  const Settings first{{"local_error", options.local_error}};
  const Settings second{{"accuracy", options.second_accuracy}};
  Reference truth;
  Simulation simulation(world, make_method("truth", first), timeline);
  try {
    for (const double time : times) {
      simulation.advance_to(time);
      truth.frames.push_back(simulation.state());
      if (tick) tick();
    }
  } catch (const Diverged&) {
    if (truth.frames.size() < 2) throw;
  }
  const double apart = kTruthAgreement * options.scored_error;
  const auto close = [&](std::size_t frame, const Snapshot& other) {
    if (tick) tick();
    return largest_distance(world, other, truth.frames[frame]) <= apart;
  };
  std::size_t predictable = truth.frames.size();
  for (const bool rough : {false, true}) {
    const World start = nudged(world, kTruthNudge * options.scored_error, rough);
    predictable = run(start, "truth", first, timeline, times.subspan(0, predictable), close).size();
  }
  const std::span<const double> until = times.subspan(0, predictable);
  Frames checked;
  if (has_contact(world) || has_strings(world)) {
    const Settings steps{{"step", kContactStep * options.scored_error}};
    checked = run(world, "direct", steps, timeline, until, close);
  } else if (has_materials(world) || has_winches(world) || !world.joints.empty()) {
    const Settings finer{{"tolerance", kMaterialTolerance * options.scored_error}};
    checked = run(world, "direct", finer, timeline, until, close);
  } else {
    checked = run(world, "multibody", second, timeline, until, close);
  }
  if (!checked.empty()) truth.horizon = times[checked.size() - 1];
  for (std::size_t i = 0; i < checked.size(); ++i) {
    truth.self_error =
        std::max(truth.self_error, largest_distance(world, checked[i], truth.frames[i]));
  }
  return truth;
}

}  // namespace taut::truth
