#include "render/cli/check_piece.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

#include "render/cli/check_records.h"
#include "render/export/csv.h"
#include "scenes/load/warnings.h"
#include "sim/contact/capsule.h"
#include "sim/evaluation/energy_balance.h"
#include "sim/measure/measure.h"
#include "sim/motion/stop.h"
#include "sim/run/cpu_time.h"
#include "sim/run/error_estimate.h"

namespace taut::cli {
namespace {

constexpr std::size_t kMostStates = 5e7;  // bytes, of all that are sent
constexpr double kMarked = 2e-3;          // s of CPU time between two marks
constexpr double kUnsaid = 0.02;          // s of CPU time, from the last mark to the end, at most
constexpr double kFirstPart = 0x1p-10;    // of a frame
constexpr double kFirstFrame = 0.5;       // of the CPU time; one that takes more is run in parts

/// Calls visit(number) for every number of a state, in order.
template <typename State, typename Visit>
void each_number(State& state, Visit visit) {
  visit(state.time);
  for (auto& particles : state.connectors)
    for (auto& at : particles)
      for (Eigen::Index k = 0; k < 3; ++k) visit(at[k]);
  for (auto& body : state.bodies) {
    for (Eigen::Index k = 0; k < 3; ++k) visit(body.position[k]);
    for (Eigen::Index k = 0; k < 4; ++k) visit(body.rotation.coeffs()[k]);
  }
}

std::string bytes_of(const Snapshot& state) {
  std::string bytes;
  each_number(state, [&](double number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  });
  return bytes;
}

/// Back into a state of the same parts.
std::optional<Snapshot> state_of(std::string_view bytes, const Snapshot& shape) {
  Snapshot state = shape;
  bool enough = true;
  each_number(state, [&](double& number) {
    enough = enough && bytes.size() >= sizeof number;
    if (!enough) return;
    std::memcpy(&number, bytes.data(), sizeof number);
    bytes.remove_prefix(sizeof number);
  });
  if (!enough || !bytes.empty()) return std::nullopt;
  return state;
}

/// The parts that all states of the scene's simulation have.
Snapshot shape_of(const scenes::Scene& scene) {
  return snapshot(divided(scene.world, scene.timeline));
}

/// The run of taut simulate, as far as its cost goes.
class Run {
 public:
  explicit Run(const scenes::Scene& scene)
      : simulation_(scenes::start(scene)),
        estimate_(scene.world, scene.method.name, scene.method.settings, scene.timeline),
        balance_(scene.timeline) {}

  /// To a frame, which is measured and written.
  void to_frame(double time) {
    to(time);
    const World& world = std::as_const(simulation_).world();
    measured_ += balance_.next(world) + stretch_max(world) + contact::penetration_max(world);
    written_ += exporting::csv_row(simulation_.state()).size();
  }
  /// To a time between frames.
  void to(double time) {
    simulation_.advance_to(time);
    estimate_.follow(simulation_);
  }
  const Simulation& simulation() const { return simulation_; }

 private:
  Simulation simulation_;
  ErrorEstimate estimate_;
  study::EnergyBalance balance_;
  double measured_ = 0;
  std::size_t written_ = 0;
};

/// Marks of a run; what is done for them does not count as the run's.
class Marks {
 public:
  explicit Marks(const render::Say& say) : say_(say) {}

  void add(double time, bool always) {
    const double now = thread_seconds();
    if (!always && now - last_ < kMarked) return;
    last_ = now;
    tell(say_, Said::mark, {time, now - aside_, now});
  }
  void add_state(const Simulation& simulation) {
    const double before = thread_seconds();
    const std::string bytes = bytes_of(simulation.state());
    sent_ += bytes.size();
    if (sent_ <= kMostStates) tell(say_, Said::state, bytes);
    aside_ += thread_seconds() - before;
  }

 private:
  const render::Say& say_;
  double last_ = 0, aside_ = 0;
  std::size_t sent_ = 0;
};

/// Of a scene whose first frame takes too long: parts of that frame that double, whole steps where
/// all steps are equal.
void run_parts(const scenes::Scene& scene, const render::Say& say) {
  tell(say, Said::again, {thread_seconds()});
  Marks marks(say);
  Run run(scene);
  marks.add(0, true);
  const double frame = 1.0 / scene.fps, step = step_of(with_defaults(scene.method));
  double part = step > 0 ? step : kFirstPart * frame;
  for (double time = part; time < frame; time += part) {
    run.to(time);
    marks.add(time, true);
    part *= 2;
  }
}

void run_frames(const scenes::Scene& scene, double seconds, const render::Say& say) {
  Marks marks(say);
  Run run(scene);
  marks.add(0, true);
  const int every = scenes::frames_between_looks(scene);
  for (int frame = 0; frame < scene.frames(); ++frame) {
    const double time = static_cast<double>(frame) / scene.fps;
    if (frame <= 1) {
      try {
        const WorkLimit limit({.cpu_time = kFirstFrame * seconds});
        run.to_frame(time);
      } catch (const OverLimit&) {
        return run_parts(scene, say);
      }
    } else {
      run.to_frame(time);
    }
    if (frame % every == 0) marks.add_state(run.simulation());
    marks.add(time, frame == 1);
  }
  marks.add(end_of(scene), true);
}

}  // namespace

double end_of(const scenes::Scene& scene) {
  return static_cast<double>(scene.frames() - 1) / scene.fps;
}

Piece run_piece(const scenes::Scene& scene, double seconds) {
  const render::Bounded bounded =
      render::run_bounded({seconds, kCopyMemory}, [&](const render::Say& say) {
        try {
          run_frames(scene, seconds, say);
        } catch (const Diverged& error) {  // the run ends there as well
          tell(say, Said::diverged, error.what());
        } catch (const BadIntervention& error) {
          tell(say, Said::diverged, error.what());
        }
      });
  Piece piece;
  piece.next = 1.0 / scene.fps;
  const Snapshot shape = shape_of(scene);
  double used = 0;
  each_record(bounded.said, [&](Said what, std::string_view bytes) {
    if (what == Said::state) {
      if (auto state = state_of(bytes, shape)) piece.states.push_back(std::move(*state));
    } else if (what == Said::diverged) {
      piece.over = true;
      piece.diverged = bytes;
    } else if (what == Said::again) {
      piece.in_parts = true;
      piece.first_frame = numbers_of(bytes).front() - used;
      piece.marks.clear();
    } else {
      const std::vector<double> numbers = numbers_of(bytes);
      piece.marks.push_back({numbers[0], numbers[1]});
      used = numbers[2];
    }
  });
  if (bounded.end == render::Bounded::End::no_time) {
    piece.unfinished = std::max(seconds - kUnsaid - used, 0.0);
  }
  if (piece.in_parts) {
    const double step = step_of(with_defaults(scene.method));
    piece.next = piece.until() > 0 ? piece.until() : step > 0 ? step : kFirstPart / scene.fps;
  }
  return piece;
}

}  // namespace taut::cli
