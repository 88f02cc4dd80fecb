// Interventions: unforeseen changes of a world between two steps.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sim/world/hanging.h"
#include "sim/world/places.h"
#include "sim/world/ties.h"
#include "sim/world/world.h"

namespace taut {

// Where pins are.

struct PinnedHold {
  Connector* connector = nullptr;
  std::size_t hold = 0;
};

/// The hold of a pin, or null; looks at the connector `first` before the others.
inline PinnedHold find_pin(World& world, std::uint64_t pin, std::size_t first) {
  if (pin == 0) return {};
  const auto find_on = [&](Connector& connector) -> PinnedHold {
    for (std::size_t h = 0; h < connector.holds.size(); ++h) {
      if (connector.holds[h].pin.number == pin) return {&connector, h};
    }
    return {};
  };
  if (first < world.connectors.size()) {
    if (const PinnedHold found = find_on(world.connectors[first]); found.connector) return found;
  }
  for (Connector& connector : world.connectors) {
    if (const PinnedHold found = find_on(connector); found.connector) return found;
  }
  return {};
}

// Keeps World::topology what structure() tells, without a look at what has not changed.

/// Weighs a free body with all that it holds.
inline void reweigh_and_renumber(World& world, const Ties& ties, std::size_t body) {
  world.topology -= structure_of_body(world, body);
  reweigh(world.bodies[body], ties.laden(world, body));
  world.topology += structure_of_body(world, body);
}

// Outcomes of interventions.

/// The outcome of an intervention; all but `done` have changed nothing.
enum class Outcome {
  done,
  no_connector,  // the world has no such connector
  outside,       // not a place along the connector
  no_target,     // no such body or path, or a point that is not finite
  held_there,    // something holds the connector at that place already
  joined_there,  // the connector is joined there, which no cut divides
  out_of_reach,  // farther from another hold than the connector is long between them
  too_near,      // nearer to another hold than the links between them can fold
  no_pin,        // never set, or released already
  has_winch,     // a connector whose length changes is neither pinned nor cut
};

/// Says it in words that end a sentence about the intervention.
std::string_view words(Outcome outcome);

struct Pinned {
  Outcome outcome = Outcome::done;
  std::uint64_t pin = 0;  // the number by which to move and to release it
};

/// A pin, to be set together with others.
struct NewPin {
  double along = 0;              // m of the connector's length, from its first particle
  std::optional<Attachment> to;  // nothing: where it is
  double over = 0;               // s in which it is drawn there
};

struct Divided {
  Outcome outcome = Outcome::done;
  std::size_t connector = 0;  // the index of the new one
};

/// Holds, releases and cuts connectors of a world, as section IV.C of the paper divides them.
/// Places along a connector are metres of its length from its first particle, whatever its shape.
class Interventions {
 public:
  /// Makes room in `world` for so many pins on each connector at a time and so many cuts, so that
  /// neither interventions nor what methods make anew for them allocate; none where so many would
  /// take more than tens of megabytes. They work without room, too. A copy of the world has none.
  void reserve(World& world, std::size_t pins, std::size_t cuts);

  /// Goes on with a world that has been cut already: for each connector, the one of the start that
  /// it is a part of.
  void follow_parts(std::vector<std::size_t> originals);

  /// Holds the connector at `along` (m), and what is joined to it there. A particle is added where
  /// none is: it takes its part of the link's length and no mass, since a held particle's never
  /// acts; so that the others keep theirs, and their momentum. The particle is at its new place at
  /// once, or is drawn there within `over` (s); a free body takes it at once, and its momentum with
  /// it.
  Pinned pin(World& world, std::size_t connector, double along, const Attachment& to,
             double over = 0);

  /// Holds it where it is.
  Pinned pin(World& world, std::size_t connector, double along);

  /// Sets many pins on a connector at once, each on the connector as it is before them all; n pins
  /// on N particles take the time of N + n log n. Their numbers, or none where one of them cannot
  /// be set, a free body is to hold one or two are at one place: then nothing has changed.
  std::vector<std::uint64_t> pin(World& world, std::size_t connector, std::span<const NewPin> pins);

  /// Lets another thing hold what the pin holds.
  Outcome move(World& world, std::uint64_t pin, const Attachment& to, double over = 0);

  /// Joins the spans that the pin divides; a particle that was added for it goes, and the others
  /// of its span move as little as restores their links, all masses counted; a free body where
  /// its span is bent more than particles alone can undo, which allocates. At the time of the pin
  /// itself everything is as it was before it, bit by bit. Refused (`too_near`) while its span is
  /// bent between holds that cannot give way. The pin is looked for on the connector `at` first.
  Outcome release(World& world, std::uint64_t pin, std::size_t at = 0);

  /// Releases many pins of one connector at once, in the time of N + n log n; each span that they
  /// divided is restored as a whole.
  Outcome release(World& world, std::size_t connector, std::span<const std::uint64_t> pins);

  /// Divides a connector for good. The second part becomes a connector of its own; a particle at
  /// the cut is shared by both, and where none is its mass comes from its neighbours. A joint
  /// cannot be cut.
  Divided cut(World& world, std::size_t connector, double along);

  /// Divides it at many places (m) at once, as one after the other do but for the masses beside
  /// links that are cut twice; n places on N particles take the time of N log n. The k-th new
  /// connector begins at the k-th place. False where one of them cannot be cut, or two are the
  /// same: then nothing has changed.
  bool cut(World& world, std::size_t connector, std::span<const double> along);

 private:
  bool is_held(const World& world, std::size_t connector, const Place& place) const;
  Outcome why_not_cut(const World& world, std::size_t connector, double along, const Place& place);
  void add_part(World& world, std::size_t connector);
  void divide(World& world, std::size_t connector, double along, std::size_t part);
  void divide(World& world, std::size_t connector, double start, std::size_t parts,
              std::span<const double> along, std::span<const std::size_t> order);
  void let_go(World& world, std::size_t connector, const Attachment& by);
  Outcome drop(World& world, std::size_t connector);

  Ties ties_;
  LinkRestorer restorer_;
  std::vector<Hold> released_;         // of one connector
  std::vector<std::size_t> gone_;      // particles
  std::vector<double> gone_from_;      // m, the lengths of their links
  std::vector<Connector> spare_;       // for what is cut off
  std::vector<std::size_t> original_;  // of each connector: the one that it is a part of
  std::vector<std::size_t> cut_off_;   // parts of each of the originals
};

/// True where what would hold a particle exists.
bool exists(const World& world, const Attachment& to);

/// Where the material point at `along` (m) of the connector is, and how it moves.
PointMotion material_point(const Connector& connector, double along);

// Where a connector lets its places be taken.

/// Whether `along` (m) is on the connector.
bool on(const Connector& connector, double along);

/// Where a particle will be once it is drawn to what holds it, as far as that is known.
Vec3 goal(const World& world, const Attachment& to, double arrival);

/// Where a place is to go, and whether it is drawn there.
struct Move {
  Vec3 now, target;
  bool drawn;
};

/// Whether what holds the connector elsewhere, where it is and where it is being drawn to, lets the
/// place go to the target or, drawn, straight there; then free bodies follow. One pass over the
/// links, from the place to the first hold on either side that does not give way: the links beyond
/// it begin there.
Outcome feasible(const World& world, const Connector& connector, const Place& place,
                 const Move& move);

/// How far the span around a particle that was added can go once the links beside it are one.
enum class Joined { straightens, needs_a_body, bent };

/// A span as it will be, once some of its particles have gone.
struct JoinedSpan {
  std::size_t first = 0, last = 0;  // particles, as they are now
  double length = 0, longest = 0;   // m, of it and its longest link
};

/// Holds on either side may be nearer than the links between them fold; then a free body among them
/// must give way.
Joined join(const World& world, const Connector& connector, const JoinedSpan& span);

// Interventions that are known beforehand, as a scene tells them.

// Connectors and places along them are those of the world at its start, whatever has been cut
// since.

struct TimedPin {
  std::size_t connector = 0;
  double along = 0;              // m of the connector's length, from its first particle
  double from = 0;               // s
  double until = INFINITY;       // s; infinite: for good
  std::optional<Attachment> to;  // nothing: where it is at `from`
  double over = 0;               // s in which it is drawn there
  std::string source = {};       // where it is written, for messages
};

struct TimedCut {
  std::size_t connector = 0;
  double along = 0;  // m
  double time = 0;   // s
  std::string source = {};
};

struct Timeline {
  std::vector<TimedPin> pins;
  std::vector<TimedCut> cuts;

  bool empty() const { return pins.empty() && cuts.empty(); }
};

/// Cuts as they follow each other.
std::vector<TimedCut> in_order_of_time(std::vector<TimedCut> cuts);

/// The world as if all cuts were made at its start: the parts of its connectors as pictures and
/// tables show them from the first frame to the last. The cuts must be without flaws.
World divided(World world, const Timeline& timeline);

/// A flaw of an entry of a timeline.
struct Flaw {
  bool cut = false;       // of the cuts, else of the pins
  std::size_t index = 0;  // in its list
  std::string what;       // ends a sentence about the entry
};

/// The first entry that cannot be, as far as that is known beforehand: places outside the
/// connector, times before the world's or out of order, two pins at one place, and pins or ends
/// that move apart beyond the connector's length between them, or closer than its links fold.
std::optional<Flaw> find_flaw(const World& world, const Timeline& timeline);

/// An entry of a timeline that turned out not to be possible when its time came.
class BadIntervention : public std::runtime_error {
 public:
  BadIntervention(Flaw found, double at, const std::string& source = {});
  Flaw flaw;
  double time;  // s
};

// Whether interventions can be, as far as that is known beforehand or when their time comes.

/// Why a pin at `along` (m) of the connector cannot be taken to where `to` is now: how far that is
/// from what holds the connector elsewhere, and what the connector allows; empty where it can.
std::string why_out_of_reach(const World& world, std::size_t connector, double along,
                             const Attachment& to);

/// Why nothing may let go of the particle of a connector where it is: as a bead that is free it
/// would be inside of an obstacle, where no bead can be; empty where it may.
std::string why_inside(const World& world, std::size_t connector, std::size_t particle);

}  // namespace taut
