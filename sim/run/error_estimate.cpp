#include "sim/run/error_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sim/measure/measure.h"
#include "sim/topology/components.h"

namespace taut {
namespace {

/// Multiplies a number, up to its maximum; how many times as large it is now.
double raise(const MethodInfo& method, Settings& settings, std::string_view name, double times) {
  double& value = std::get<double>(settings.find(name)->second);
  const double before = value;
  value = std::min(times * value, find_setting(method, name)->maximum);
  return value / before;
}

}  // namespace

Companion with_tolerance_raised(const MethodInfo& method, Settings settings,
                                std::string_view tolerance) {
  const double asked =
      find_setting(method, tolerance)->unit == "m" ? number(settings, tolerance) : 0;
  const double ratio = raise(method, settings, tolerance, 4);
  if (ratio < 2) return {.asked = asked, .none = "has no tolerance twice as large"};
  return {.method = method.make(settings), .ratio = ratio, .asked = asked};
}

Companion with_step_doubled(const MethodInfo& method, Settings settings, double order) {
  raise(method, settings, "step", 2);
  return {.method = method.make(settings), .order = order};
}

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kInProportion = 0.1;   // of the motion: differences up to it
constexpr std::uint64_t kFewSteps = 4;  // from one comparison to the next: so few can be halved

/// All settings of the method, for `world`. Throws what there is to say of wrong ones.
Settings fitted(std::string_view name, const Settings& settings, const World& world) {
  make_method(name, settings);
  return with_defaults(*find_method(name), settings, world);
}

Companion companion_of(std::string_view name, const Settings& settings) {
  const MethodInfo& method = *find_method(name);
  if (!method.companion) return {.none = "does not say how its error depends on its settings"};
  return method.companion(method, settings);
}

/// RMS of the distances of as many points.
double distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double squares = 0;
  for (std::size_t i = 0; i < a.size(); ++i) squares += (a[i] - b[i]).squaredNorm();
  return a.empty() ? 0 : std::sqrt(squares / static_cast<double>(a.size()));
}

}  // namespace

ErrorEstimate::ErrorEstimate(const World& world, std::string_view method, const Settings& settings,
                             const Timeline& timeline)
    : companion_(companion_of(method, fitted(method, settings, world))),
      length_(length_scale(world)) {
  limit_ = companion_.asked > 0 ? companion_.asked : length_ / 100;
  error_ = largest_ = companion_.method ? 0 : std::numeric_limits<double>::quiet_NaN();
  if (!companion_.method) {
    none_ = std::string(method) + " " + std::string(companion_.none);
    return;
  }
  companion_.method->again = [name = std::string(method), all = fitted(method, settings, world)] {
    return companion_of(name, all).method;
  };
  other_.emplace(world, std::move(companion_.method), timeline);
  const World& stepped = std::as_const(*other_).world();
  for (std::size_t b = 0; b < stepped.bodies.size(); ++b) {
    const Body& body = stepped.bodies[b];
    if (!body.driven() && stepped.connectors.empty()) ends_.push_back({b, box_ends(body.bare)});
  }
  for (Points* points : {&points_, &other_points_, &start_points_}) {
    points->reserve(room(stepped).particles + 6 * ends_.size());
  }
}

void ErrorEstimate::follow(const Simulation& simulation) {
  if (!other_ || !diverged_.empty()) return;
  if (!due(simulation)) return;
  try {
    advance_companion(simulation);
  } catch (const Diverged& error) {
    diverged_ = error.what();
  } catch (const BadIntervention& error) {
    diverged_ = error.what();
  }
  if (diverged_.empty()) {
    compare(simulation);
  } else {
    note(simulation.world().time, kInfinite);
  }
}

/// Whether the simulation has taken frames or steps enough since it was compared last. Where frames
/// end steps, the companion would take as many as the simulation, and show no difference.
bool ErrorEstimate::due(const Simulation& simulation) {
  const double time = simulation.world().time;
  if (companion_.frames > 0) {
    if (time > time_) ++frames_, ++uncompared_;
    time_ = time;
    const int early = std::max(1, frames_ / 2);  // that motions show which end soon
    return start_points_.empty() || uncompared_ >= std::min(early, companion_.frames);
  }
  const std::uint64_t steps = simulation.method().counters().steps;
  passes_frames_ = passes_frames_ || (time > time_ && steps == followed_ && !start_points_.empty());
  time_ = time;
  followed_ = steps;
  if (!passes_frames_ && !start_points_.empty() && steps < steps_ + kFewSteps) return false;
  steps_ = steps;
  return true;
}

void ErrorEstimate::advance_companion(const Simulation& simulation) {
  const double from = std::as_const(*other_).world().time, until = simulation.world().time;
  if (companion_.heed) other_->tell(simulation, companion_.heed);
  const int parts = companion_.frames > 0 ? uncompared_ + 1 : 1;
  for (int i = 1; i < parts; ++i) other_->advance_to(from + (until - from) * i / parts);
  other_->advance_to(until);
  uncompared_ = 0;
}

void ErrorEstimate::sample(const World& world, Points& points) const {
  points.clear();
  for (const Connector& connector : world.connectors) {
    points.insert(points.end(), connector.position.begin(), connector.position.end());
  }
  for (const auto& [b, ends] : ends_) {
    for (const Vec3& end : ends) points.push_back(world.bodies[b].point(end));
  }
}

void ErrorEstimate::compare(const Simulation& simulation) {
  const World& world = simulation.world();
  sample(world, points_);
  sample(std::as_const(*other_).world(), other_points_);
  if (points_.size() != other_points_.size()) {
    throw std::invalid_argument("the simulation had interventions that its error estimate did not");
  }
  if (start_points_.empty() || topology_ != world.topology) start_points_ = points_;
  topology_ = world.topology;
  travelled_ = std::max(travelled_, distance(points_, start_points_));

  const double difference = distance(points_, other_points_);
  if (!std::isfinite(difference)) {
    diverged_ = "not finite";
    return note(world.time, kInfinite);
  }
  double ratio = companion_.ratio;
  if (ratio == 0) {
    const auto taken = static_cast<double>(other_->method().counters().steps);
    ratio = taken > 0 ? std::pow(static_cast<double>(steps_) / taken, companion_.order) : 1;
    ratio = std::max(ratio, 1.0);
  }
  const bool in_proportion = difference <= kInProportion * std::min(length_, travelled_);
  note(world.time, in_proportion && ratio != 1 ? difference / std::abs(ratio - 1) : difference);
}

void ErrorEstimate::note(double time, double error) {
  error_ = error;
  largest_ = std::max(largest_, error);
  if (error > limit_ && !predictable_until_) predictable_until_ = time;
}

}  // namespace taut
