// Interventions: unforeseen changes of a world between two steps.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "sim/interventions/outcome.h"
#include "sim/world/places.h"
#include "sim/world/restore.h"
#include "sim/world/ties.h"
#include "sim/world/world.h"

namespace taut {

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

}  // namespace taut
