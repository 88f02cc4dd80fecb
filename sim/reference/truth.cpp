// The method `truth`: constraint multipliers and projection under an integrator of high order that
// controls its error. Among obstacles and strings it goes from event to event.
#include <algorithm>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "sim/contact/contact_motion.h"
#include "sim/links/mechanism.h"
#include "sim/links/tension.h"
#include "sim/motion/stop.h"
#include "sim/reference/methods.h"
#include "sim/run/error_estimate.h"
#include "sim/run/method.h"

namespace taut::reference {
namespace {

// Runge-Kutta-Fehlberg 7(8) with error control, by Boost, as the truth steps with it.

namespace odeint = boost::numeric::odeint;

using State = std::vector<double>;

/// Far beyond what is stable errors overflow, and what is not a number compares as no error at all.
inline bool is_finite(const State& state) {
  return std::ranges::all_of(state, [](double x) { return std::isfinite(x); });
}

// Workspaces follow the state's size, which interventions change.
using Explicit = odeint::runge_kutta_fehlberg78<
    State, double, State, double, odeint::algebra_dispatcher<State>::algebra_type,
    odeint::operations_dispatcher<State>::operations_type, odeint::always_resizer>;
using Stepper = odeint::controlled_runge_kutta<Explicit>;

// The truth among obstacles and of strings: smooth motion from event to event.

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

/// Runge-Kutta-Fehlberg 7(8) on ContactMotion, `local_error` in a step (m, m/s). Where a step
/// passes an event it is taken again, to end there. For worlds with obstacles or strings.
std::unique_ptr<Method> make_event_driven(double local_error) {
  return std::make_unique<EventDriven>(local_error);
}

constexpr std::string_view kTruth = "truth";
constexpr double kFirstStep = 1e-4;  // s
constexpr double kShortest = 1e-12;  // s: a step below it says that the motion is not smooth
constexpr int kMostSteps = 3000;     // steps in so short a time: rounding makes them, and no motion
constexpr double kBriefTime = 5e-4;  // s
constexpr double kAtOnce = 1e-4;     // s, in which rope that runs out has done so
constexpr double kTolerance = 1e5;   // of `direct` where it stands in, over the local error

/// The worlds that this file's solvers follow by themselves.
const Abilities& own_abilities() {
  static const Abilities own{
      Features::all() - Feature::joint_in_flow - kConnectorContact -
          Features{Feature::bead_pairs, Feature::span, Feature::clamp_on_body,
                   Feature::applied_force, Feature::string_rebound},
      {{kMaterialFeatures | kJointFeatures, kContactFeatures | Feature::strings},
       {kReelFeatures, kContactFeatures | Feature::strings},
       {kReelFeatures,
        kJointFeatures | kUnlikeReels | Feature::stretch,
        {},
        Apart::Within::connector}}};
  return own;
}

/// Whether anything holds links at two places.
bool may_be_at_full_length(const World& world) {
  return !world.joints.empty() || has_winches(world) ||
         std::ranges::any_of(world.connectors,
                             [](const Connector& connector) { return connector.holds.size() > 1; });
}

class Multipliers final : public Method {
 public:
  explicit Multipliers(const Settings& settings)
      : local_error_(number(settings, "local_error")),
        stepper_(reference::odeint::make_controlled(number(settings, "local_error"),
                                                    number(settings, "local_error"),
                                                    reference::Explicit())),
        among_obstacles_(make_event_driven(number(settings, "local_error"))) {}

  void advance(World& world, double until) override;

 private:
  void advance_own(World& world, double until);
  void advance_by_direct(World& world, double until);
  void prepare(const World& world);
  void step(double& time, double until);
  void slope(const reference::State& state, reference::State& derivative, double time);
  void project(double time);
  bool ends_before_change(double from, double& time);
  [[noreturn]] void give_up(double time, std::size_t row, const char* what) const;

  double local_error_;
  reference::Stepper stepper_;
  Mechanism mechanism_;
  TensionSystem system_;
  Projection projection_;
  PulleyFriction friction_;
  bool built_ = false;
  const World* world_ = nullptr;
  std::uint64_t topology_ = 0;
  std::optional<std::uint64_t> required_;  // the topology of which all features are followed
  std::vector<double> keys_;               // s, rising: times at which a path is not smooth
  double step_ = kFirstStep;               // s, the next one to try
  double brief_ = 0;                       // s, from which on steps are counted
  int short_ = 0;                          // how many there were since
  reference::State state_, before_, scratch_, right_, tension_;
  std::unique_ptr<Method> among_obstacles_;
  std::unique_ptr<Method> direct_;  // stands in from then on
};

void Multipliers::prepare(const World& world) {
  step_ = kFirstStep;
  mechanism_.rebuild(world);
  system_.rebuild(mechanism_);
  projection_.rebuild(mechanism_);
  friction_.rebuild(mechanism_);
  for (reference::State* state : {&state_, &before_, &scratch_})
    state->reserve(mechanism_.state_room());
  for (reference::State* rows : {&right_, &tension_}) rows->reserve(mechanism_.row_room());
  if (!built_) stepper_.adjust_size(reference::State(mechanism_.state_room()));
  built_ = true;
  topology_ = world.topology;
  right_.resize(mechanism_.unknowns());
  tension_.resize(right_.size());
  keys_.clear();
  const auto add = [&](const std::shared_ptr<const Path>& path) {
    if (!path) return;
    for (const PathKey& key : path->keys()) keys_.push_back(key.time);
  };
  add(world.air.gusts);
  for (const Body& body : world.bodies) add(body.path);
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      add(hold.to.path);
      add(hold.turn);
    }
    if (!connector.winch) continue;
    for (const auto& path : connector.winch->paths) add(path);
  }
  std::ranges::sort(keys_);
}

void Multipliers::advance(World& world, double until) {
  if (required_ != world.topology) {
    require(kTruth, world);
    if (!direct_ && find_refusal(own_abilities(), world)) {
      direct_ = make_method("direct", {{"tolerance", kTolerance * local_error_}});
    }
  }
  required_ = world.topology;
  if (!direct_) {
    try {
      return advance_own(world, until);
    } catch (const Diverged&) {  // `world` is where it was
      direct_ = make_method("direct", {{"tolerance", kTolerance * local_error_}});
    }
  }
  advance_by_direct(world, until);
}

/// Where motion is no matter of these solvers, or goes on where they give up: a tight tolerance of
/// the implicit step, which shares no code with them but the mechanism.
void Multipliers::advance_by_direct(World& world, double until) {
  const Counters before = direct_->counters();
  try {
    direct_->advance(world, until);
  } catch (const Diverged& end) {
    throw Diverged(std::string(kTruth), end.time, end.step, end.connector, end.link, end.reason);
  }
  counters_ += direct_->counters();
  counters_ -= before;
  for (Event& event : direct_->take_events()) events_.push_back(event);
}

void Multipliers::advance_own(World& world, double until) {
  if (has_contact(world) || has_strings(world)) {
    among_obstacles_->advance(world, until);
    counters_ = among_obstacles_->counters();
    return;
  }
  const bool fresh = !built_ || world.topology != topology_;
  if (fresh) prepare(world);
  world_ = &world;
  mechanism_.load(world, state_);
  double time = world.time;
  if (fresh) {
    project(time);
    if (friction_.any()) friction_.decide(mechanism_, system_, time, state_);
  }
  while (time < until) {
    const auto key = std::ranges::upper_bound(keys_, time);
    step(time, key == keys_.end() ? until : std::min(*key, until));
  }
  mechanism_.store(state_, until, world);
}

/// One accepted step, not beyond `until`.
void Multipliers::step(double& time, double until) {
  const auto system = [this](const reference::State& x, reference::State& dxdt, double t) {
    slope(x, dxdt, t);
  };
  check_stop();
  const double wanted = step_;
  const bool last = time + wanted * (1 + 1e-9) >= until;
  const double from = time;
  double taken = last ? until - time : wanted;
  before_ = state_;
  const bool fails = stepper_.try_step(system, state_, time, taken) == reference::odeint::fail;
  if (fails || !reference::is_finite(state_)) {
    ++counters_.rejected;
    if (!fails) {
      state_ = before_;
      time = from;
      taken = (last ? until - from : wanted) / 4;
    }
    step_ = taken;  // now shorter
    if (!(step_ > kShortest)) give_up(time, 0, "the motion is not smooth");
    return;
  }
  const double next = last ? std::max(wanted, taken) : taken;
  if (last) time = until;
  if (const auto connector = mechanism_.run_through(time, state_.data())) {
    if (time - from < kAtOnce) {
      throw Diverged(std::string(kTruth), time, counters_.steps,
                     world_->connectors[*connector].name, 0, kRunThrough);
    }
    ++counters_.rejected;
    state_ = before_;
    step_ = (time - from) / 4;
    time = from;
    return;
  }
  if (friction_.any() && !ends_before_change(from, time)) return;
  step_ = next;
  ++counters_.steps;
  if (!(std::abs(time - brief_) < kBriefTime)) {
    brief_ = time;
    short_ = 0;
  }
  if (++short_ > kMostSteps) {
    give_up(time, 0,
            may_be_at_full_length(*world_)
                ? "no step is small enough: the links may be at their full length between what "
                  "holds them"
                : "no step is small enough");
  }
  project(time);
  mechanism_.follow(time, state_);
}

/// Whether rope at pulleys does all along the step what it did at its begin. If it does not, the
/// step is undone, and the next one ends about where that changes.
bool Multipliers::ends_before_change(double from, double& time) {
  project(time);
  const double off = friction_.distance(mechanism_, system_, time, state_);
  if (off < -PulleyFriction::kNear && time - from > kShortest) {
    step_ = (time - from) *
            PulleyFriction::share(friction_.distance(mechanism_, system_, from, before_), off);
    state_ = before_;
    time = from;
    ++counters_.rejected;
    return false;
  }
  if (off <= PulleyFriction::kNear) friction_.decide(mechanism_, system_, time, state_);
  return true;
}

void Multipliers::slope(const reference::State& state, reference::State& derivative, double time) {
  scratch_ = state;
  mechanism_.update(time, scratch_.data());
  mechanism_.right_side(right_);
  system_.assemble(mechanism_);
  system_.solve(right_, tension_);
  ++counters_.solves;
  counters_.cycles += mechanism_.cycles() + system_.cycles();
  mechanism_.differentiate(scratch_.data(), tension_.data(), derivative.data());
}

void Multipliers::project(double time) {
  const Projection::Left left = projection_.lengths(mechanism_, time, state_);
  if (!std::isfinite(left.violation)) give_up(time, left.row, "not finite");
  if (left.violation > Projection::kKept) give_up(time, left.row, "the length cannot be kept");
  projection_.rates(mechanism_, time, state_);
}

void Multipliers::give_up(double time, std::size_t row, const char* what) const {
  const auto* pressed =
      material::pressed_together(mechanism_.material().stretches(), state_.data());
  if (pressed) {
    throw Diverged(std::string(kTruth), time, counters_.steps,
                   world_->connectors[pressed->connector].name, pressed->link,
                   material::kPressedTogether);
  }
  const auto& rows = mechanism_.rows();
  const Row at = row < rows.size() ? rows[row] : Row();  // where all links stretch there is none
  throw Diverged(std::string(kTruth), time, counters_.steps,
                 world_->connectors.empty() ? "" : world_->connectors[at.connector].name, at.link,
                 what);
}

}  // namespace

MethodInfo truth_method() {
  return {.name = kTruth,
          .summary = "the converged solution, which the others are scored against",
          .settings = {{"local_error",
                        "Error allowed in a step, in metres and metres per second. Raising it "
                        "costs less and errs more.",
                        "1", 1e-12, 1e-15, 1e-3}},
          .make = [](const Settings& settings) -> std::unique_ptr<Method> {
            return std::make_unique<Multipliers>(settings);
          },
          .reference = true,
          .abilities = find_method("direct")->abilities,
          .companion =
              [](const MethodInfo& truth, const Settings& settings) {
                return with_tolerance_raised(truth, settings, "local_error");
              },
          .particle_memory = 1500,
          .eliminates = true};
}

}  // namespace taut::reference
