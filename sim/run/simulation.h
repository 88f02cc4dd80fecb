// A simulation: a world, a method, and what happens at which time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sim/interventions/interventions.h"
#include "sim/run/islands.h"
#include "sim/run/method.h"
#include "sim/run/reduced.h"
#include "sim/run/saved_state.h"
#include "sim/run/trajectory.h"
#include "sim/topology/components.h"
#include "sim/world/world.h"

namespace taut {

/// Steps a world through time. Frame times are exact multiples, so the same world, method and times
/// give the same bits.
class Simulation {
 public:
  /// The timeline must be without flaws that find_flaw() finds. Entries at the world's time happen
  /// with the first advance. Bodies whose model is a link become links of the world that is
  /// stepped.
  Simulation(World world, std::unique_ptr<Method> method, Timeline timeline = {});

  /// Advances to `time` (s, not before the present), and does what the timeline has until then; a
  /// time that is a rounding off `time` or the present is the same. Cuts a connector where a
  /// tension passes Connector::breaks_at: a method that chooses its steps within a microsecond,
  /// another one at the end of a step. Tensions are those of forces_of(); an impact breaks nothing.
  /// The method's events are those of this call afterwards. Throws Diverged, also if the state
  /// there is not finite, BadIntervention, and what the stop check throws (see set_stop_check()):
  /// after that the world is at no one time, and a further call throws std::runtime_error.
  void advance_to(double time);

  /// The present as bytes, from which load() of another simulation of the same world and timeline
  /// goes on, by whatever method: a method of equal steps without friction as if it had not
  /// stopped, to the bit. Throws BadState where a pin of interventions() is on a path of its own.
  std::string save() const;
  /// Goes on from such bytes, where the method begins anew. Throws BadState, and changes nothing:
  /// they are of another world or timeline, or damaged.
  void load(std::string_view bytes);

  /// Goes on from `world`, a state of this simulation's own at its present or later, where the
  /// method begins anew.
  void go_on_from(const World& world);

  const World& world() const { return world_; }

  /// The visible state, with all bodies of the world that was given; every connector keeps its
  /// particles from the first frame to the last: those of divided(), whatever the timeline has
  /// pinned and cut so far; a connector that breaks becomes two. Without a timeline it is the
  /// world's own.
  Snapshot state() const;

  /// The method, or all of them where islands have one each.
  const Method& method() const { return *method_; }
  /// Calls say(own, other's) for the method of each island; the other simulation has the same
  /// world and timeline.
  void tell(const Simulation& other, void (*say)(Method& own, const Method& others));

  /// A link that broke: the cut that did it, as a timeline has it, and its tension (N).
  struct Break {
    TimedCut cut;
    std::string connector;  // the part that had the link
    std::size_t link = 0;   // of that part
    double tension = 0;
  };
  /// In order of time, since the start.
  const std::vector<Break>& breaks() const { return breaks_; }

  /// The events since the last advance, which are nobody else's from now on.
  std::vector<Event> take_events() { return method_->take_events(); }

  /// For unforeseen changes between two advances. Changes by hand are made consistent before the
  /// next one (refresh()), however long the reference is kept.
  World& world() {
    is_shared_ = true;
    return world_;
  }
  Interventions& interventions() { return interventions_; }

 private:
  struct Entry {
    enum class Kind { release, cut, pin };
    double time;  // s
    Kind kind;
    std::size_t connector;  // of the start
    std::size_t index;      // in the timeline's list
  };
  void follow_timeline(double time);
  void watch_tensions(double time);
  double next_look(double time) const;
  bool break_link();
  void go_to(const Entry& entry, double time);
  std::vector<Parts::Place> places_at(double time) const;
  void catch_up(double time);
  void refuse_not_finite() const;
  Parts::Place place_of(const Entry& entry) const;
  [[noreturn]] void refuse(const Entry& entry, std::string what);
  void enact(const Entry& entry);
  bool enact_several();
  std::vector<const Entry*> frees_beads(std::span<const Entry> entries) const;
  void look_at_beads(std::span<const Entry* const> freed);
  void show();
  void begin_anew(std::span<const std::size_t> wholes);
  void divide_shown(std::size_t whole, double along);

  /// A connector of divided(): its particles' places on the connector that it is a part of.
  struct Shown {
    std::size_t whole = 0;
    std::vector<double> along;  // m, rising
  };

  World world_;
  StateParts state_parts_;
  bool is_shared_ = false;   // somebody may change it
  bool is_stopped_ = false;  // within a step, by the stop check
  std::uint64_t begun_ = 0;  // how often the method began anew
  BodiesAsLinks bodies_as_links_;
  std::unique_ptr<Method> method_;
  Islands* islands_ = nullptr;  // the method, where there are some
  bool left_behind_ = false;    // parts of the world, by the method
  Interventions interventions_;
  Timeline timeline_;
  Parts uncut_, parts_;
  std::vector<Shown> shown_;
  std::vector<std::size_t> shown_row_;  // indices of them, as they follow each other
  std::vector<Entry> entries_;          // in order of time
  std::size_t next_ = 0;                // of the entries
  std::vector<Break> breaks_;
  /// A look at the tensions: the largest as a share of what breaks its link.
  struct Look {
    double time = 0;  // s
    double share = 0;
  };
  std::optional<Look> before_, look_;  // the last two
  std::vector<std::uint64_t> pins_;    // numbers of the timeline's pins, 0 before they are set
};

// The states of a simulation between its frames.

/// The states of a simulation between two frames, by another simulation that stops more often. A
/// method that chooses its steps takes other steps with such stops: so the other simulation
/// restarts at every frame in the state of the first, and its difference at the next frame is taken
/// back evenly.
class Between {
 public:
  /// `other`: a simulation at its start, of the same world, method settings and timeline.
  explicit Between(Simulation other);

  /// The states at `times` (s, rising, between the two frames) of a simulation that was at `first`
  /// and is at `last` now. Throws as Simulation::advance_to() does; unusable after that.
  std::vector<Snapshot> states(const World& first, const std::vector<double>& times,
                               const Snapshot& last);

 private:
  Simulation simulation_;
};

// How fast the particles of a simulation's states are.

/// The velocities of what Simulation::state() shows: the same particles of the same connectors,
/// whatever the timeline has pinned and cut so far.
class ShownVelocities {
 public:
  /// `start` and `timeline` are those that the simulation was made with.
  ShownVelocities(const World& start, const Timeline& timeline);

  /// [connector][particle], m/s.
  std::vector<std::vector<Vec3>> of(const Simulation& simulation) const;

 private:
  struct Shown {
    std::size_t whole = 0;      // the connector of the start that it is a part of
    std::vector<double> along;  // m on that, rising
  };
  std::vector<Connector> start_;
  std::vector<TimedCut> cuts_;  // in order of time
  std::vector<bool> shifted_;   // [connector of the start] a body stands before its first particle
  std::vector<Shown> shown_;
  std::vector<std::size_t> shown_row_;  // indices of them, as they follow each other
};

// The memory of a simulation, known before it starts.

/// Bytes, at most, of `method` with a full set of settings on `world`, which is copied once.
double memory_of(const MethodInfo& method, const World& world, const Settings& settings);

}  // namespace taut
