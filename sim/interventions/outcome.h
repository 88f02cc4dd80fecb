// Outcomes of interventions.
#pragma once

#include <string_view>

namespace taut {

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

}  // namespace taut
