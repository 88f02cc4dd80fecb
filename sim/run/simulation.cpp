#include "sim/run/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "sim/interventions/flaws.h"
#include "sim/world/places.h"

namespace taut {
namespace {

World finished(World world) {
  if (world.topology == 0) finish(world);
  return world;
}

/// Whether two times (s) are apart by roundings of sums alone: methods take no such step.
bool same_time(double a, double b) {
  constexpr double kRoundings = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(a - b) <= kRoundings * std::abs(b);
}

}  // namespace

Simulation::Simulation(World world, std::unique_ptr<Method> method, Timeline timeline)
    : world_(finished(std::move(world))),
      bodies_as_links_(world_),
      method_(std::move(method)),
      timeline_(std::move(timeline)),
      parts_(world_.connectors),
      pins_(timeline_.pins.size(), 0) {
  for (std::size_t i = 0; i < timeline_.pins.size(); ++i) {
    entries_.push_back({timeline_.pins[i].from, Entry::Kind::pin, i});
    entries_.push_back({timeline_.pins[i].until, Entry::Kind::release, i});
  }
  for (std::size_t i = 0; i < timeline_.cuts.size(); ++i) {
    entries_.push_back({timeline_.cuts[i].time, Entry::Kind::cut, i});
  }
  std::ranges::sort(entries_, {}, [](const Entry& entry) {
    return std::tuple(entry.time, entry.kind, entry.index);
  });
  show();
  if (auto islands = Islands::find(world_, timeline_, *method_)) {
    islands_ = islands.get();
    method_ = std::move(islands);
  }
  interventions_.reserve(world_, timeline_.pins.size(), timeline_.cuts.size());
}

void Simulation::advance_to(double time) {
  if (!(time >= world_.time)) throw std::invalid_argument("a simulation cannot go back in time");
  method_->clear_events();
  if (is_shared_) refresh(world_);
  for (; next_ < entries_.size(); ++next_) {
    const Entry& entry = entries_[next_];
    const bool now = same_time(entry.time, time);
    if (!now && entry.time > time) break;
    const bool passed = entry.time < world_.time || same_time(entry.time, world_.time);
    go_to(entry, now ? time : passed ? world_.time : entry.time);
    if (!cut_several(entry.time)) enact(entry);
  }
  if (time > world_.time || left_behind_ || (islands_ && islands_->left_behind())) catch_up(time);
  bodies_as_links_.follow(world_);
}

void Simulation::go_on_from(const World& world) {
  world_ = world;
  world_.topology += ++begun_;
}

void Simulation::tell(const Simulation& other, void (*say)(Method& own, const Method& others)) {
  if (islands_ && other.islands_) return islands_->tell(*other.islands_, say);
  if (!islands_ && !other.islands_) say(*method_, *other.method_);
}

/// Where the entries from the next one on are that happen at `time` (s): none where one of them
/// ties the connector to another thing that moves freely, or where islands have several to do.
std::vector<Parts::Place> Simulation::places_at(double time) const {
  std::vector<Parts::Place> places;
  for (std::size_t i = next_; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (entry.time > time && !same_time(entry.time, time)) break;
    if (islands_ && !places.empty()) return {};
    if (entry.kind == Entry::Kind::cut) {
      const TimedCut& cut = timeline_.cuts[entry.index];
      places.push_back(parts_.at(cut.connector, cut.along));
      continue;
    }
    const TimedPin& pin = timeline_.pins[entry.index];
    if (pin.to && !is_prescribed(world_, *pin.to)) return {};
    places.push_back(parts_.at(pin.connector, pin.along));
  }
  return places;
}

/// To `time` (s), with as much of the world as the entry changes.
void Simulation::go_to(const Entry& entry, double time) {
  if (!islands_) {
    if (!(time > world_.time)) return;
    const std::vector<Parts::Place> places = places_at(time);
    if (places.empty()) return catch_up(time);
    left_behind_ = method_->advance_near(world_, time, places);
    return;
  }
  const bool is_cut = entry.kind == Entry::Kind::cut;
  const std::size_t whole =
      is_cut ? timeline_.cuts[entry.index].connector : timeline_.pins[entry.index].connector;
  islands_->advance_island(world_, time, whole, places_at(time));
}

/// All of the world.
void Simulation::catch_up(double time) {
  left_behind_ = false;
  method_->advance(world_, time);
}

void Simulation::enact(const Entry& entry) {
  Outcome outcome = Outcome::done;
  std::string what;
  if (entry.kind == Entry::Kind::cut) {
    outcome = cut(timeline_.cuts[entry.index], what);
  } else if (entry.kind == Entry::Kind::release) {
    outcome = release(timeline_.pins[entry.index], pins_[entry.index], what);
  } else {
    const TimedPin& pin = timeline_.pins[entry.index];
    const auto [connector, along] = parts_.at(pin.connector, pin.along);
    const Pinned pinned = pin.to ? interventions_.pin(world_, connector, along, *pin.to, pin.over)
                                 : interventions_.pin(world_, connector, along);
    pins_[entry.index] = pinned.pin;
    outcome = pinned.outcome;
    if (pin.to && (outcome == Outcome::out_of_reach || outcome == Outcome::too_near)) {
      what = why_out_of_reach(world_, connector, along, *pin.to);
    }
  }
  if (outcome == Outcome::done && what.empty()) return;
  if (islands_ || left_behind_) catch_up(world_.time);
  const bool is_cut = entry.kind == Entry::Kind::cut;
  if (what.empty()) what = words(outcome);
  throw BadIntervention(
      {is_cut, entry.index, what}, entry.time,
      is_cut ? timeline_.cuts[entry.index].source : timeline_.pins[entry.index].source);
}

/// Makes the cuts from the next entry on that divide one connector at this time (s), all at once;
/// whether it did. Beads that are added among obstacles are looked at one by one.
bool Simulation::cut_several(double time) {
  if (!world_.obstacles.empty()) return false;
  const auto is_one = [&](std::size_t i) {
    return i < entries_.size() && entries_[i].kind == Entry::Kind::cut &&
           same_time(entries_[i].time, time);
  };
  if (!is_one(next_) || !is_one(next_ + 1)) return false;
  const TimedCut& first = timeline_.cuts[entries_[next_].index];
  const std::size_t connector = parts_.at(first.connector, first.along).connector;
  std::vector<double> along;
  std::size_t end = next_;
  for (; is_one(end); ++end) {
    const TimedCut& cut = timeline_.cuts[entries_[end].index];
    const Parts::Place place = parts_.at(cut.connector, cut.along);
    if (cut.connector != first.connector || place.connector != connector) break;
    along.push_back(place.along);
  }
  std::size_t made = world_.connectors.size();
  if (along.size() < 2 || !interventions_.cut(world_, connector, along)) return false;
  for (std::size_t i = next_; i < end; ++i) {
    const TimedCut& cut = timeline_.cuts[entries_[i].index];
    parts_.cut(cut.connector, cut.along, made++);
  }
  next_ = end - 1;
  return true;
}

/// A particle that is added at the cut is a bead where none was: `inside` says where it may not be.
Outcome Simulation::cut(const TimedCut& cut, std::string& inside) {
  const auto [connector, along] = parts_.at(cut.connector, cut.along);
  const std::size_t particles = world_.connectors.at(connector).particles();
  const Divided made = interventions_.cut(world_, connector, along);
  if (made.outcome != Outcome::done) return made.outcome;
  parts_.cut(cut.connector, cut.along, made.connector);
  const std::size_t head = world_.connectors[connector].particles();
  const std::size_t tail = world_.connectors[made.connector].particles();
  if (head + tail == particles + 2) inside = why_inside(world_, made.connector, 0);
  return made.outcome;
}

/// A particle that stays when its pin goes is a bead again: `inside` says where it may not be.
Outcome Simulation::release(const TimedPin& pin, std::uint64_t number, std::string& inside) {
  const auto [connector, along] = parts_.at(pin.connector, pin.along);
  const std::size_t particles = world_.connectors.at(connector).particles();
  const Outcome outcome = interventions_.release(world_, number, connector);
  const Connector& freed = world_.connectors[connector];
  if (outcome != Outcome::done || freed.particles() != particles) return outcome;
  const Place place = locate(freed, along);
  if (!holds(freed, place.particle)) inside = why_inside(world_, connector, place.particle);
  return outcome;
}

void Simulation::show() {
  if (timeline_.empty()) return;
  Parts parts(world_.connectors);
  for (const TimedCut& cut : in_order_of_time(timeline_.cuts)) {
    parts.cut(cut.connector, cut.along, parts.all().size());
  }
  const World end = divided(world_, timeline_);
  for (const Parts::Part& part : parts.all()) {
    Shown shown{part.whole, {part.start}};
    for (const double rest : end.connectors.at(part.connector).rest) {
      shown.along.push_back(shown.along.back() + rest);
    }
    shown_.push_back(std::move(shown));
  }
  shown_row_ = parts.in_a_row();
}

Snapshot Simulation::state() const {
  Snapshot shot = snapshot(world_);
  if (timeline_.empty()) {
    bodies_as_links_.show(shot);
    return shot;
  }
  shot.connectors.clear();
  shot.connectors.resize(shown_.size());
  Walk walk;
  std::size_t last = 0;
  for (const std::size_t row : shown_row_) {
    const Shown& shown = shown_[row];
    const double middle = (shown.along.front() + shown.along.back()) / 2;
    const auto [connector, along] = parts_.at(shown.whole, middle);
    if (connector != std::exchange(last, connector)) walk = {};
    shot.connectors[row] =
        positions(world_.connectors[connector], middle - along, shown.along, walk);
  }
  bodies_as_links_.show(shot);
  return shot;
}

}  // namespace taut
