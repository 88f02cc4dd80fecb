#include "sim/error_estimate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "sim/measure.h"
#include "sim/room.h"

namespace taut {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kInProportion = 0.1;   // of the motion: differences up to it
constexpr std::uint64_t kFewSteps = 4;  // from one comparison to the next: so few can be halved

CoarseMethod coarse_method(std::string_view name, const Settings& settings) {
  make_method(name, settings);  // throws what there is to say of them
  const MethodInfo& method = *find_method(name);
  if (!method.coarse) return {.none = "does not say how its error depends on its settings"};
  return method.coarse(method, with_defaults(method, settings));
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
    : length_(length_scale(world)) {
  CoarseMethod coarse = coarse_method(method, settings);
  limit_ = coarse.asked > 0 ? coarse.asked : length_ / 100;
  error_ = largest_ = coarse.method ? 0 : std::numeric_limits<double>::quiet_NaN();
  if (!coarse.method) {
    none_ = std::string(method) + " " + std::string(coarse.none);
    return;
  }
  ratio_ = coarse.ratio;
  order_ = coarse.order;
  coarse_.emplace(world, std::move(coarse.method), timeline);
  const World& stepped = coarse_->world();
  for (std::size_t b = 0; b < stepped.bodies.size(); ++b) {
    const Body& body = stepped.bodies[b];
    if (!body.driven()) ends_.push_back({b, box_ends(body.bare)});
  }
  for (Points* points : {&fine_points_, &coarse_points_, &start_points_}) {
    points->reserve(room(stepped).particles + 6 * ends_.size());
  }
}

void ErrorEstimate::follow(const Simulation& simulation) {
  if (!coarse_ || !diverged_.empty()) return;
  if (!due(simulation)) return;
  const double time = simulation.world().time;
  try {
    coarse_->advance_to(time);
  } catch (const Diverged& error) {
    diverged_ = error.what();
  } catch (const BadIntervention& error) {
    diverged_ = error.what();
  }
  if (diverged_.empty()) {
    compare(simulation);
  } else {
    note(time, kInfinite);
  }
}

/// Whether the simulation has taken steps enough since it was compared last. Where frames end
/// steps, the coarser one would take as many as the simulation, and show no difference.
bool ErrorEstimate::due(const Simulation& simulation) {
  const double time = simulation.world().time;
  const std::uint64_t steps = simulation.method().counters().steps;
  passes_frames_ = passes_frames_ || (time > time_ && steps == followed_ && !start_points_.empty());
  time_ = time;
  followed_ = steps;
  if (!passes_frames_ && !start_points_.empty() && steps < steps_ + kFewSteps) return false;
  steps_ = steps;
  return true;
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
  sample(world, fine_points_);
  sample(coarse_->world(), coarse_points_);
  if (fine_points_.size() != coarse_points_.size()) {
    throw std::invalid_argument("the simulation had interventions that its error estimate did not");
  }
  if (start_points_.empty() || topology_ != world.topology) start_points_ = fine_points_;
  topology_ = world.topology;
  travelled_ = std::max(travelled_, distance(fine_points_, start_points_));

  const double difference = distance(fine_points_, coarse_points_);
  if (!std::isfinite(difference)) {
    diverged_ = "not finite";
    return note(world.time, kInfinite);
  }
  const auto taken = static_cast<double>(coarse_->method().counters().steps);
  const double ratio =
      order_ > 0 && taken > 0 ? std::pow(static_cast<double>(steps_) / taken, order_) : ratio_;
  const bool in_proportion = difference <= kInProportion * std::min(length_, travelled_);
  note(world.time, in_proportion && ratio > 1 ? difference / (ratio - 1) : difference);
}

void ErrorEstimate::note(double time, double error) {
  error_ = error;
  largest_ = std::max(largest_, error);
  if (error > limit_ && !predictable_until_) predictable_until_ = time;
}

}  // namespace taut
