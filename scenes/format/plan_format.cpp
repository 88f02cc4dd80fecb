#include "scenes/format/format_keys.h"

namespace taut::scenes {

using namespace format_keys;

const TableFormat& plan_format() {
  static const TableFormat connector{
      {{.name = "particles",
        .meaning = "How many, both ends counted.",
        .minimum = 2,
        .maximum = kMostParticles,
        .whole = true},
       {.name = "model", .type = Type::choice, .meaning = "A massless span.", .choices = {"span"}}},
      {{{"particles", "model"}}}};
  static const TableFormat body{{needed({.name = "model",
                                         .type = Type::choice,
                                         .meaning = "One more link of its connector.",
                                         .choices = {"link"}})}};
  static const TableFormat afterwards{
      {needed({.name = "work",
               .type = Type::choice,
               .meaning = "That is done on it: known work is left out of the energy; with unknown "
                          "work it is the mean energy.",
               .choices = {"none", "known", "unknown"}}),
       needed(not_negative("energy", "Its largest change, as a share.", "1")),
       needed(not_negative("stretch", "The largest of a link, as a share of its length.", "1")),
       needed(not_negative("speeds", "Share of the points with another speed.", "1"))}};
  static const TableFormat format{
      {needed(text("tolerance", "What was asked: 1px, 0.5mm.")),
       needed(not_negative("error", "The largest until then, in the tolerance's unit.", "")),
       needed(not_negative("until", "How long the motion is predictable.", "s")),
       text("end", "What ends that: a pin comes, a cut is made."),
       table("afterwards", "By how much it differs from reference solutions after that.",
             afterwards),
       {.name = "exposures",
        .meaning = "Most that a frame needs while the shutter is open, a power of two.",
        .minimum = 1,
        .maximum = 1024,
        .whole = true},
       needed(text("stamp", "Hash of what the plan was made from.")),
       needed(text("program", "Hash of how the method moves, in the program that made it.")),
       needed({.name = "method", .type = Type::method, .meaning = "What solves it."}),
       {.name = "neglected",
        .type = Type::texts,
        .meaning =
            "Physics of connectors that need not be followed: air, twist, bending, stretch."},
       table("connectors", "How many particles will do.", connector, Type::named),
       table("bodies", "Those that need be no rigid bodies.", body, Type::named)}};
  return format;
}

}  // namespace taut::scenes
