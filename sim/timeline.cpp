#include "sim/timeline.h"

#include <algorithm>
#include <sstream>

#include "sim/parts.h"
#include "sim/places.h"

namespace taut {
namespace {

/// Something that holds a connector at a place whose motion is known, for a time.
struct Known {
  double along;        // m
  double from, until;  // s
  Attachment to;
};

/// When the last of the paths ends that two attachments follow.
double last_motion(const World& world, const Known& a, const Known& b) {
  double last = std::max(a.from, b.from);
  for (const Attachment* to : {&a.to, &b.to}) {
    const Path* path = to->path.get();
    if (to->kind == Attachment::Kind::body) path = world.bodies[to->body].path.get();
    if (path) last = std::max(last, path->keys().back().time);
  }
  return std::min({last, a.until, b.until});
}

/// Where two holds are farther apart than the connector between them is long, or nearer than it
/// folds; empty where never.
std::string parting(const World& world, const Known& a, const Known& b,
                    const Connector& connector) {
  constexpr double kLook = 1e-3;  // s; no hand moves a millimetre in less
  const double same = 1e-6 * connector.length;
  const auto [least, most] = distance_range(connector, a.along, b.along);
  const double end = last_motion(world, a, b);
  for (double time = std::max(a.from, b.from);;) {
    const Vec3 from = hold_motion(world, a.to, time).position;
    const double distance = (hold_motion(world, b.to, time).position - from).norm();
    const bool far = distance > most + same, near = distance < least - same;
    if (far || near) {
      std::ostringstream line;
      line << "at " << time << " s it is " << distance << " m from what holds the connector at "
           << a.along << " m, ";
      if (far) line << "with " << most << " m of the connector between them";
      if (near) line << "and the links between them fold to no less than " << least << " m";
      return line.str();
    }
    if (time >= end) return {};
    time = std::min(time + kLook, end);
  }
}

std::string place_flaw(const World& world, std::size_t connector, double along, double time) {
  if (connector >= world.connectors.size()) return std::string(words(Outcome::no_connector));
  std::ostringstream line;
  const double length = world.connectors[connector].length;
  if (!(along >= 0 && along <= length)) {
    line << "its place at " << along << " m is not on the connector, which is " << length
         << " m long";
  } else if (!(time >= world.time)) {
    line << "it begins at " << time << " s, before the scene, which begins at " << world.time
         << " s";
  }
  return line.str();
}

bool known(const World& world, const Attachment& to) {
  return is_prescribed(world, to);
}

std::string pin_flaw(const World& world, const std::vector<TimedPin>& pins, std::size_t index) {
  const TimedPin& pin = pins[index];
  const std::string place = place_flaw(world, pin.connector, pin.along, pin.from);
  if (!place.empty()) return place;
  if (!(pin.until > pin.from)) {
    std::ostringstream line;
    line << "it ends at " << pin.until << " s, expected later than it begins, at " << pin.from
         << " s";
    return line.str();
  }
  if (pin.to && !exists(world, *pin.to)) return std::string(words(Outcome::no_target));
  const Connector& connector = world.connectors[pin.connector];
  double along = 0;
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    const auto hold = std::ranges::find(connector.holds, i, &Hold::particle);
    if (hold != connector.holds.end()) {
      if (std::abs(along - pin.along) <= kSamePlace * connector.length) {
        return std::string(words(Outcome::held_there));
      }
      if (pin.to && known(world, *pin.to) && known(world, hold->to)) {
        const std::string apart =
            parting(world, {along, world.time, INFINITY, hold->to},
                    {pin.along, pin.from + pin.over, pin.until, *pin.to}, connector);
        if (!apart.empty()) return apart;
      }
    }
    if (i < connector.links()) along += connector.rest[i];
  }
  for (std::size_t j = 0; j < index; ++j) {
    const TimedPin& other = pins[j];
    const bool together =
        other.connector == pin.connector && other.from < pin.until && pin.from < other.until;
    if (!together) continue;
    if (std::abs(other.along - pin.along) <= kSamePlace * connector.length) {
      return std::string(words(Outcome::held_there)) + ", by another pin at that time";
    }
    if (!pin.to || !other.to || !known(world, *pin.to) || !known(world, *other.to)) continue;
    const std::string apart =
        parting(world, {other.along, other.from + other.over, other.until, *other.to},
                {pin.along, pin.from + pin.over, pin.until, *pin.to}, connector);
    if (!apart.empty()) return apart;
  }
  return {};
}

/// What is wrong with a cut at the place of another.
std::string cut_flaw(const World& world, const std::vector<TimedCut>& cuts, std::size_t index) {
  const TimedCut& cut = cuts[index];
  const std::string place = place_flaw(world, cut.connector, cut.along, cut.time);
  if (!place.empty()) return place;
  const double same = kSamePlace * world.connectors[cut.connector].length;
  if (cut.along <= same || cut.along >= world.connectors[cut.connector].length - same) {
    return "it is at an end of the connector";
  }
  for (std::size_t j = 0; j < index; ++j) {
    if (cuts[j].connector == cut.connector && std::abs(cuts[j].along - cut.along) <= same) {
      return "the connector is cut there already";
    }
  }
  return {};
}

}  // namespace

std::optional<Flaw> find_flaw(const World& world, const Timeline& timeline) {
  for (std::size_t i = 0; i < timeline.pins.size(); ++i) {
    std::string what = pin_flaw(world, timeline.pins, i);
    if (!what.empty()) return Flaw{false, i, std::move(what)};
  }
  for (std::size_t i = 0; i < timeline.cuts.size(); ++i) {
    std::string what = cut_flaw(world, timeline.cuts, i);
    if (!what.empty()) return Flaw{true, i, std::move(what)};
  }
  return {};
}

std::vector<TimedCut> in_order_of_time(std::vector<TimedCut> cuts) {
  std::ranges::stable_sort(cuts, {}, &TimedCut::time);
  return cuts;
}

World divided(World world, const Timeline& timeline) {
  Parts parts(world.connectors);
  Interventions interventions;
  for (const TimedCut& cut : in_order_of_time(timeline.cuts)) {
    const auto [part, along] = parts.at(cut.connector, cut.along);
    if (interventions.cut(world, part, along).outcome == Outcome::done) {
      parts.cut(cut.connector, cut.along, world.connectors.size() - 1);
    }
  }
  return world;
}

BadIntervention::BadIntervention(Flaw found, double at, const std::string& source)
    : std::runtime_error([&] {
        std::ostringstream line;
        if (!source.empty()) line << source << ": ";
        line << (found.cut ? "cut " : "pin ") << found.index + 1 << ", at " << at
             << " s: " << found.what;
        return line.str();
      }()),
      flaw(std::move(found)),
      time(at) {}

}  // namespace taut
