#include "scenes/reader/lines.h"

#include <algorithm>
#include <array>
#include <compare>
#include <optional>
#include <set>
#include <utility>

#include "sim/world/hanging.h"

namespace taut::scenes {
namespace {

/// A connector's first end, or its last.
struct LineEnd {
  std::size_t connector = 0;
  bool last = false;
  auto operator<=>(const LineEnd&) const = default;
};

/// The ends of connectors that meet one other end there, and nothing else.
class Meetings {
 public:
  Meetings(const Value& connectors, const World& world, const JoinedEnds& joined)
      : other_(connectors.children.size()) {
    std::vector<std::pair<LineEnd, LineEnd>> pairs;
    std::multiset<LineEnd> met;
    for (std::size_t c = 0; c < connectors.children.size(); ++c) {
      for (const bool last : {false, true}) {
        const auto target = joined.target(c, last ? world.connectors[c].links() : 0);
        if (!target) continue;
        const std::size_t end = world.connectors[target->connector].links();
        if (target->particle != 0 && target->particle != end) continue;
        const LineEnd own{c, last}, other{target->connector, target->particle == end};
        met.insert(own);
        met.insert(other);
        pairs.emplace_back(own, other);
      }
    }
    const auto hangs = [&](const LineEnd& end) {
      const Value& value = connectors.children[end.connector];
      const Connector& connector = world.connectors[end.connector];
      return !value.find("start") && !value.find("over") && !value.find("repeat") &&
             !connector.winch && connector.length > 0 && met.count(end) == 1;
    };
    const auto is_held = [&](const LineEnd& end) {
      const Connector& connector = world.connectors[end.connector];
      const std::size_t particle = end.last ? connector.links() : 0;
      return std::ranges::find(connector.holds, particle, &Hold::particle) != connector.holds.end();
    };
    for (const auto& [a, b] : pairs) {
      if (a.connector == b.connector || !hangs(a) || !hangs(b) || is_held(b)) continue;
      at(a) = b;
      at(b) = a;
    }
  }

  const std::optional<LineEnd>& other(const LineEnd& end) const {
    return other_[end.connector][end.last];
  }

 private:
  std::optional<LineEnd>& at(const LineEnd& end) { return other_[end.connector][end.last]; }

  std::vector<std::array<std::optional<LineEnd>, 2>> other_;
};

}  // namespace

std::vector<Line> lines_of(const Value& connectors, const World& world, const JoinedEnds& joined) {
  const Meetings meetings(connectors, world, joined);
  std::vector<Line> lines;
  std::vector<bool> taken(connectors.children.size());
  for (std::size_t c = 0; c < taken.size(); ++c) {
    for (const bool last : {false, true}) {
      LineEnd in{c, last};  // by which the line comes into a connector
      if (taken[c] || meetings.other(in) || !meetings.other({c, !last})) continue;
      Line line;
      for (;;) {
        taken[in.connector] = true;
        line.push_back({in.connector, in.last});
        const auto& next = meetings.other({in.connector, !in.last});
        if (!next) break;
        in = *next;
      }
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

double length_of(const Line& line, const World& world) {
  double length = 0;
  for (const InLine& one : line) length += world.connectors[one.connector].length;
  return length;
}

void hang_line(World& world, const Line& line, const Vec3& from, const Vec3& to) {
  std::vector<double> rest, mass{0.0};
  double whole = 0;
  for (const InLine& one : line) {
    const Connector& connector = world.connectors[one.connector];
    std::vector<double> own = connector.rest, masses = connector.particle_mass;
    if (one.against) {
      std::ranges::reverse(own);
      std::ranges::reverse(masses);
    }
    rest.insert(rest.end(), own.begin(), own.end());
    mass.back() += masses.front();  // that of the joint is of both
    mass.insert(mass.end(), masses.begin() + 1, masses.end());
  }
  for (const double some : mass) whole += some;
  std::vector<Vec3> points(mass.size());
  HangingChain().place({rest, mass, length_of(line, world), whole}, from, to, world.gravity,
                       points);
  std::size_t at = 0;
  for (const InLine& one : line) {
    Connector& connector = world.connectors[one.connector];
    const auto begin = points.begin() + static_cast<std::ptrdiff_t>(at);
    connector.position.assign(begin, begin + static_cast<std::ptrdiff_t>(connector.particles()));
    if (one.against) std::ranges::reverse(connector.position);
    at += connector.links();
  }
}

}  // namespace taut::scenes
