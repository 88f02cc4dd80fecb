#include "sim/run/simulation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/run/forces.h"
#include "sim/topology/components.h"
#include "sim/world/places.h"

namespace taut {
namespace {

World finished(World world) {
  if (world.topology == 0) finish(world);
  return world;
}

constexpr double kWholeStep = 1e-9;  // a time so near a multiple of the step is one

/// Whether two times (s) are apart by roundings of sums alone: methods take no such step.
bool same_time(double a, double b) {
  constexpr double kRoundings = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(a - b) <= kRoundings * std::abs(b);
}

/// Whether a cut on a link there takes mass from farther off: pins that were added have none.
bool takes_from_afar(const World& world, const Parts::Place& spot) {
  const Connector& connector = world.connectors[spot.connector];
  const Place place = locate(connector, spot.along);
  const auto has_mass = [&](std::size_t i) { return connector.particle_mass[i] > 0; };
  return place.fraction > 0 && !(has_mass(place.particle) && has_mass(place.particle + 1));
}

/// Where a link that breaks is cut, m along its connector: in its middle or, where a bead there
/// would be inside of an obstacle, at one of its particles.
double place_of_break(const World& world, std::size_t index, std::size_t link) {
  constexpr double kNear = 0.05;  // of the link
  const Connector& connector = world.connectors[index];
  double start = 0;
  for (std::size_t k = 0; k < link; ++k) start += connector.rest[k];
  const double rest = connector.rest[link];
  const Vec3 middle = (connector.position[link] + connector.position[link + 1]) / 2;
  const bool is_inside = std::ranges::any_of(world.obstacles, [&](const Obstacle& obstacle) {
    if (!obstacle.touches(connector.category)) return false;
    const Pose frame = obstacle.frame(world.time).pose();
    return gap(obstacle, frame, middle, connector.radius).distance < kNear * rest;
  });
  for (const std::size_t end : {link + 1, link}) {
    const bool is_free = end > 0 && end < connector.links() && !holds(connector, end) &&
                         find_joint(world, index, end) == nullptr;
    if (is_inside && is_free) return end == link ? start : start + rest;
  }
  return start + rest / 2;
}

}  // namespace

Simulation::Simulation(World world, std::unique_ptr<Method> method, Timeline timeline)
    : world_(finished(std::move(world))),
      state_parts_(world_, timeline),
      bodies_as_links_(world_),
      method_(std::move(method)),
      timeline_(std::move(timeline)),
      uncut_(world_.connectors),
      parts_(uncut_),
      pins_(timeline_.pins.size(), 0) {
  for (std::size_t i = 0; i < timeline_.pins.size(); ++i) {
    const TimedPin& pin = timeline_.pins[i];
    entries_.push_back({pin.from, Entry::Kind::pin, pin.connector, i});
    entries_.push_back({pin.until, Entry::Kind::release, pin.connector, i});
  }
  for (std::size_t i = 0; i < timeline_.cuts.size(); ++i) {
    const TimedCut& cut = timeline_.cuts[i];
    entries_.push_back({cut.time, Entry::Kind::cut, cut.connector, i});
  }
  std::ranges::sort(entries_, {}, [](const Entry& entry) {
    return std::tuple(entry.time, entry.kind, entry.connector, entry.index);
  });
  show();
  if (auto islands = Islands::find(world_, timeline_, *method_)) {
    islands_ = islands.get();
    method_ = std::move(islands);
  }
  interventions_.reserve(world_, timeline_.pins.size(), timeline_.cuts.size());
}

void Simulation::advance_to(double time) {
  if (is_stopped_) {
    throw std::runtime_error("the simulation was stopped within a step and cannot continue");
  }
  if (!(time >= world_.time)) throw std::invalid_argument("a simulation cannot go back in time");
  is_stopped_ = true;  // by whatever else is thrown
  try {
    method_->clear_events();
    if (is_shared_) refresh(world_);
    const auto breaks = [](const Connector& one) { return std::isfinite(one.breaks_at); };
    if (std::ranges::any_of(world_.connectors, breaks)) {
      watch_tensions(time);
    } else {
      follow_timeline(time);
    }
  } catch (const Diverged&) {
    is_stopped_ = false;
    throw;
  } catch (const BadIntervention&) {
    is_stopped_ = false;
    throw;
  }
  is_stopped_ = false;
}

void Simulation::follow_timeline(double time) {
  for (; next_ < entries_.size(); ++next_) {
    const Entry& entry = entries_[next_];
    const bool now = same_time(entry.time, time);
    if (!now && entry.time > time) break;
    const bool passed = entry.time < world_.time || same_time(entry.time, world_.time);
    go_to(entry, now ? time : passed ? world_.time : entry.time);
    if (!enact_several()) enact(entry);
  }
  if (time > world_.time || left_behind_ || (islands_ && islands_->left_behind())) catch_up(time);
  bodies_as_links_.follow(world_);
  refuse_not_finite();
}

/// Goes on to `time` (s) and looks at the tensions on the way.
void Simulation::watch_tensions(double time) {
  if (!look_ || is_shared_) {
    while (break_link()) continue;
  }
  while (world_.time < time) {
    follow_timeline(next_look(time));
    while (break_link()) continue;
  }
}

/// Looks come closer as the largest tension comes near what breaks its link, and halve the time
/// until then, as far as the last two tell. Equal steps stay as they are.
double Simulation::next_look(double time) const {
  constexpr double kLongest = 1.0 / 480, kShortest = 1e-6, kGrowth = 4;  // s
  double wait = kLongest;
  if (before_ && look_->time > before_->time) {
    const double last = look_->time - before_->time;
    const double slope = (look_->share - before_->share) / last;
    if (slope > 0) wait = std::min(wait, (1 - look_->share) / (2 * slope));
    wait = std::clamp(wait, kShortest, std::max(kShortest, kGrowth * last));
  }
  double next = world_.time + wait;
  if (method_->step > 0) {
    const double steps = std::floor(world_.time / method_->step + kWholeStep);
    const double more = std::max(1.0, std::floor(wait / method_->step));
    next = (steps + more) * method_->step;
  }
  return next < time && !same_time(next, time) ? next : time;
}

/// Cuts the link whose tension is farthest above what breaks it; false where none is.
bool Simulation::break_link() {
  Forces forces;
  try {
    forces = forces_of(world_);
  } catch (const Diverged&) {
    return false;  // no forces satisfy the laws here
  }
  const Forces::Link* most = nullptr;
  double share = 0;
  for (const Forces::Link& link : forces.links) {
    const double own = link.tension / world_.connectors[link.connector].breaks_at;
    if (own <= share) continue;
    share = own;
    most = &link;
  }
  if (look_ && look_->time < world_.time) before_ = look_;
  look_ = {world_.time, share};
  if (!(share > 1)) return false;
  const Connector& connector = world_.connectors[most->connector];
  const double along = place_of_break(world_, most->connector, most->link);
  const auto part = std::ranges::find(parts_.all(), most->connector, &Parts::Part::connector);
  const std::size_t whole = part->whole;
  const double place = part->start + along;
  Break made{{.connector = whole, .along = place, .time = world_.time},
             connector.name,
             most->link,
             most->tension};
  const Divided divided = interventions_.cut(world_, most->connector, along);
  if (divided.outcome != Outcome::done) {
    throw BadIntervention({true, breaks_.size(), std::string(words(divided.outcome))}, world_.time,
                          "breaks_at of " + made.connector);
  }
  parts_.cut(whole, place, divided.connector);
  divide_shown(whole, place);
  method_->add_event({.kind = Event::Kind::breaks,
                      .time = world_.time,
                      .connector = most->connector,
                      .span = most->link,
                      .size = most->tension});
  breaks_.push_back(std::move(made));
  before_.reset();
  look_.reset();
  return true;
}

/// Every state that a method hands out passes here.
void Simulation::refuse_not_finite() const {
  constexpr const char* kWhat = "the state is not finite";
  const std::uint64_t steps = method_->counters().steps;
  for (const Connector& connector : world_.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (connector.position[i].allFinite() && connector.velocity[i].allFinite()) continue;
      throw Diverged(method_->called, world_.time, steps, connector.name,
                     std::min(i, connector.links() - 1), kWhat);
    }
  }
  for (const Body& body : world_.bodies) {
    if (body.position.allFinite() && body.velocity.allFinite() && body.spin.allFinite() &&
        body.rotation.coeffs().allFinite()) {
      continue;
    }
    throw Diverged(method_->called, world_.time, steps, body, kWhat);
  }
}

std::string Simulation::save() const {
  SavedState state{.world = world_, .next = next_, .pins = pins_};
  state.world.topology = structure(world_);
  for (const Parts::Part& part : std::span(parts_.all()).subspan(state_parts_.connectors())) {
    state.cuts.push_back({part.whole, part.start, part.connector});
  }
  state.links_rotation = bodies_as_links_.rotations();
  return saved(state, state_parts_);
}

void Simulation::load(std::string_view bytes) {
  SavedState state = loaded(bytes, state_parts_, world_);
  if (state.next > entries_.size() || state.pins.size() != pins_.size() ||
      state.links_rotation.size() != bodies_as_links_.rotations().size()) {
    throw BadState("the state is damaged, expected all bytes as they were saved");
  }
  bodies_as_links_.turn(state.links_rotation);
  world_ = std::move(state.world);
  next_ = state.next;
  pins_ = std::move(state.pins);
  left_behind_ = false;
  breaks_.clear();
  before_.reset();
  look_.reset();
  parts_ = uncut_;
  for (const SavedState::Cut& cut : state.cuts) {
    parts_.cut(cut.whole, cut.along, cut.connector);
    const bool is_known = std::ranges::any_of(timeline_.cuts, [&](const TimedCut& known) {
      return known.connector == cut.whole && known.along == cut.along;
    });
    if (!is_known) divide_shown(cut.whole, cut.along);
  }
  std::vector<std::size_t> wholes(world_.connectors.size());
  for (const Parts::Part& part : parts_.all()) wholes[part.connector] = part.whole;
  begin_anew(wholes);
  interventions_.follow_parts(std::move(wholes));
}

/// Makes the method, or those of the islands, anew.
void Simulation::begin_anew(std::span<const std::size_t> wholes) {
  if (!method_->again) {
    world_.topology += ++begun_;
    return;
  }
  auto islands = islands_ ? Islands::find(world_, timeline_, *method_, wholes) : nullptr;
  islands_ = islands.get();
  std::unique_ptr<Method> fresh = std::move(islands);
  if (!fresh) {
    fresh = method_->again();
    fresh->again = method_->again;
    fresh->step = method_->step;
  }
  method_ = std::move(fresh);
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
/// ties the connector to another thing that moves freely or takes mass from farther off, or where
/// islands have several to do.
std::vector<Parts::Place> Simulation::places_at(double time) const {
  std::vector<Parts::Place> places;
  for (std::size_t i = next_; i < entries_.size(); ++i) {
    const Entry& entry = entries_[i];
    if (entry.time > time && !same_time(entry.time, time)) break;
    if (islands_ && !places.empty()) return {};
    places.push_back(place_of(entry));
    if (entry.kind == Entry::Kind::cut) {
      if (takes_from_afar(world_, places.back())) return {};
    } else {
      const TimedPin& pin = timeline_.pins[entry.index];
      if (pin.to && !is_prescribed(world_, *pin.to)) return {};
    }
  }
  return places;
}

/// Where an entry happens, on the connectors that there are now.
Parts::Place Simulation::place_of(const Entry& entry) const {
  const bool is_cut = entry.kind == Entry::Kind::cut;
  return parts_.at(entry.connector,
                   is_cut ? timeline_.cuts[entry.index].along : timeline_.pins[entry.index].along);
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
  islands_->advance_island(world_, time, entry.connector, places_at(time));
}

/// All of the world.
void Simulation::catch_up(double time) {
  left_behind_ = false;
  method_->advance(world_, time);
}

void Simulation::enact(const Entry& entry) {
  Outcome outcome = Outcome::done;
  std::string what;
  const auto [connector, along] = place_of(entry);
  const std::vector<const Entry*> freed = frees_beads({&entry, 1});
  if (entry.kind == Entry::Kind::cut) {
    const Divided made = interventions_.cut(world_, connector, along);
    outcome = made.outcome;
    if (outcome == Outcome::done) {
      parts_.cut(entry.connector, timeline_.cuts[entry.index].along, made.connector);
    }
  } else if (entry.kind == Entry::Kind::release) {
    outcome = interventions_.release(world_, pins_[entry.index], connector);
  } else {
    const TimedPin& pin = timeline_.pins[entry.index];
    const Pinned pinned = pin.to ? interventions_.pin(world_, connector, along, *pin.to, pin.over)
                                 : interventions_.pin(world_, connector, along);
    pins_[entry.index] = pinned.pin;
    outcome = pinned.outcome;
    if (pin.to && (outcome == Outcome::out_of_reach || outcome == Outcome::too_near)) {
      what = why_out_of_reach(world_, connector, along, *pin.to);
    }
  }
  if (outcome != Outcome::done) refuse(entry, what.empty() ? std::string(words(outcome)) : what);
  look_at_beads(freed);
}

void Simulation::refuse(const Entry& entry, std::string what) {
  if (islands_ || left_behind_) catch_up(world_.time);
  const bool is_cut = entry.kind == Entry::Kind::cut;
  throw BadIntervention(
      {is_cut, entry.index, std::move(what)}, entry.time,
      is_cut ? timeline_.cuts[entry.index].source : timeline_.pins[entry.index].source);
}

/// Does at once what the entries from the next one on do to one connector at one time, all of one
/// kind; whether it did. Then the next one is their last.
bool Simulation::enact_several() {
  const Entry first = entries_[next_];
  const std::size_t index = place_of(first).connector;
  const auto belongs = [&](const Entry& entry) {
    return entry.kind == first.kind && entry.connector == first.connector &&
           same_time(entry.time, first.time) && place_of(entry).connector == index;
  };
  std::size_t end = next_ + 1;
  while (end < entries_.size() && belongs(entries_[end])) ++end;
  const std::span several(&entries_[next_], end - next_);
  if (several.size() < 2) return false;
  std::vector<double> along;
  for (const Entry& entry : several) along.push_back(place_of(entry).along);
  const std::vector<const Entry*> freed = frees_beads(several);
  if (first.kind == Entry::Kind::cut) {
    std::size_t made = world_.connectors.size();
    if (!interventions_.cut(world_, index, along)) return false;
    for (const Entry& entry : several) {
      parts_.cut(entry.connector, timeline_.cuts[entry.index].along, made++);
    }
  } else if (first.kind == Entry::Kind::pin) {
    std::vector<NewPin> pins;
    for (std::size_t i = 0; i < along.size(); ++i) {
      const TimedPin& pin = timeline_.pins[several[i].index];
      pins.push_back({along[i], pin.to, pin.over});
    }
    const std::vector<std::uint64_t> numbers = interventions_.pin(world_, index, pins);
    if (numbers.empty()) return false;
    for (std::size_t i = 0; i < along.size(); ++i) pins_[several[i].index] = numbers[i];
  } else {
    std::vector<std::uint64_t> pins;
    for (const Entry& entry : several) pins.push_back(pins_[entry.index]);
    if (interventions_.release(world_, index, pins) != Outcome::done) return false;
  }
  next_ = end - 1;
  look_at_beads(freed);
  return true;
}

/// Which of the entries free a bead among obstacles: a cut, where it adds a particle, and the
/// release of a particle that stays.
std::vector<const Simulation::Entry*> Simulation::frees_beads(
    std::span<const Entry> entries) const {
  std::vector<const Entry*> found;
  if (world_.obstacles.empty() || entries[0].kind == Entry::Kind::pin) return found;
  for (const Entry& entry : entries) found.push_back(&entry);
  std::ranges::sort(found, {}, [&](const Entry* entry) { return place_of(*entry).along; });
  const Connector& connector = world_.connectors[place_of(entries[0]).connector];
  Walk walk;
  std::erase_if(found, [&](const Entry* entry) {
    const Place place = locate(connector, place_of(*entry).along, walk);
    if (entry->kind == Entry::Kind::cut) return place.fraction == 0;
    const Hold* hold = place.fraction > 0 ? nullptr : find_hold(connector, place.particle);
    return hold == nullptr || hold->pin.fraction > 0;
  });
  return found;
}

/// Refuses the first of the entries whose bead is inside of an obstacle.
void Simulation::look_at_beads(std::span<const Entry* const> freed) {
  Walk walk;
  std::size_t last = 0;
  for (const Entry* entry : freed) {
    const auto [connector, along] = place_of(*entry);
    if (connector != std::exchange(last, connector)) walk = {};
    const Place place = locate(world_.connectors[connector], along, walk);
    std::string inside = why_inside(world_, connector, place.particle);
    if (!inside.empty()) refuse(*entry, std::move(inside));
  }
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

/// Makes two of what is shown as one connector, where that breaks.
void Simulation::divide_shown(std::size_t whole, double along) {
  const auto broken = std::ranges::find_if(shown_, [&](const Shown& shown) {
    return shown.whole == whole && shown.along.front() < along && along < shown.along.back();
  });
  if (broken == shown_.end()) return;
  const auto middle = std::ranges::lower_bound(broken->along, along);
  Shown second{whole, {along}};
  second.along.insert(second.along.end(), middle, broken->along.end());
  broken->along.erase(middle, broken->along.end());
  broken->along.push_back(along);
  const auto row = std::ranges::find(shown_row_, std::size_t(broken - shown_.begin()));
  shown_row_.insert(row + 1, shown_.size());
  shown_.push_back(std::move(second));
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
    if (world_.connectors[connector].winch) {  // nothing divides it, and its lengths change
      shot.connectors[row] = world_.connectors[connector].position;
      continue;
    }
    shot.connectors[row] =
        positions(world_.connectors[connector], middle - along, shown.along, walk);
  }
  bodies_as_links_.show(shot);
  return shot;
}

namespace {

void take_back(const Snapshot& end, const Snapshot& last, double share, Snapshot& state) {
  for (std::size_t c = 0; c < state.connectors.size(); ++c)
    for (std::size_t i = 0; i < state.connectors[c].size(); ++i)
      state.connectors[c][i] += share * (last.connectors[c][i] - end.connectors[c][i]);
  for (std::size_t b = 0; b < state.bodies.size(); ++b) {
    Pose& pose = state.bodies[b];
    pose.position += share * (last.bodies[b].position - end.bodies[b].position);
    const Quat off = last.bodies[b].rotation * end.bodies[b].rotation.conjugate();
    pose.rotation = (Quat::Identity().slerp(share, off) * pose.rotation).normalized();
  }
}

}  // namespace

Between::Between(Simulation other) : simulation_(std::move(other)) {
  simulation_.advance_to(std::as_const(simulation_).world().time);  // what happens at the start
}

std::vector<Snapshot> Between::states(const World& first, const std::vector<double>& times,
                                      const Snapshot& last) {
  simulation_.go_on_from(first);
  std::vector<Snapshot> states;
  for (const double time : times) {
    simulation_.advance_to(time);
    states.push_back(simulation_.state());
  }
  simulation_.advance_to(last.time);
  const Snapshot end = simulation_.state();
  for (Snapshot& state : states)
    take_back(end, last, (state.time - first.time) / (last.time - first.time), state);
  return states;
}

ShownVelocities::ShownVelocities(const World& start, const Timeline& timeline)
    : start_(start.connectors), cuts_(in_order_of_time(timeline.cuts)) {
  for (const Connector& connector : start_) {
    bool shifted = false;
    for (const Hold& hold : connector.holds)
      shifted |= hold.particle == 0 && hold.to.kind == Attachment::Kind::body &&
                 start.bodies[hold.to.body].model == BodyModel::link;
    shifted_.push_back(shifted);
  }
  Parts parts(start_);
  for (const TimedCut& cut : cuts_) parts.cut(cut.connector, cut.along, parts.all().size());
  const World end = divided(start, timeline);
  for (const Parts::Part& part : parts.all()) {
    Shown shown{part.whole, {part.start}};
    for (const double rest : end.connectors.at(part.connector).rest)
      shown.along.push_back(shown.along.back() + rest);
    shown_.push_back(std::move(shown));
  }
  shown_row_ = parts.in_a_row();
}

std::vector<std::vector<Vec3>> ShownVelocities::of(const Simulation& simulation) const {
  const std::vector<Connector>& now = simulation.world().connectors;
  Parts parts(start_);
  for (std::size_t made = start_.size(); made < now.size(); ++made) {
    const TimedCut& cut = cuts_[made - start_.size()];
    parts.cut(cut.connector, cut.along, made);
  }
  std::vector<std::vector<Vec3>> result(shown_.size());
  Walk walk;
  std::size_t last = 0;
  for (const std::size_t row : shown_row_) {
    const Shown& shown = shown_[row];
    const double middle = (shown.along.front() + shown.along.back()) / 2;
    const auto [connector, along] = parts.at(shown.whole, middle);
    const double before = shifted_[shown.whole] ? now[connector].rest.front() : 0;
    if (connector != std::exchange(last, connector)) walk = {};
    if (now[connector].winch) {
      result[row] = now[connector].velocity;
      continue;
    }
    result[row] = velocities(now[connector], middle - along - before, shown.along, walk);
  }
  return result;
}

namespace {

/// Ends and pins that meet others in a free body.
double meeting(const World& world) {
  std::vector<std::size_t> holds(world.bodies.size());
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      if (!is_prescribed(world, hold.to)) ++holds[hold.to.body];
    }
  }
  double sum = 0;
  for (const std::size_t count : holds) sum += count > 1 ? double(count) : 0;
  return sum;
}

constexpr double kDense = 18;      // bytes, by the square of links: matrix, decomposition, packing
constexpr double kContact = 2600;  // bytes, of a particle at obstacles, by `direct`
constexpr double kJoint = 2000;  // bytes, of a joint that is eliminated, in nets rather than trees

bool is_dense(const Settings& settings) {
  const auto solver = settings.find("solver");
  if (solver == settings.end()) return false;
  const auto* name = std::get_if<std::string>(&solver->second);
  return name && *name == "dense";
}

}  // namespace

double memory_of(const MethodInfo& method, const World& world, const Settings& settings) {
  double particles = 0, links = 0, memory = 0;
  for (const Connector& connector : world.connectors) {
    particles += double(connector.particles());
    links += double(connector.links());
    memory += double(sizeof(Connector) + connector.holds.size() * sizeof(Hold));
  }
  // A particle's position, velocity, mass and link, and once more its position in what is shown.
  constexpr double kParticle = 3 * sizeof(Vec3) + 2 * sizeof(double);
  memory += double(world.bodies.size() * sizeof(Body)) + particles * kParticle;
  // A body takes the memory of some particles: measured on 100,000 in flight.
  const auto bodies = double(world.bodies.size());
  double sum = 2 * memory + (particles + 12 * bodies) * method.particle_memory;
  if (has_contact(world) || has_strings(world)) sum += kContact * particles;
  sum += kJoint * double(world.joints.size());
  if (method.eliminates) {
    const double columns = meeting(world);
    sum += sizeof(double) * columns * (links + 2 * columns);
  }
  if (is_dense(settings)) sum += kDense * links * links;
  return sum;
}

}  // namespace taut
