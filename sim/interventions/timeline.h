// Interventions that are known beforehand, as a scene tells them.
#pragma once

#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sim/interventions/interventions.h"

namespace taut {

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

}  // namespace taut
