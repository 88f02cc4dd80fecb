// Finds the flaws of a timeline in a sweep over its times: only neighbours along a connector are
// looked at, as no two holds are too far apart where no neighbours between them are.
#include "sim/interventions/flaws.h"

#include <algorithm>
#include <map>
#include <set>
#include <sstream>
#include <tuple>

#include "sim/world/places.h"

namespace taut {
namespace {

/// Something that holds a connector for a time.
struct Known {
  double along = 0;            // m
  double from = 0, until = 0;  // s
  const Attachment* to = nullptr;
  std::size_t pin = 0;  // index + 1 of the timeline's pin; 0: an end of the connector
};

/// Lengths along a connector, without a pass over its links for every question.
class Ruler {
 public:
  explicit Ruler(const Connector& connector) : connector_(connector) {
    start_.reserve(connector.particles());
    start_.push_back(0);
    for (const double rest : connector.rest) {
      start_.push_back(start_.back() + rest);
      longest_ = std::max(longest_, rest);
    }
  }

  double along(std::size_t particle) const { return start_[particle]; }

  /// Of two places on the connector.
  DistanceRange range(double along, double other) const {
    const auto [low, high] = std::minmax(along, other);
    if (2 * longest_ <= high - low || connector_.pulls) return {0, high - low};
    const auto after = std::ranges::upper_bound(start_, low);
    auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - start_.begin() - 1, 0));
    double longest = 0;
    for (; k < connector_.links() && start_[k] < high; ++k) {
      longest = std::max(longest, std::min(start_[k + 1], high) - std::max(start_[k], low));
    }
    return {std::max(0.0, 2 * longest - (high - low)), high - low};
  }

 private:
  const Connector& connector_;
  std::vector<double> start_;  // m, of every particle
  double longest_ = 0;         // m, of the links
};

bool on_body(const Attachment& to) {
  return to.kind == Attachment::Kind::body;
}

/// Whether two attachments are of one frame, so that they stay as far apart as they are.
bool one_frame(const Attachment& a, const Attachment& b) {
  if (a.kind != b.kind) return false;
  if (a.kind == Attachment::Kind::fixed) return true;
  return on_body(a) ? a.body == b.body : a.path == b.path;
}

/// When the last of the paths ends that two attachments follow.
double last_motion(const World& world, const Known& a, const Known& b) {
  double last = std::max(a.from, b.from);
  for (const Attachment* to : {a.to, b.to}) {
    const Path* path = to->path.get();
    if (on_body(*to)) path = world.bodies[to->body].path.get();
    if (path) last = std::max(last, path->keys().back().time);
  }
  return std::min({last, a.until, b.until});
}

/// Words that end a sentence about a place too far from or too near to a hold; empty: neither.
std::string misfit(double distance, double along, const DistanceRange& range, double same) {
  const bool far = distance > range.most + same, near = distance < range.least - same;
  if (!far && !near) return {};
  std::ostringstream line;
  line << "it is " << distance << " m from what holds the connector at " << along << " m, ";
  if (far) line << "with " << range.most << " m of the connector between them";
  if (near) line << "and the links between them fold to no less than " << range.least << " m";
  return line.str();
}

class Sweep {
 public:
  Sweep(const World& world, const Timeline& timeline) : world_(world), timeline_(timeline) {}

  std::optional<Flaw> run() {
    std::map<std::size_t, std::vector<Known>> pins;  // by connector
    for (std::size_t i = 0; i < timeline_.pins.size(); ++i) {
      const TimedPin& pin = timeline_.pins[i];
      std::string what = alone(pin);
      if (!what.empty()) {
        note(i, std::move(what));
        continue;
      }
      pins[pin.connector].push_back(
          {pin.along, pin.from, pin.until, pin.to ? &*pin.to : nullptr, i + 1});
    }
    for (auto& [index, entries] : pins) {
      const Connector& connector = world_.connectors[index];
      const Ruler ruler(connector);
      for (const Hold& hold : connector.holds) {
        entries.push_back({ruler.along(hold.particle), world_.time, INFINITY, &hold.to, 0});
      }
      const double same = kSamePlace * connector.length;
      over(entries, false, [&](const Known& a, const Known& b, double) {
        if (b.along - a.along <= same) meet(a, b);
      });
      std::erase_if(entries, [](const Known& entry) { return entry.to == nullptr; });
      for (Known& entry : entries) {
        if (entry.pin > 0) entry.from += timeline_.pins[entry.pin - 1].over;
      }
      const auto pair = [&](const Known& a, const Known& b, double time) {
        part(a, b, time, ruler, connector);
      };
      // A hold whose motion is unknown fits only holds on the same body.
      auto loose = entries;
      std::erase_if(loose, [&](const Known& e) { return is_prescribed(world_, *e.to); });
      std::ranges::stable_sort(loose, {}, [](const Known& e) { return e.to->body; });
      for (auto first = loose.begin(); first != loose.end();) {
        const auto last = std::find_if(
            first, loose.end(), [&](const Known& e) { return e.to->body != first->to->body; });
        over({first, last}, true, pair);
        first = last;
      }
      std::erase_if(entries, [&](const Known& e) { return !is_prescribed(world_, *e.to); });
      over(entries, true, pair);
    }
    check_cuts();
    return found_;
  }

 private:
  void note(std::size_t pin, std::string what) {
    if (!found_ || pin < found_->index) found_ = Flaw{false, pin, std::move(what)};
  }

  /// The flaw of a pin by itself, all others aside.
  std::string alone(const TimedPin& pin) const {
    const std::string place = place_flaw(pin.connector, pin.along, pin.from);
    if (!place.empty()) return place;
    if (!(pin.until > pin.from)) {
      std::ostringstream line;
      line << "it ends at " << pin.until << " s, expected later than it begins, at " << pin.from
           << " s";
      return line.str();
    }
    if (pin.to && !exists(world_, *pin.to)) return std::string(words(Outcome::no_target));
    return {};
  }

  std::string place_flaw(std::size_t connector, double along, double time) const {
    if (connector >= world_.connectors.size()) return std::string(words(Outcome::no_connector));
    if (world_.connectors[connector].winch) return std::string(words(Outcome::has_winch));
    std::ostringstream line;
    const double length = world_.connectors[connector].length;
    if (!(along >= 0 && along <= length)) {
      line << "its place at " << along << " m is not on the connector, which is " << length
           << " m long";
    } else if (!(time >= world_.time)) {
      line << "it begins at " << time << " s, before the scene, which begins at " << world_.time
           << " s";
    }
    return line.str();
  }

  /// Calls look(a, b, time) for every two entries that become neighbours along the connector, a
  /// before b, at that time (s); `after_end`, also where one between them has ended.
  static void over(const std::vector<Known>& entries, bool after_end, auto&& look) {
    std::vector<std::tuple<double, bool, std::size_t>> events;  // ends come first
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (!(entries[i].until > entries[i].from)) continue;
      events.emplace_back(entries[i].from, true, i);
      events.emplace_back(entries[i].until, false, i);
    }
    std::ranges::sort(events);
    std::set<std::pair<double, std::size_t>> active;  // by their places
    for (const auto& [time, begins, i] : events) {
      const std::pair key(entries[i].along, i);
      const auto after = active.upper_bound(key);
      if (begins) {
        if (after != active.end()) look(entries[i], entries[after->second], time);
        if (after != active.begin()) look(entries[std::prev(after)->second], entries[i], time);
        active.insert(after, key);
        continue;
      }
      const auto own = active.find(key);
      const auto next = active.erase(own);
      if (after_end && std::isfinite(time) && next != active.begin() && next != active.end()) {
        look(entries[std::prev(next)->second], entries[next->second], time);
      }
    }
  }

  void meet(const Known& a, const Known& b) {
    if (a.pin == 0 && b.pin == 0) return;
    const bool end = a.pin == 0 || b.pin == 0;
    note(std::max(a.pin, b.pin) - 1,
         std::string(words(Outcome::held_there)) + (end ? "" : ", by another pin at that time"));
  }

  /// Notes where two holds are farther apart than the connector between them is long, or nearer
  /// than it folds, from `time` on.
  void part(const Known& a, const Known& b, double time, const Ruler& ruler,
            const Connector& connector) {
    if (a.pin == 0 && b.pin == 0) return;
    constexpr double kSampling = 1e-3;  // s; no hand moves a millimetre in less
    const DistanceRange range = ruler.range(a.along, b.along);
    const bool rigid = one_frame(*a.to, *b.to);
    const double end = rigid ? time : last_motion(world_, a, b);
    for (;;) {
      const Vec3 from = hold_motion(world_, *a.to, time).position;
      const double distance = (hold_motion(world_, *b.to, time).position - from).norm();
      const Known& other = a.pin < b.pin ? a : b;
      const std::string what = misfit(distance, other.along, range, 1e-6 * connector.length);
      if (!what.empty()) {
        std::ostringstream line;
        line << "at " << time << " s " << what;
        if (rigid && on_body(*a.to)) line << ", and one body holds both";
        return note(std::max(a.pin, b.pin) - 1, line.str());
      }
      if (time >= end) return;
      time = std::min(time + kSampling, end);
    }
  }

  /// The cuts, where no pin has a flaw.
  void check_cuts() {
    if (found_) return;
    const std::vector<TimedCut>& cuts = timeline_.cuts;
    const auto note_cut = [&](std::size_t cut, std::string what) {
      if (!found_ || cut < found_->index) found_ = Flaw{true, cut, std::move(what)};
    };
    std::vector<std::tuple<std::size_t, double, std::size_t>> places;
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      const TimedCut& cut = cuts[i];
      std::string what = place_flaw(cut.connector, cut.along, cut.time);
      if (what.empty()) {
        const double length = world_.connectors[cut.connector].length, same = kSamePlace * length;
        if (cut.along <= same || cut.along >= length - same) {
          what = "it is at an end of the connector";
        }
      }
      if (what.empty()) {
        places.emplace_back(cut.connector, cut.along, i);
      } else {
        note_cut(i, std::move(what));
      }
    }
    std::ranges::sort(places);
    const auto same_place = [&](std::size_t connector, double along, double other) {
      return std::abs(along - other) <= kSamePlace * world_.connectors[connector].length;
    };
    for (std::size_t k = 1; k < places.size(); ++k) {
      const auto& [connector, along, i] = places[k];
      const auto& [before, at, j] = places[k - 1];
      if (before == connector && same_place(connector, along, at)) {
        note_cut(std::max(i, j), "the connector is cut there already");
      }
    }
    for (const TimedPin& pin : timeline_.pins) {
      const double same = kSamePlace * world_.connectors[pin.connector].length;
      auto near = std::ranges::lower_bound(
          places, std::tuple(pin.connector, pin.along - same, std::size_t{0}));
      for (; near != places.end(); ++near) {
        const auto& [connector, along, i] = *near;
        if (connector != pin.connector || along > pin.along + same) break;
        if (!(pin.from <= cuts[i].time && cuts[i].time < pin.until)) continue;
        std::ostringstream line;
        line << "pins[" << &pin - timeline_.pins.data() << "] holds the connector there from "
             << pin.from << " s until " << pin.until << " s, expected another place or time";
        note_cut(i, line.str());
      }
    }
  }

  const World& world_;
  const Timeline& timeline_;
  std::optional<Flaw> found_;
};

}  // namespace

std::optional<Flaw> find_flaw(const World& world, const Timeline& timeline) {
  return Sweep(world, timeline).run();
}

std::string why_out_of_reach(const World& world, std::size_t index, double along,
                             const Attachment& to) {
  const Connector& connector = world.connectors[index];
  const Ruler ruler(connector);
  const Vec3 target = hold_motion(world, to, world.time).position;
  for (const Hold& hold : connector.holds) {
    const double there = ruler.along(hold.particle);
    const std::string what = misfit((target - connector.position[hold.particle]).norm(), there,
                                    ruler.range(along, there), kSamePlace * connector.length);
    if (what.empty()) continue;
    return what + (on_body(to) ? ", expected a point of the body that is within reach" : "");
  }
  return {};
}

std::string why_inside(const World& world, std::size_t index, std::size_t particle) {
  constexpr double kInside = 1e-6;  // of the connector's length: as deep as methods leave beads
  const Connector& connector = world.connectors[index];
  for (const Obstacle& obstacle : world.obstacles) {
    if (!obstacle.touches(connector.category)) continue;
    const double apart = gap(obstacle, obstacle.frame(world.time).pose(),
                             connector.position[particle], connector.radius)
                             .distance;
    if (apart >= -kInside * connector.length) continue;
    std::ostringstream line;
    line << "it frees a bead " << -apart << " m inside of obstacle " << obstacle.name
         << ", expected a place or time where the bead is outside";
    return line.str();
  }
  return {};
}

}  // namespace taut
