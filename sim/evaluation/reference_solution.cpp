#include "sim/evaluation/reference_solution.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <span>
#include <utility>

#include "sim/evaluation/accuracy.h"
#include "sim/evaluation/run.h"
#include "sim/measure/measure.h"
#include "sim/motion/side_by_side.h"
#include "sim/motion/stop.h"
#include "sim/topology/components.h"
#include "sim/truth/truth.h"

namespace taut::study {
namespace {

constexpr double kFiner = 1e-5;       // of the scored error: the tolerance of what is compared with
constexpr double kEvenFiner = 1e-6;   // and of what checks it
constexpr double kTruthFiner = 1e-6;  // the same for the truth, which counts by the step
constexpr double kFinest = 1e-12;     // what doubles allow
constexpr std::size_t kRuns = 4;      // the solution, two nudged ones, the check

struct Motion {
  std::vector<std::vector<Vec3>> points;  // [frame][point], m
  std::vector<double> energy;             // J, as EnergyBalance has it
  bool balanced = false;
  double most_kinetic = 0;  // J
  bool stopped = false;     // by whoever looked on
};

/// The motion as far as the method goes or `go_on`, called after each frame, says.
Motion solve(const Problem& problem, const World& world, const SamplePoints& sample_points,
             const MethodChoice& candidate, double cpu_cap,
             const std::function<bool(const Motion&, const Simulation&)>& go_on) {
  Motion motion;
  const WorkLimit limit({.cpu_time = cpu_cap});
  Simulation simulation(world, make_method(candidate.name, candidate.settings), problem.timeline);
  EnergyBalance balance(problem.timeline);
  try {
    for (const double time : problem.times) {
      simulation.advance_to(time);
      motion.points.push_back(sample_points.places(sample_points, simulation.state()));
      motion.energy.push_back(balance.next(simulation.world()));
      motion.most_kinetic = std::max(motion.most_kinetic, kinetic_energy(simulation.world()));
      motion.stopped = !go_on(motion, simulation);
      if (motion.stopped) break;
    }
  } catch (const Diverged&) {
    if (motion.points.size() < 2) throw;
  }
  motion.balanced = balance.complete();
  return motion;
}

/// The first frame in which a point of one is farther than `apart` (m) from where the other has it.
std::size_t agree(const Motion& a, const Motion& b, double apart, double& largest) {
  const std::size_t both = std::min(a.points.size(), b.points.size());
  for (std::size_t k = 0; k < both; ++k) {
    double distance = 0;
    for (std::size_t i = 0; i < a.points[k].size(); ++i) {
      distance = std::max(distance, (a.points[k][i] - b.points[k][i]).norm());
    }
    if (!(distance <= apart)) return k;
    largest = std::max(largest, distance);
  }
  return both;
}

std::vector<double> speeds_from(const Problem& problem, const Motion& motion, std::size_t first) {
  Speeds speeds;
  for (std::size_t k = first; k < std::min(motion.points.size(), problem.times.size()); ++k) {
    speeds.add(motion.points[k], k > 0 ? problem.times[k] - problem.times[k - 1] : 1);
  }
  return speeds.sorted();
}

/// By how much (J) the energies differ from frame `first` on.
double energy_difference(const Motion& a, const Motion& b, std::size_t first, bool balanced) {
  EnergyDifference difference;
  for (std::size_t k = first; k < std::min(a.energy.size(), b.energy.size()); ++k) {
    difference.add(a.energy[k] - b.energy[k]);
  }
  return balanced ? difference.largest() : difference.of_means();
}

MethodChoice direct_within(double tolerance) {
  return {"direct", {{"tolerance", std::max(kFinest, tolerance)}}};
}

World nudged_with_bodies(const World& world, double distance, bool rough) {
  World start = truth::nudged(world, distance, rough);
  for (Body& body : start.bodies) {
    if (!body.driven()) body.position += distance * Vec3(1, 2, 0.5).normalized();
  }
  place_held(start, start.time);
  return start;
}

/// The reference's statistics after the horizon.
void measure_afterwards(ReferenceSolution& reference, const Motion& motion,
                        std::span<const Motion> others, double scored_error) {
  const World& world = reference.problem.world;
  reference.closed = is_closed(world) && reference.problem.timeline.empty();
  reference.balanced = motion.balanced;
  reference.energy_scale = energy_scale(world) - kinetic_energy(world) + motion.most_kinetic;
  const std::vector<double>& times = reference.problem.times;
  reference.same_speed = scored_error / (times[1] - times[0]);
  const std::size_t first = reference.known > 0 ? reference.known - 1 : 0;
  reference.speeds = speeds_from(reference.problem, motion, first);

  double energy = 0, speeds = 0;
  std::vector<std::vector<double>> all{reference.speeds};
  for (std::size_t i = 0; i < others.size(); ++i) {
    all.push_back(speeds_from(reference.problem, others[i], first));
    energy = std::max(energy, energy_difference(motion, others[i], first, reference.balanced));
    for (std::size_t j = 0; j < i; ++j) {
      energy = std::max(energy, energy_difference(others[i], others[j], first, reference.balanced));
    }
    for (const std::vector<double>& one : all) {
      speeds = std::max(speeds, distribution_distance(one, all.back(), reference.same_speed));
    }
  }
  // The tolerance as a lift of everything and as a stretch of the whole; and, as three solutions
  // are few, a few times their differences.
  const double share = scored_error / length_scale(world);
  if (reference.energy_scale > 0) energy /= reference.energy_scale;
  const auto frames = static_cast<double>(times.size() - first);
  reference.most = {share + 4 * energy, share, 2 * speeds + 1 / std::sqrt(frames)};
}

}  // namespace

ReferenceSolution solve_reference(Problem problem, double scored_error, double most_cycles,
                                  const std::function<void(double)>& tick, double cpu_cap) {
  const auto frames = static_cast<double>(problem.times.size());
  double done = 0;
  std::mutex one_at_a_time;
  const auto look = [&](const Motion&, const Simulation&) {
    const std::lock_guard lock(one_at_a_time);
    tick(++done / (frames * kRuns));
    return true;
  };
  const auto direct = [&](double finer) { return direct_within(finer * scored_error); };
  const SamplePoints sample_points(
      problem.world,
      Simulation(problem.world, make_method("direct", {}), problem.timeline).state());
  const World starts[] = {
      problem.world, nudged_with_bodies(problem.world, truth::kTruthNudge * scored_error, false),
      nudged_with_bodies(problem.world, truth::kTruthNudge * scored_error, true)};
  Motion motions[std::size(starts)];
  side_by_side(std::size(starts), [&](std::size_t i) {
    motions[i] = solve(problem, starts[i], sample_points, direct(kFiner), cpu_cap, look);
  });
  const Motion& motion = motions[0];
  const std::span<const Motion> others = std::span(motions).subspan(1);
  ReferenceSolution reference{.problem = std::move(problem),
                              .sample_points = sample_points,
                              .points = motion.points,
                              .energy = motion.energy};
  Problem& own = reference.problem;
  own.times.resize(motion.points.size());

  // How long it is predictable.
  const double apart = truth::kTruthAgreement * scored_error;
  double ignored = 0;
  reference.known = motion.points.size();
  for (const Motion& other : others) {
    reference.known = std::min(reference.known, agree(motion, other, apart, ignored));
  }
  const MethodChoice truth{
      "truth", {{"local_error", std::clamp(kTruthFiner * scored_error, kFinest, 1e-9)}}};
  Motion check;
  if (!has_spans(own.world)) {
    try {
      check = solve(own, own.world, sample_points, truth, cpu_cap,
                    [&](const Motion& so_far, const Simulation& now) {
                      look(so_far, now);
                      return so_far.points.size() < reference.known &&
                             now.method().counters().cycles < most_cycles;
                    });
    } catch (const Diverged&) {
      // Left to the direct method.
    } catch (const OverLimit&) {
      // So is what takes it too long.
    }
  }
  reference.checked = std::min(reference.known, check.points.size());
  const std::size_t agreed = agree(motion, check, apart, reference.self_error);
  if (agreed < reference.checked) reference.known = reference.checked = agreed;
  if (reference.checked < reference.known) {
    check = solve(own, own.world, sample_points, direct(kEvenFiner), cpu_cap,
                  [&](const Motion& so_far, const Simulation& now) {
                    look(so_far, now);
                    return so_far.points.size() < reference.known;
                  });
    reference.known = std::min(reference.known, agree(motion, check, apart, reference.self_error));
  }
  measure_afterwards(reference, motion, others, scored_error);
  tick(1);
  return reference;
}

ReferenceSolution at_times(const ReferenceSolution& reference, double scored_error,
                           std::vector<double> times, const std::function<void(double)>& tick,
                           double cpu_cap) {
  std::erase_if(times, [&](double time) { return time > reference.horizon(); });
  const auto all = static_cast<double>(times.size());
  ReferenceSolution other{
      .problem = {reference.problem.world, std::move(times), reference.problem.timeline},
      .sample_points = reference.sample_points,
      .self_error = reference.self_error};
  other.points = solve(other.problem, other.problem.world, reference.sample_points,
                       direct_within(kFiner * scored_error), cpu_cap,
                       [&](const Motion& so_far, const Simulation&) {
                         tick(static_cast<double>(so_far.points.size()) / all);
                         return true;
                       })
                     .points;
  other.known = other.points.size();
  return other;
}

namespace {

/// The larger one; keeps what is no number, as if it were larger than all.
void raise(double& largest, double value) {
  if (!(value <= largest)) largest = std::isfinite(value) ? value : INFINITY;
}

}  // namespace

ComparedRun::ComparedRun(const ReferenceSolution& reference, const World& world,
                         const Timeline& timeline, const MethodChoice& candidate,
                         const Distance& distance)
    : reference_(reference),
      distance_(distance),
      simulation_(world, make_method(candidate.name, candidate.settings), timeline),
      sample_points_(world, simulation_.state()),
      balance_(timeline) {}

bool ComparedRun::next() {
  const std::vector<double>& times = reference_.problem.times;
  if (frame_ == times.size()) return false;
  const std::size_t k = frame_++;
  simulation_.advance_to(times[k]);
  const std::vector<Vec3> points =
      sample_points_.places(reference_.sample_points, simulation_.state());
  const double energy =
      reference_.goes_on() ? balance_.next(std::as_const(simulation_).world()) : 0;
  if (k < reference_.known) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      raise(error_, distance_(points[i], reference_.points[k][i], times[k]));
    }
  } else {
    energy_.add(energy - reference_.energy[k]);
    raise(stretch_, stretch_max(std::as_const(simulation_).world()));
  }
  if (k + 1 >= reference_.known) speeds_.add(points, k > 0 ? times[k] - times[k - 1] : 1);
  return true;
}

Difference ComparedRun::later() const {
  const bool over = frame_ == reference_.problem.times.size();
  Difference later{.stretch = stretch_};
  if (reference_.energy_scale > 0 && (reference_.balanced || over)) {
    later.energy =
        (reference_.balanced ? energy_.largest() : energy_.of_means()) / reference_.energy_scale;
  }
  if (over) {
    later.speeds =
        distribution_distance(speeds_.sorted(), reference_.speeds, reference_.same_speed);
  }
  return later;
}

double ComparedRun::cycles() const {
  return simulation_.method().counters().cycles;
}

}  // namespace taut::study
