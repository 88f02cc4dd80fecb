#include <algorithm>
#include <iterator>

#include "scenes/format/format_keys.h"

namespace taut::scenes {

using namespace format_keys;

const TableFormat& net_format() {
  static const TableFormat format = [] {
    TableFormat made{
        {needed({.name = "kind",
                 .type = Type::choice,
                 .meaning = "Cords that cross, ropes with rungs, or spokes with rings.",
                 .choices = {"net", "ladder", "web"}}),
         needed(vector("origin", "Its upper left corner; of a web, its hub.")),
         needed(vector("across", "Its direction from left to right.", "")),
         needed(vector("down", "Its direction downwards.", "")),
         needed({.name = "size",
                 .type = Type::numbers,
                 .meaning = "How long its cords are across and downwards; of a web, its diameters.",
                 .unit = "m",
                 .minimum = 0,
                 .above = true,
                 .least = 2,
                 .most = 2}),
         needed({.name = "cells",
                 .type = Type::numbers,
                 .meaning = "Meshes across and downwards; of a web, spokes and rings.",
                 .minimum = 1,
                 .maximum = 1000,
                 .whole = true,
                 .least = 2,
                 .most = 2}),
         {.name = "links",
          .meaning = "Of a cord from knot to knot; rungs and rings have one. Default: 1.",
          .minimum = 1,
          .maximum = 1000,
          .whole = true},
         positive("mass", "Of all cords together, by their lengths.", "kg"),
         needed({.name = "held",
                 .type = Type::choice,
                 .meaning = "The knots that are held where they are at the start.",
                 .choices = {"nothing", "upper corners", "upper edge", "corners", "edges"}}),
         {.name = "slack",
          .meaning = "The share by which cords between held knots are longer than the way; they "
                     "lie in waves.",
          .minimum = 0,
          .maximum = 0.5},
         {.name = "pleats",
          .meaning = "How many waves. Default: 1.",
          .minimum = 1,
          .maximum = 1000,
          .whole = true},
         {.name = "cords",
          .type = Type::choice,
          .meaning = "Links that are rigid rods, or strings that only pull, and are free "
                     "to fold.",
          .choices = {"rigid", "pull"}}},
        cord_alternatives()};
    std::ranges::copy(cord_keys(), std::back_inserter(made.keys));
    return made;
  }();
  return format;
}

}  // namespace taut::scenes
