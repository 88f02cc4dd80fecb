#include "scenes/format/format_keys.h"

namespace taut::scenes {

using namespace format_keys;

namespace {

const TableFormat& winding_format() {
  static const TableFormat format{
      {needed(text("obstacle", "Name of a cylinder or capsule that stands still.")),
       {.name = "turns",
        .meaning = "How many, right-handed about its y axis, side by side; default: 0.5, over it.",
        .unit = "1",
        .minimum = 0,
        .maximum = 1000},
       needed(not_negative("before", "Length of the straight piece to the first end.", "m"))}};
  return format;
}

}  // namespace

const TableFormat& start_format() {
  static const TableFormat circle{{needed(vector("centre", "Of the circle.")),
                                   needed(vector("axis", "Across which it stands.", ""))}};
  static const TableFormat format{
      {vector("direction", "Straight from the first end, or from the last pulley.", ""),
       {.name = "points",
        .type = Type::points,
        .meaning = "Along these straight pieces, from the first end to the last; as long together "
                   "as the connector, or longer where it stretches and is held there.",
        .unit = "m",
        .least = 2},
       vector("hanging_to", "At rest between the first end and this point."),
       table("over", "On a round obstacle, both ends hanging from it.", winding_format()),
       table("circle",
             "A closed loop: a polygon whose sides are the links; the last particle is joined to "
             "the first.",
             circle),
       not_negative("before",
                    "Length up to the first pulley; default: straight from where the first end "
                    "is held.",
                    "m"),
       vector("spin",
              "Turns as one stiff piece about the first particle, the circle's centre or the last "
              "pulley.",
              "rad/s"),
       vector("push_out",
              "Moves beads that would start inside of obstacles this way, to their surfaces; links "
              "keep their lengths.",
              "")},
      {{{"direction", "points", "hanging_to", "over", "circle"}, false}}};
  return format;
}

}  // namespace taut::scenes
