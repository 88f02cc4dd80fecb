#include "sim/truth/truth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "sim/motion/stop.h"
#include "sim/run/simulation.h"

namespace taut::truth {
namespace {

// s/m, the second solver's step among obstacles over the scored error: of first order, and on ropes
// of a metre off by about 0.01 m per second of step.
constexpr double kContactStep = 0.2;

// The tolerance of the second solver where connectors stretch, bend, meet the air, are joined or
// have winches.
constexpr double kMaterialTolerance = 1e-3;  // of the scored error

// How often the second solver's step is halved until it agrees to the end; in vain: until it agrees
// no longer than before, so often in a row.
constexpr int kHalvings = 5, kInVain = 2;

constexpr double kSteppedAgreement = 0.1;  // of the scored error

using Frames = std::vector<Snapshot>;

struct Solver {
  std::string_view method;
  Settings settings;
};

struct Solution {
  Frames frames;
  std::optional<Diverged> end;  // why there are no more
};

/// Frames up to the first that `enough` says no to, that comes after the cap, or that the method
/// cannot reach.
Solution run(const World& world, const Solver& solver, const Timeline& timeline,
             std::span<const double> times, double cpu_cap,
             const std::function<bool(std::size_t, const Snapshot&)>& enough) {
  Solution solution;
  Simulation simulation(world, make_method(solver.method, solver.settings), timeline);
  const WorkLimit limit({.cpu_time = cpu_cap});
  try {
    for (const double time : times) {
      simulation.advance_to(time);
      Snapshot frame = simulation.state();
      if (!enough(solution.frames.size(), frame)) break;
      solution.frames.push_back(std::move(frame));
    }
  } catch (const OverLimit&) {
    if (!limit.reached()) throw;
  } catch (const Diverged& end) {
    solution.end = end;
  }
  return solution;
}

/// The second solver, which shares as little with the first as one that follows the world can.
Solver second_solver(const World& world, const TruthOptions& options) {
  if (has_contact(world) || has_strings(world)) {
    return {"direct", {{"step", kContactStep * options.scored_error}}};
  }
  if (follows(*find_method("multibody"), world)) {
    return {"multibody", {{"accuracy", options.second_accuracy}}};
  }
  return {"direct", {{"tolerance", kMaterialTolerance * options.scored_error}}};
}

/// The same with a step half as long; false where the solver has none.
bool halve_step(Solver& solver) {
  const auto step = solver.settings.find("step");
  if (step == solver.settings.end()) return false;
  std::get<double>(step->second) /= 2;
  return true;
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

/// Sets the horizon where `other` is farther than `apart` (m) from the truth, and the self-error.
void compare(const World& world, const Frames& other, std::span<const double> times, double apart,
             Reference& truth) {
  for (std::size_t i = 0; i < other.size(); ++i) {
    const double distance = largest_distance(world, other[i], truth.frames[i]);
    if (!(distance <= apart)) break;
    truth.horizon = times[i];
    truth.self_error = std::max(truth.self_error, distance);
  }
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
  const Solver first{"truth", {{"local_error", options.local_error}}};
  Solution solution =
      run(world, first, timeline, times, options.cpu_cap, [&](std::size_t, const Snapshot&) {
        if (tick) tick();
        return true;
      });
  if (solution.end && solution.frames.size() < 2) throw *solution.end;
  Reference truth{.frames = std::move(solution.frames)};
  const double apart = kTruthAgreement * options.scored_error;
  std::span<const double> until = times.first(truth.frames.size());
  const auto agree = [&](const World& start, const Solver& solver) {
    return run(start, solver, timeline, until, options.cpu_cap,
               [&](std::size_t frame, const Snapshot& other) {
                 if (tick) tick();
                 return largest_distance(world, other, truth.frames[frame]) <= apart;
               })
        .frames;
  };
  for (const bool rough : {false, true}) {
    if (!options.nudges) break;
    const World start = nudged(world, kTruthNudge * options.scored_error, rough);
    until = until.first(agree(start, first).size());
  }
  Solver second = second_solver(world, options);
  std::size_t longest = 0;
  for (int halvings = 0, in_vain = 0; halvings <= kHalvings && in_vain < kInVain; ++halvings) {
    const Frames checked = agree(world, second);
    in_vain = checked.size() > longest ? 0 : in_vain + 1;
    if (checked.size() > longest || halvings == 0) {
      longest = checked.size();
      truth.horizon = truth.self_error = 0;
      compare(world, checked, times, apart, truth);
    }
    if (longest == until.size() || !halve_step(second)) break;
  }
  return truth;
}

Reference stepped_reference(const World& world, std::span<const double> times, double step,
                            double scored_error, const Timeline& timeline,
                            const std::function<void()>& tick) {
  const auto solve = [&](double of_step) {
    constexpr double kCap = 600;  // s
    Solution solution = run(world, {"direct", {{"step", of_step}}}, timeline, times, kCap,
                            [&](std::size_t, const Snapshot&) {
                              if (tick) tick();
                              return true;
                            });
    if (solution.end && solution.frames.size() < 2) throw *solution.end;
    return std::move(solution.frames);
  };
  Reference reference{.frames = solve(step)};
  Frames twice = solve(2 * step);
  twice.resize(std::min(twice.size(), reference.frames.size()));
  compare(world, twice, times, kSteppedAgreement * scored_error, reference);
  return reference;
}

}  // namespace taut::truth
