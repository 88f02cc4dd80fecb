#include "scenes/format/format_keys.h"

namespace taut::scenes {

namespace {

using namespace format_keys;

KeyFormat rounding() {
  return not_negative("rounding", "Radius of its edges, within its size; default: 0, sharp.", "m");
}

KeyFormat restitution(std::string_view meaning) {
  return {.name = "restitution", .meaning = meaning, .unit = "1", .minimum = 0, .maximum = 1};
}

const TableFormat& surface_format() {
  static const TableFormat plane{
      {positive("size", "Edge of the square that is drawn of it; default: 4.", "m")}};
  static const TableFormat sphere{{needed(positive("diameter", "Of the ball.", "m"))}};
  static const TableFormat capsule{
      {needed(positive("length", "Along the y axis, without the caps.", "m")),
       needed(positive("diameter", "Across it.", "m"))}};
  static const TableFormat cylinder{{needed(positive("length", "Along the y axis.", "m")),
                                     needed(positive("diameter", "Across it.", "m")), rounding()}};
  static const TableFormat box{{needed([] {
                                  KeyFormat key = vector("size", "Along x, y and z.");
                                  key.minimum = 0;
                                  key.above = true;
                                  return key;
                                }()),
                                rounding()}};
  static const TableFormat format{
      {table("plane", "All that lies below y = 0; {} has the size of the default.", plane),
       table("sphere", "A ball.", sphere),
       table("capsule", "A cylinder along y with half balls as caps.", capsule),
       table("cylinder", "A cylinder along y.", cylinder), table("box", "A box.", box)},
      {{{"plane", "sphere", "capsule", "cylinder", "box"}}}};
  return format;
}

}  // namespace

const TableFormat& obstacle_format() {
  static const TableFormat format{
      {table("shape",
             "The solid, centred on the obstacle's origin; default, of a bone: a capsule about the "
             "skin that moves with it.",
             surface_format()),
       text("path", "Name of the path that it follows; without one it stands still."),
       text("body", "Name of the driven body that carries it."),
       text("bone", "Name of the bone that carries it, of a character."),
       text("character", "Name of that character."),
       vector("position",
              "Of its origin: in the world, or in the frame of what carries it; default: 0, 0, 0."),
       rotation("Of its frame, as a quaternion [w, x, y, z]; default: none."),
       friction(),
       static_friction(),
       restitution("Newton's coefficient: the share of its speed with which a bead bounces off; "
                   "default: 0."),
       {.name = "ignores",
        .type = Type::texts,
        .meaning =
            "Names of connectors, nets and free bodies that pass through it; default: none."},
       color("color", "Linear colour."),
       {.name = "shown",
        .type = Type::flag,
        .meaning = "Whether pictures show it; default: true, unless a body or bone carries it."}},
      {{{"path", "body", "bone"}, false}}};
  return format;
}

const TableFormat& touching_format() {
  static const TableFormat format{
      {{.name = "bodies",
        .type = Type::texts,
        .meaning = "Names of free bodies with `contact`, of which each touches each other."},
       {.name = "connectors",
        .type = Type::texts,
        .meaning = "Names of connectors and nets: their beads touch each of these bodies, and "
                   "their links, as capsules, the links of the others."},
       friction(),
       static_friction(),
       restitution("Newton's coefficient: the share of the speed at which they meet with which "
                   "they part; default: 0.")}};
  return format;
}

}  // namespace taut::scenes
