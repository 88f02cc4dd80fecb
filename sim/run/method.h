// Methods that advance a world: the interface that each implements, and the list of them.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "sim/features/features.h"
#include "sim/run/forces.h"
#include "sim/topology/components.h"
#include "sim/world/world.h"

namespace taut {

/// The value of one setting of a method.
using Setting = std::variant<double, bool, std::string>;
using Settings = std::map<std::string, Setting, std::less<>>;

/// A method's description of a setting; scene files, --help and sweeps are built from it.
struct SettingInfo {
  std::string_view name;
  std::string_view meaning;  // what it is; of a number also what raising it does
  std::string_view unit;     // "m", "s", "1" for a pure number, "" for flags and choices
  Setting fallback;          // the default
  double minimum = 0;        // numbers only; the value itself is refused where `above` is set
  double maximum = 1e300;
  bool above = false;
  bool whole = false;                          // numbers only: integers
  std::vector<std::string_view> choices = {};  // strings only
  /// The values that sweeps go through, cheap to dear; empty: sweeps leave the setting alone.
  std::vector<Setting> sweep = {};
};

/// Counts of events while stepping, for benchmarks and reports; independent of the machine.
struct Counters {
  std::uint64_t steps = 0;
  std::uint64_t solves = 0;       // systems solved, or passes over all links
  std::uint64_t rejected = 0;     // steps undone by an error control
  std::uint64_t handed_over = 0;  // steps left to a scheme of higher order
  /// The processor's cycles for all that, as the operations in the loops add up: two additions or
  /// multiplications a cycle where none waits for another, four cycles each where they do; five and
  /// fifteen for a division or a root.
  double cycles = 0;

  Counters& operator+=(const Counters& other);
  Counters& operator-=(const Counters& other);
};

/// Something that happens at a moment. A span, or a link that only pulls, goes taut, with an
/// impulse, or slack. The two sides of a contact hit each other, or pass on the impulse of another
/// hit, leave each other, begin to slide, or come to stick. A link breaks (Connector::breaks_at).
struct Event {
  enum class Kind { taut, impulse, slack, hit, leave, slide, stick, breaks };
  Kind kind = Kind::taut;
  double time = 0;                    // s
  std::size_t connector = 0;          // index into World::connectors; not of contacts
  std::size_t span = 0;               // index of the span on it, or of the link
  double size = 0;                    // N s: of an impulse, and of a hit; N: of what breaks
  Forces::Side one = {}, other = {};  // of contacts
  Vec3 place = Vec3::Zero();          // m, of contacts
  bool of_contact = false;
};

/// The name of a kind of event: taut, impulse ...
std::string_view kind_name(Event::Kind kind);

/// The event of a part of a world, with the world's indices in place of the part's: `connectors`
/// and `bodies` list the world's index of each connector and body of the part.
Event in_world(Event event, std::span<const std::size_t> connectors,
               std::span<const std::size_t> bodies);

/// The simulation cannot go on: not finite, or beyond any sense. Says where.
class Diverged : public std::runtime_error {
 public:
  Diverged(std::string method, double time, std::uint64_t step, std::string connector,
           std::size_t link, std::string what);
  /// Of a body, which stands in `connector` then.
  Diverged(std::string method, double time, std::uint64_t step, const Body& body,
           const std::string& what);
  /// Of a world that the method refuses: of no step and no connector.
  Diverged(std::string method, double time, std::string refusal);
  std::string method, reason;
  double time;         // s
  std::uint64_t step;  // counted from the start of the simulation
  std::string connector;
  std::size_t link;
};

/// Advances worlds. One object per simulation: it may keep workspaces and warm starts, which it
/// rebuilds when World::topology changes. advance() allocates nothing after the first call.
class Method {
 public:
  virtual ~Method() = default;

  /// Moves `world` from its time to `until` (s), in as many steps as the method takes. Throws
  /// Diverged. Held particles and driven bodies are at their places when it returns.
  virtual void advance(World& world, double until) = 0;

  /// The same for a moment at which something will be done to `world` at these places, and nothing
  /// else before the next call. True where parts were left behind that this does not concern: their
  /// states are those of an earlier time until the next advance(), which may be to the same time.
  virtual bool advance_near(World& world, double until, std::span<const Parts::Place> places) {
    (void)places;
    advance(world, until);
    return false;
  }

  const Counters& counters() const { return counters_; }
  /// Events since the start or the last clear_events(), in order of time; empty for methods that
  /// know none.
  const std::vector<Event>& events() const { return events_; }
  /// Forgets the events and keeps their memory. Whoever advances for long calls it now and then.
  void clear_events() { events_.clear(); }
  /// Adds what happened to the world beside the method's steps.
  void add_event(const Event& event) { events_.push_back(event); }
  /// The same events, which the method forgets.
  std::vector<Event> take_events() { return std::exchange(events_, {}); }

  /// As make_method() was asked for it.
  std::string called = "method";
  /// s, of its steps, as its settings have it; zero: it chooses them.
  double step = 0;
  /// Makes another one with the same settings, where who made this one has said how.
  std::function<std::unique_ptr<Method>()> again;

 protected:
  Counters counters_;
  std::vector<Event> events_;
};

/// A form of a method that tables show as a row of its own, beside the method as it is.
struct MethodForm {
  std::string_view name;  // "dense"; tables write METHOD:NAME
  Settings settings;      // what it sets
};

struct Companion;

/// Which of the paper's methods a method is.
enum class PaperRole {
  none,
  proposed,             // the method that the paper is about
  dynamic_constraints,  // its reference
  package,              // the commercial package, SD/FAST
  package_of_today,     // what stands for it where it is not at hand
  particle_system,
};

/// A row of the list of methods.
struct MethodInfo {
  std::string_view name;     // as in scene files
  std::string_view summary;  // one line
  std::vector<SettingInfo> settings;
  /// Makes the method with a full set of valid settings.
  std::unique_ptr<Method> (*make)(const Settings& settings);
  /// Why this build does not have the method, in two or three words for tables; empty: it does.
  std::string_view missing = {};
  /// The others are judged by it: it stands in no comparison of its own.
  bool reference = false;
  PaperRole paper_role = PaperRole::none;
  std::vector<MethodForm> forms = {};
  /// A full set of settings with values for `world` in place of the zeros that leave them open;
  /// null: zeros stay.
  Settings (*fit)(const World& world, Settings settings) = nullptr;
  /// The longest step (s) that theory allows while `world` hangs at rest below what holds it, with
  /// a full set of settings; null: there is no such theory.
  double (*longest_step)(const World& world, const Settings& settings) = nullptr;
  std::string_view longest_step_law = {};  // the law in a few words, for legends
  /// The features that it follows; advance() throws Diverged for a world that uses others.
  Abilities abilities = {};
  /// Interventions on a part of a connector, between two holds, leave its other parts to their own
  /// steps, where they are rigid links and touch nothing (Method::advance_near()).
  bool parts_go_on = false;
  /// The companion of a run with a full set of settings, coarser or finer, so that ErrorEstimate
  /// tells its error; null: nothing is known of how the error depends on the settings.
  Companion (*companion)(const MethodInfo& method, const Settings& settings) = nullptr;
  /// Bytes for each particle, beside the world; measured on ropes of 20,000 particles, in a single
  /// span. The default is that of the hungriest.
  double particle_memory = 8000;
  /// Solves by TensionSystem, which has dense columns for links that meet in a free body.
  bool eliminates = false;
  /// Several must not run at the same time: their libraries may share global state.
  bool runs_alone = false;
  /// Of each body, whether the method steps it as one more link, which is exact where it hangs by
  /// one point and moves in a plane; as far as the world's present state tells. Null: none.
  std::vector<bool> (*steps_as_links)(const World& world) = nullptr;
};

/// Why the method refuses `world`, as words() has it, or empty.
std::string refusal(const MethodInfo& method, const World& world);
/// Whether the method follows all features of `world`; else its advance() throws Diverged.
bool follows(const MethodInfo& method, const World& world);
/// For advance() of the method of that name where a world or its topology is new: throws Diverged
/// with the refusal. Allocates nothing for a world that is followed.
void require(std::string_view method, const World& world);
/// The names of the methods that follow all features of `world`, as "xpbd, direct"; or empty.
std::string methods_that_follow(const World& world);

/// Every method, in the order in which tables show them.
std::span<const MethodInfo> all_methods();

/// The method of that name, or null.
const MethodInfo* find_method(std::string_view name);
/// The method of that role in the paper, missing or not, or null.
const MethodInfo* find_method(PaperRole role);

/// The setting of that name, or null.
const SettingInfo* find_setting(const MethodInfo& method, std::string_view name);

/// Why there is no method of that name to be made, or empty.
std::string method_complaint(std::string_view name);

/// Why `settings` cannot be given to `method` (unknown name, wrong type, out of range), or empty.
std::string complaint(const MethodInfo& method, const Settings& settings);

/// `settings` with the method's own choice for those that it leaves out.
Settings with_defaults(const MethodInfo& method, Settings settings);

/// The same with what the method chooses for `world` where they leave it open.
Settings with_defaults(const MethodInfo& method, Settings settings, const World& world);

/// Makes a method; settings left out take their defaults. Throws std::invalid_argument with the
/// complaint when a setting is wrong or the name is unknown.
std::unique_ptr<Method> make_method(std::string_view name, const Settings& settings);

/// The message of Diverged for Mechanism::run_through().
inline constexpr const char* kRunThrough = "the rope has run through its pulley";
/// Whether a free body is on a connector that stretches, bends or meets the air.
bool has_laden_materials(const World& world);
/// Whether a connector of length 0, a hinge, is on a free body.
bool has_hinges(const World& world);

// Typed access for the methods' own code; the setting must exist.
double number(const Settings& settings, std::string_view name);
bool flag(const Settings& settings, std::string_view name);
const std::string& text(const Settings& settings, std::string_view name);

/// The setting `step` (s); zero where none is named, or there is none.
double step_of(const Settings& settings);

/// The setting `step` (s) of a method whose steps are all equal; sweeps go through `sweep` values
/// of it, 1/60 s and each half of the one before. `open` says what zero, then the default, takes;
/// empty: zero is refused.
SettingInfo step_setting(std::string_view open, int sweep);
inline constexpr std::string_view kStableStep =
    "Length of a time step; 0: a share of the longest stable step. Raising it costs less and errs "
    "more, until the run diverges.";

/// The most steps that a run may take: so many are hours of the cheapest ones.
inline constexpr double kMostRunSteps = 1e10;

/// Why a run of so many seconds cannot take the step of `settings`, or empty: it would take more
/// than kMostRunSteps.
std::string step_complaint(const Settings& settings, double duration);

/// How many equal steps of at most `step` (s) fill `interval` (s); exact where step divides it.
/// Throws std::invalid_argument where they are more than kMostRunSteps.
std::uint64_t step_count(double interval, double step);

/// The times of the steps that take a world from `from` to `until`. Where both are whole multiples
/// of `step`, so is every time between them and `dt` is `step` itself, so that a trajectory has the
/// same bits however the frames divide it. Step i goes from at(i) to at(i + 1); set World::time to
/// `until` after the last.
struct StepTimes {
  StepTimes(double from, double until, double step);

  double at(std::uint64_t i) const;  // s

  std::uint64_t count = 0;
  double dt = 0;  // s

 private:
  double from_, until_;
  double first_ = 0;
  bool on_grid_ = false;
};

// Methods that join the list from outside of it.

/// Adds a method to all_methods(), for every part of the program: before the one called `before`,
/// or at the end. Call before anything else has looked at the list; `method` names storage that
/// outlives the program.
void add_method(MethodInfo method, std::string_view before = {});

// A method with its settings: what a scene asks for, what studies compare, a row of every table.

struct MethodChoice {
  std::string name;
  Settings settings;  // those that differ from the method's own choice
};

/// Every setting of the method, which must exist: with its own choice for those left out.
Settings with_defaults(const MethodChoice& choice);

/// The value as text; numbers with so many significant digits, zero: as many as tell it exactly.
std::string setting_text(const Setting& value, int digits = 0);

/// "springs (integrator rk4, step 0.001)".
std::string describe(const MethodChoice& choice);
/// The settings alone: "integrator rk4, step 0.001"; "defaults" where none is named.
std::string describe(const Settings& settings);

}  // namespace taut
