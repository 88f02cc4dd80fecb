#include "scenes/reader/format_keys.h"

namespace taut {

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
  static const TableFormat format{
      {needed(text("tolerance", "What was asked: 1px, 0.5mm.")),
       needed(not_negative("error", "The largest until then, in the tolerance's unit.", "")),
       needed(not_negative("until", "How long the motion is predictable.", "s")),
       not_negative("energy", "Its largest change afterwards, as a share.", "1"),
       needed(text("stamp", "Hash of what the plan was made from.")),
       needed({.name = "method", .type = Type::method, .meaning = "What solves it."}),
       table("connectors", "How many particles will do.", connector, Type::named)}};
  return format;
}

}  // namespace taut
