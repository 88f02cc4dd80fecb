// Whether the ends of connectors stay within their reach of each other, as far as what holds them
// tells beforehand.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/reader/reader.h"
#include "scenes/reader/repeats.h"

namespace taut {
namespace {

constexpr double kRounding = 1e-6;  // of the length
constexpr double kLook = 1e-3;      // s; no hand moves a millimetre in less
constexpr double kLooks = 100'000;  // at most, for scenes of many minutes

/// The two ends where both move as is known beforehand, or null.
std::pair<const Hold*, const Hold*> known_ends(const World& world, const Connector& connector) {
  if (connector.holds.size() < 2) return {};
  const Hold &first = connector.holds.front(), &last = connector.holds.back();
  const bool at_ends = first.particle == 0 && last.particle + 1 == connector.particles();
  if (!at_ends || !is_prescribed(world, first.to) || !is_prescribed(world, last.to)) return {};
  return {&first, &last};
}

bool moves(const World& world, const Attachment& to) {
  if (to.kind == Attachment::Kind::fixed) return false;
  const Path* path =
      to.kind == Attachment::Kind::body ? world.bodies[to.body].path.get() : to.path.get();
  return !path || path->keys().size() != 1;
}

/// What is wrong with the distance, or empty.
std::string misfit(const Connector& connector, double distance) {
  const double length = connector.length;
  const bool one_link = connector.model == ConnectorModel::links && connector.links() == 1;
  if (distance > length * (1 + kRounding)) {
    return fmt::format("{:.6g} m apart, expected at most the length, {} m", distance, length);
  }
  if (one_link && distance < length * (1 - kRounding)) {
    return fmt::format("{:.6g} m apart, expected the length of the only link, {} m", distance,
                       length);
  }
  return {};
}

}  // namespace

void check_reach(const Document& document, const World& world, const Timeline& timeline,
                 double duration) {
  const Value* table = document.root.find("connectors");
  if (!table) return;
  std::vector<const Value*> values;  // of each connector; copies come last
  for (const Value& value : table->children) values.push_back(&value);
  for (const Value& value : table->children)
    values.insert(values.end(), repeat_count(value) - 1, &value);
  const double look = std::max(kLook, duration / kLooks);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    const auto [first, last] = known_ends(world, connector);
    if (!first) continue;
    double end = duration;
    for (const TimedCut& cut : timeline.cuts) {
      if (cut.connector == c) end = std::min(end, cut.time);
    }
    const bool still = !moves(world, first->to) && !moves(world, last->to);
    for (double time = 0;; time = std::min(time + look, end)) {
      const Vec3 from = hold_motion(world, first->to, time).position;
      const double distance = (hold_motion(world, last->to, time).position - from).norm();
      const std::string what = misfit(connector, distance);
      if (!what.empty()) {
        document.fail(*values[c], fmt::format("at {:.6g} s the ends are {}", time, what));
      }
      if (still || time >= end) break;
    }
  }
}

}  // namespace taut
