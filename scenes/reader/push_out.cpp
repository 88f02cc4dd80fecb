// Connectors that start outside of obstacles because their scene asks for it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scenes/reader/reader.h"
#include "scenes/scene/names.h"
#include "sim/world/places.h"
#include "sim/world/restore.h"

namespace taut::scenes {
namespace {

constexpr int kSweeps = 10000;
constexpr double kBeyond = 1e-3;  // of a link: how far past the surface a bead is moved
constexpr double kMost = 0.25;    // of a link: how far at once, so that its neighbours can follow
constexpr double kRounding = 1e-9;

/// The connector whose shape at the start this is, or one of its copies.
bool is_of(const Connector& connector, const Value& value) {
  return written_name(connector.name) == value.name;
}

bool keeps_lengths(const Connector& connector) {
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double length = (connector.position[k + 1] - connector.position[k]).norm();
    const double longer = length / connector.rest[k] - 1;
    if (connector.pulls ? longer > kRounding : std::abs(longer) > kRounding) return false;
  }
  return true;
}

/// Moves beads that are inside of an obstacle out of it, along the unit vector `out`. Whether there
/// were any.
bool move_beads(const std::vector<Obstacle>& obstacles, const Vec3& out, Connector& connector) {
  const double link = connector.rest.front();
  bool found = false;
  for (const Obstacle& obstacle : obstacles) {
    if (!obstacle.touches(connector.category)) continue;
    const Pose frame = obstacle.frame(0).pose();
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (holds(connector, i)) continue;
      const double apart = gap(obstacle, frame, connector.position[i], connector.radius).distance;
      if (apart >= 0) continue;
      // No way out is shorter than that to the surface nearby.
      connector.position[i] += std::min(kBeyond * link - apart, kMost * link) * out;
      found = true;
    }
  }
  return found;
}

}  // namespace

void push_out_starts(const Document& document, World& world) {
  const Value* table = document.root.find("connectors");
  for (std::size_t c = 0; table && c < table->children.size(); ++c) {
    const Value& value = table->children[c];
    const Value* start = value.find("start");
    const Value* asked = start ? start->find("push_out") : nullptr;
    if (!asked) continue;
    const Vec3 out = direction(document, *asked);
    for (const char* key : {"from", "to"}) {
      const Value& end = *value.find(key);
      if (!end.find("free") && !end.find("point_mass") && !end.find("fixed") && !end.find("path") &&
          !end.find("bone")) {
        document.fail_at_key(*asked, "needs ends that are free, fixed, on a path or on a bone");
      }
    }
    LinkRestorer restorer;
    for (Connector& connector : world.connectors) {
      if (!is_of(connector, value)) continue;
      int sweeps = 0;
      while (move_beads(world.obstacles, out, connector)) {
        restorer.restore(connector, 0);
        if (++sweeps < kSweeps && keeps_lengths(connector)) continue;
        document.fail_at_key(*asked,
                             "found no place for it outside of the obstacles, expected another "
                             "start");
      }
    }
  }
}

}  // namespace taut::scenes
