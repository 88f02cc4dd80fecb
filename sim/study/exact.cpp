#include "sim/study/exact.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <mutex>
#include <span>

#include "sim/measure.h"
#include "sim/span.h"
#include "sim/study/energy_balance.h"
#include "sim/study/likeness.h"
#include "sim/study/side_by_side.h"
#include "sim/truth/truth.h"

namespace taut {
namespace {

constexpr double kNudge = 1e-4;       // of the scored error
constexpr double kCloser = 1e-2;      // of it: how far apart solutions may be
constexpr double kFiner = 1e-5;       // of it: the tolerance of what is compared with
constexpr double kEvenFiner = 1e-6;   // and of what checks it
constexpr double kTruthFiner = 1e-6;  // the same for the truth, which counts by the step
constexpr double kFinest = 1e-12;     // what doubles allow
constexpr std::size_t kRuns = 4;      // the solution, two nudged ones, the check

struct Motion {
  std::vector<std::vector<Vec3>> points;  // [frame][mark], m
  std::vector<double> energy;             // J, as EnergyBalance has it
  bool balanced = false;
  double most_kinetic = 0;  // J
  bool stopped = false;     // by whoever looked on
};

/// The motion as far as the method goes or `go_on`, called after each frame, says.
Motion solve(const Problem& problem, const World& world, const Marks& marks,
             const Candidate& candidate,
             const std::function<bool(const Motion&, const Simulation&)>& go_on) {
  Motion motion;
  Simulation simulation(world, make_method(candidate.method, candidate.settings), problem.timeline);
  EnergyBalance balance(problem.timeline);
  try {
    for (const double time : problem.times) {
      simulation.advance_to(time);
      motion.points.push_back(marks.places(marks, simulation.state()));
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

Candidate direct_within(double tolerance) {
  return {"direct", {{"tolerance", std::max(kFinest, tolerance)}}};
}

World nudged_with_bodies(const World& world, double distance, bool rough) {
  World start = nudged(world, distance, rough);
  for (Body& body : start.bodies) {
    if (!body.driven()) body.position += distance * Vec3(1, 2, 0.5).normalized();
  }
  place_held(start, start.time);
  return start;
}

/// What counts after the horizon.
void judge_later(Exact& exact, const Motion& motion, std::span<const Motion> others,
                 double scored_error) {
  const World& world = exact.problem.world;
  exact.closed = is_closed(world) && exact.problem.timeline.empty();
  exact.balanced = motion.balanced;
  exact.energy_scale = energy_scale(world) - kinetic_energy(world) + motion.most_kinetic;
  const std::vector<double>& times = exact.problem.times;
  exact.same_speed = scored_error / (times[1] - times[0]);
  const std::size_t first = exact.known > 0 ? exact.known - 1 : 0;
  exact.speeds = speeds_from(exact.problem, motion, first);

  double energy = 0, speeds = 0;
  std::vector<std::vector<double>> all{exact.speeds};
  for (std::size_t i = 0; i < others.size(); ++i) {
    all.push_back(speeds_from(exact.problem, others[i], first));
    energy = std::max(energy, energy_difference(motion, others[i], first, exact.balanced));
    for (std::size_t j = 0; j < i; ++j) {
      energy = std::max(energy, energy_difference(others[i], others[j], first, exact.balanced));
    }
    for (const std::vector<double>& one : all) {
      speeds = std::max(speeds, distribution_distance(one, all.back(), exact.same_speed));
    }
  }
  // What lifts everything by the tolerance, and stretches the whole by it; and, as three solutions
  // are few, a few times what they differ by.
  const double share = scored_error / length_scale(world);
  if (exact.energy_scale > 0) energy /= exact.energy_scale;
  const auto frames = static_cast<double>(times.size() - first);
  exact.most = {share + 4 * energy, share, 2 * speeds + 1 / std::sqrt(frames)};
}

}  // namespace

Exact solve_exactly(Problem problem, double scored_error, double most_work,
                    const std::function<void(double)>& tick) {
  const auto frames = static_cast<double>(problem.times.size());
  double done = 0;
  std::mutex one_at_a_time;
  const auto look = [&](const Motion&, const Simulation&) {
    const std::lock_guard lock(one_at_a_time);
    tick(++done / (frames * kRuns));
    return true;
  };
  const auto direct = [&](double finer) { return direct_within(finer * scored_error); };
  const Marks marks(problem.world,
                    Simulation(problem.world, make_method("direct", {}), problem.timeline).state());
  const World starts[] = {problem.world,
                          nudged_with_bodies(problem.world, kNudge * scored_error, false),
                          nudged_with_bodies(problem.world, kNudge * scored_error, true)};
  Motion motions[std::size(starts)];
  side_by_side(std::size(starts), [&](std::size_t i) {
    motions[i] = solve(problem, starts[i], marks, direct(kFiner), look);
  });
  const Motion& motion = motions[0];
  const std::span<const Motion> others = std::span(motions).subspan(1);
  Exact exact{.problem = std::move(problem),
              .marks = marks,
              .points = motion.points,
              .energy = motion.energy};
  Problem& own = exact.problem;
  own.times.resize(motion.points.size());

  // How long it can be foretold.
  const double apart = kCloser * scored_error;
  double ignored = 0;
  exact.known = motion.points.size();
  for (const Motion& other : others) {
    exact.known = std::min(exact.known, agree(motion, other, apart, ignored));
  }
  const Candidate truth{"truth",
                        {{"local_error", std::clamp(kTruthFiner * scored_error, kFinest, 1e-9)}}};
  Motion check;
  if (!has_spans(own.world)) {
    try {
      check = solve(own, own.world, marks, truth, [&](const Motion& so_far, const Simulation& now) {
        look(so_far, now);
        return so_far.points.size() < exact.known && now.method().counters().work < most_work;
      });
    } catch (const Diverged&) {
      // Left to the direct method.
    }
  }
  exact.checked = std::min(exact.known, check.points.size());
  const std::size_t agreed = agree(motion, check, apart, exact.self_error);
  if (agreed < exact.checked) exact.known = exact.checked = agreed;
  if (exact.checked < exact.known) {
    check = solve(own, own.world, marks, direct(kEvenFiner),
                  [&](const Motion& so_far, const Simulation& now) {
                    look(so_far, now);
                    return so_far.points.size() < exact.known;
                  });
    exact.known = std::min(exact.known, agree(motion, check, apart, exact.self_error));
  }
  judge_later(exact, motion, others, scored_error);
  tick(1);
  return exact;
}

Exact at_times(const Exact& exact, double scored_error, std::vector<double> times,
               const std::function<void(double)>& tick) {
  std::erase_if(times, [&](double time) { return time > exact.horizon(); });
  const auto all = static_cast<double>(times.size());
  Exact other{.problem = {exact.problem.world, std::move(times), exact.problem.timeline},
              .marks = exact.marks,
              .self_error = exact.self_error};
  other.points =
      solve(other.problem, other.problem.world, exact.marks, direct_within(kFiner * scored_error),
            [&](const Motion& so_far, const Simulation&) {
              tick(static_cast<double>(so_far.points.size()) / all);
              return true;
            })
          .points;
  other.known = other.points.size();
  return other;
}

}  // namespace taut
