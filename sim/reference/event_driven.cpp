#include "sim/reference/event_driven.h"

#include <algorithm>
#include <cmath>

#include "sim/contact/contact_motion.h"
#include "sim/motion/stop.h"
#include "sim/reference/runge_kutta.h"

namespace taut::reference {
namespace {

constexpr double kStepAfterEvent = 1e-5;  // s
constexpr double kShortestStep = 1e-12;   // s: a step below it says that the motion is not smooth
constexpr double kLongest = 1.0 / 480;    // s: events come in order, and none is passed unseen
constexpr double kSlowest = 1e-4;         // m/s, of bounces: they rise by half a nanometre
constexpr double kLocated = 1e-14;        // s
constexpr int kTrials = 60;               // to locate an event
constexpr double kBrief = 0.01;           // s
constexpr int kMostEvents = 3000;         // in so short a time: they follow no more
constexpr int kMostTried = 200'000;       // steps tried in it without any: of a rope held stretched

class EventDriven final : public Method {
 public:
  explicit EventDriven(double local_error)
      : stepper_(
            reference::odeint::make_controlled(local_error, local_error, reference::Explicit())) {}

  void advance(World& world, double until) override;

 private:
  void prepare(const World& world);
  void step(double until);
  void count(int& number, int most, const char* what);
  void locate(double h);
  double attempt(double h);
  std::size_t first_event(double h, double& share) const;
  void slope(const reference::State& state, reference::State& derivative, double time);
  [[noreturn]] void give_up(std::size_t row, const char* what) const;

  reference::Stepper stepper_;
  reference::Explicit explicit_;
  contact::ContactMotion motion_;
  const World* world_ = nullptr;
  bool built_ = false;
  std::uint64_t topology_ = 0;
  std::vector<double> keys_;  // s, rising: times at which a path is not smooth
  double time_ = 0, step_ = kStepAfterEvent;
  double brief_ = 0;  // s, from which on events and steps are counted
  int located_ = 0, tried_ = 0;
  reference::State state_, next_;
  std::vector<double> values_, next_values_;  // of the events' functions, here and after the step
};

void EventDriven::prepare(const World& world) {
  step_ = kStepAfterEvent;
  motion_.rebuild(world, kSlowest);
  built_ = true;
  topology_ = world.topology;
  keys_.clear();
  const auto add = [&](const std::shared_ptr<const Path>& path) {
    if (!path) return;
    for (const PathKey& key : path->keys()) keys_.push_back(key.time);
  };
  for (const Body& body : world.bodies) add(body.path);
  for (const Obstacle& obstacle : world.obstacles) add(obstacle.path);
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) add(hold.to.path);
  }
  std::ranges::sort(keys_);
}

void EventDriven::advance(World& world, double until) {
  const bool fresh = !built_ || world.topology != topology_;
  if (fresh) prepare(world);
  world_ = &world;
  motion_.load(world, state_);
  time_ = world.time;
  try {
    if (fresh) {
      motion_.begin(time_, state_);
      if (!reference::is_finite(state_)) give_up(0, "not finite");
    }
    while (time_ < until) {
      const auto key = std::ranges::upper_bound(keys_, time_);
      step(key == keys_.end() ? until : std::min(*key, until));
    }
  } catch (const contact::ContactMotion::Unresolved& stop) {
    give_up(stop.row, stop.what);
  }
  motion_.store(state_, until, world);
}

/// Counts another one, and gives up where there are too many in a brief time.
void EventDriven::count(int& number, int most, const char* what) {
  if (time_ > brief_ + kBrief) {
    brief_ = time_;
    located_ = tried_ = 0;
  }
  if (++number > most) give_up(0, what);
}

/// One step, not beyond `until`.
void EventDriven::step(double until) {
  check_stop();
  count(tried_, kMostTried, "the motion is not smooth");
  const double wanted = std::min(step_, kLongest);
  const bool last = time_ + wanted * (1 + 1e-9) >= until;
  double taken = last ? until - time_ : wanted, end = time_;
  const double h = taken;
  next_ = state_;
  const auto system = [this](const reference::State& x, reference::State& dxdt, double t) {
    slope(x, dxdt, t);
  };
  const bool fails = stepper_.try_step(system, next_, end, taken) == reference::odeint::fail;
  if (fails || !reference::is_finite(next_)) {
    ++counters_.rejected;
    step_ = fails ? taken : h / 4;  // now shorter
    if (!(step_ > kShortestStep)) give_up(0, "the motion is not smooth");
    return;
  }
  motion_.project(time_ + h, next_);
  if (!reference::is_finite(next_)) give_up(0, "not finite");
  motion_.events(time_, state_, values_);
  motion_.events(time_ + h, next_, next_values_);
  if (std::ranges::any_of(next_values_, [](double value) { return value < 0; })) {
    locate(h);
    return;
  }
  state_.swap(next_);
  time_ = last ? until : time_ + h;
  step_ = last ? std::max(wanted, taken) : taken;
  ++counters_.steps;
}

/// The state after a step of h (s), and the functions of events there.
double EventDriven::attempt(double h) {
  const auto system = [this](const reference::State& x, reference::State& dxdt, double t) {
    slope(x, dxdt, t);
  };
  check_stop();
  explicit_.do_step(system, state_, time_, next_, h);
  motion_.project(time_ + h, next_);
  motion_.events(time_ + h, next_, next_values_);
  return h;
}

/// The event that seems to come first within the step, and after which share of it.
std::size_t EventDriven::first_event(double h, double& share) const {
  std::size_t first = values_.size();
  share = 1;
  for (std::size_t i = 0; i < values_.size(); ++i) {
    if (!(next_values_[i] < 0)) continue;
    const double from = std::max(values_[i], 0.0);
    const double own = from / (from - next_values_[i]);
    if (first < values_.size() && own >= share) continue;
    first = i;
    share = own;
  }
  return h > 0 ? first : values_.size();
}

/// Goes to the first event within a step of h (s): the last state before it and the first after it
/// come together, by the rule of Illinois and by halves in turn.
void EventDriven::locate(double h) {
  double before = 0, after = h, share = 1;
  for (int i = 0; i < kTrials && after - before > kLocated; ++i) {
    first_event(after, share);
    const bool halves = i % 3 == 2;
    double middle = halves ? (before + after) / 2 : before + share * (after - before);
    middle = std::clamp(middle, before + 0.01 * (after - before), after - 1e-3 * (after - before));
    const std::vector<double> kept = next_values_;
    attempt(middle);
    if (std::ranges::any_of(next_values_, [](double value) { return value < 0; })) {
      after = middle;
    } else {
      before = middle;
      values_.swap(next_values_);
      next_values_ = kept;
    }
  }
  attempt(after);
  if (!reference::is_finite(next_)) give_up(0, "not finite");
  time_ += after;
  count(located_, kMostEvents, "too many events");
  tried_ = 0;
  state_.swap(next_);
  ++counters_.steps;
  motion_.resolve(time_, state_);
  step_ = std::max(after, kStepAfterEvent);
}

void EventDriven::slope(const reference::State& state, reference::State& derivative, double time) {
  motion_.differentiate(time, state, derivative);
  counters_.solves = motion_.solves();
  counters_.cycles += 2 * motion_.mechanism().cycles();
}

void EventDriven::give_up(std::size_t row, const char* what) const {
  if (motion_.mechanism().rows().empty()) {
    throw Diverged("truth", time_, counters_.steps,
                   world_->bodies.empty() ? "" : world_->bodies[0].name, 0, what);
  }
  const Row& at = motion_.mechanism().rows()[row];
  throw Diverged("truth", time_, counters_.steps, world_->connectors[at.connector].name, at.link,
                 what);
}

}  // namespace

std::unique_ptr<Method> make_event_driven(double local_error) {
  return std::make_unique<EventDriven>(local_error);
}

}  // namespace taut::reference
