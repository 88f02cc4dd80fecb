// The format of a connector's ends, and of the pulleys that it passes.
#include "scenes/format/format_keys.h"

namespace taut::scenes {

using namespace format_keys;

const TableFormat& end_format() {
  static const TableFormat turns =
      number_keys("angle", "Right-handed about the clamp's direction.", "rad", kMostTurn);
  static const TableFormat lengths =
      length_keys("paid_out", "Since the start; below zero: taken in.");
  static const TableFormat format{
      {text("body", "Name of the body that holds the end."),
       vector("point", "Where on the body, path or bone, in its frame; default: its origin."),
       vector("fixed", "A point in space."),
       text("path", "Name of the path that carries the end."),
       text("bone", "Name of the bone that carries the end, of a character."),
       text("character", "Name of that character."),
       text("connector",
            "Name of the connector that the end is joined to: the two particles are one. Of the "
            "connector itself: it is a closed loop."),
       not_negative("at", "Where along that connector: the place of one of its particles.", "m"),
       positive("point_mass", "Mass of a point that the end carries.", "kg"),
       {.name = "free",
        .type = Type::flag,
        .meaning = "true: nothing holds the end.",
        .minimum = 1},
       vector("clamp",
              "The connector's direction there, from its first end to its last, is held as well; "
              "in the frame of what holds it.",
              ""),
       {.name = "turn",
        .type = Type::tables,
        .meaning = "How far the clamp is turned about that direction, which twists the connector; "
                   "it is untwisted at the start with none. Smooth between keys.",
        .least = 1,
        .table = &turns},
       {.name = "winch",
        .type = Type::tables,
        .meaning = "How much of the connector is paid out here when: its links share it, and none "
                   "enters or leaves. At an end that is fixed or driven. Smooth between keys.",
        .least = 1,
        .table = &lengths}},
      {{{"body", "fixed", "path", "bone", "connector", "point_mass", "free"}}}};
  return format;
}

const TableFormat& pulley_format() {
  static const TableFormat passed =
      length_keys("passed", "Since the start; below zero: backwards.");
  static const TableFormat format{
      {text("body", "Name of the body that carries it."),
       vector("point", "Where on the body, path or bone, in its frame; default: its origin."),
       vector("fixed", "A point in space."),
       text("path", "Name of the path that carries it."),
       text("bone", "Name of the bone that carries it, of a character."),
       text("character", "Name of that character."),
       not_negative("inertia",
                    "Of a sheave about its axle, over the square of its radius: half of the mass "
                    "of a disc; default: an eye.",
                    "kg"),
       not_negative("friction",
                    "Coulomb's, of the rope on an eye: what pulls it is exp(friction turn) times "
                    "what holds it.",
                    "1"),
       {.name = "bearing",
        .meaning = "Coulomb's friction of a sheave's axle, times its radius over the sheave's: of "
                   "both tensions together over half a turn.",
        .unit = "1",
        .minimum = 0,
        .maximum = 0.99},
       {.name = "passed",
        .type = Type::tables,
        .meaning = "How much rope it passes when, where it is driven; default: it turns freely. "
                   "Not on a free body. Smooth between keys.",
        .least = 1,
        .table = &passed}},
      {{{"body", "fixed", "path", "bone"}},
       {{"inertia", "passed"}, false},
       {{"friction", "passed"}, false},
       {{"bearing", "passed"}, false}}};
  return format;
}

}  // namespace taut::scenes
