#include "render/cli/check_cheaper.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "render/cli/check_records.h"
#include "render/options/needs.h"
#include "scenes/load/warnings.h"
#include "sim/measure/measure.h"
#include "sim/run/cpu_time.h"

namespace taut::cli {
namespace {

constexpr std::string_view kMethod = "xpbd";  // equal steps, each of little work
constexpr double kShortest = 1e-2;            // s of CPU time, of a look
constexpr double kLeastTime = 5e-3;           // s; less is of no account
constexpr double kDearer = 20;                // times, at least, to be worth a word
constexpr double kApart = 0.01;               // of the longest connector
constexpr double kMoved = 0.1;                // of that, at least: still, all methods agree

/// RMS distance (m) of all particles and all bodies' origins.
double distance(const Snapshot& a, const Snapshot& b) {
  double squares = 0, count = 0;
  const auto add = [&](const Vec3& one, const Vec3& other) {
    squares += (one - other).squaredNorm();
    ++count;
  };
  for (std::size_t c = 0; c < a.connectors.size(); ++c)
    for (std::size_t i = 0; i < a.connectors[c].size(); ++i)
      add(a.connectors[c][i], b.connectors[c][i]);
  for (std::size_t k = 0; k < a.bodies.size(); ++k) add(a.bodies[k].position, b.bodies[k].position);
  return count > 0 ? std::sqrt(squares / count) : 0;
}

/// The run by another method up to the piece's last state: how far it is from the piece, and its
/// cost for the whole scene. Nothing where it does not get there.
std::optional<Cheaper> compared(const scenes::Scene& scene, const MethodChoice& method,
                                const Piece& piece, double seconds) {
  const int every = scenes::frames_between_looks(scene);
  const render::Bounded bounded =
      render::run_bounded({seconds, kCopyMemory}, [&](const render::Say& say) {
        Simulation simulation = scenes::start(scene, method);
        double apart = 0;
        for (std::size_t i = 0; i < piece.states.size(); ++i) {
          simulation.advance_to(static_cast<double>(i) * every / scene.fps);
          apart = std::max(apart, distance(simulation.state(), piece.states[i]));
        }
        tell(say, Said::mark, {std::as_const(simulation).world().time, thread_seconds(), apart});
      });
  std::optional<Cheaper> found;
  each_record(bounded.said, [&](Said, std::string_view bytes) {
    const std::vector<double> numbers = numbers_of(bytes);
    if (numbers[0] > 0) {
      found = {method, numbers[1] / numbers[0] * end_of(scene), numbers[2], numbers[0]};
    }
  });
  return found;
}

}  // namespace

std::optional<Cheaper> cheaper_method(const scenes::Scene& scene, const RunTime& time,
                                      double started, const Piece& piece, double seconds) {
  const MethodInfo* info = find_method(kMethod);
  if (scene.method.name == kMethod || !info || !follows(*info, scene.world) || piece.over ||
      time.at_least || time.least < kDearer * kLeastTime) {
    return std::nullopt;
  }
  const double length = length_scale(scene.world);
  const bool moves = std::ranges::any_of(piece.states, [&](const Snapshot& state) {
    return distance(state, piece.states.front()) >= kMoved * length;
  });
  if (!moves) return std::nullopt;
  MethodChoice method{std::string(kMethod), {}};
  const double frame = 1.0 / scene.fps;
  double most = seconds;
  // With shorter and shorter steps, as long as it is cheap.
  const double own = step_of(with_defaults(*info, {}, scene.world));
  for (double steps = std::ceil(frame / own);; steps *= 4) {
    method.settings["step"] = frame / steps;
    const double before = render::children_seconds();
    auto found = compared(scene, method, piece, most);
    if (!found) return std::nullopt;
    found->seconds += started;
    if (!(kDearer * found->seconds < time.least)) return std::nullopt;
    if (found->apart <= kApart * length) return found;
    most -= render::children_seconds() - before;
    if (most < kShortest) return std::nullopt;
  }
}

std::string text_of(const Cheaper& cheaper, const RunTime& time, const scenes::Scene& scene) {
  const double step = number(cheaper.method.settings, "step");
  return fmt::format(
      "{0} takes {1}; --method {2} --step {3:.6g} takes {4} and is within {5:.2g} mm of it "
      "({6:.2g}% "
      "of the length) until {7:.2g} s, as far as they were compared",
      scene.method.name, options::time_text(time.seconds), cheaper.method.name, step,
      options::time_text(cheaper.seconds), 1e3 * cheaper.apart,
      100 * cheaper.apart / length_scale(scene.world), cheaper.until);
}

std::string what_helps(const scenes::Scene& scene, const RunTime& time) {
  constexpr double kLong = 60;  // s
  if (!time.unknown.empty() || time.least < kLong) return {};
  const Settings settings = with_defaults(scene.method);
  const auto value = [&](const char* name) { return std::get<double>(settings.at(name)); };
  std::vector<std::string> ways;
  if (settings.contains("tolerance"))
    ways.push_back(fmt::format("a tolerance above {:.3g} m", value("tolerance")));
  if (step_of(settings) > 0) ways.push_back(fmt::format("a step above {:.3g} s", value("step")));
  std::size_t particles = 0;
  for (const Connector& connector : scene.world.connectors) particles += connector.particles();
  if (particles > 0) ways.push_back(fmt::format("fewer particles than {}", particles));
  return fmt::format(
      "{} takes {} or more; what may shorten that: {} (less accurate), --no-estimate (no estimate "
      "of the error)",
      scene.method.name, options::time_text(time.least), fmt::join(ways, ", "));
}

}  // namespace taut::cli
