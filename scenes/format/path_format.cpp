#include "scenes/format/format_keys.h"

namespace taut::scenes {
namespace {

using namespace format_keys;

constexpr double kShortestHold = 1e-6;  // s; a shorter one late in a day would not move its time

const TableFormat& path_key_format() {
  static const TableFormat format{
      {needed({.name = "t",
               .meaning = "Time of the key.",
               .unit = "s",
               .minimum = -kLongest,
               .maximum = kLongest}),
       needed(vector("position", "Where the path is.")),
       rotation("Orientation as a quaternion [w, x, y, z]; default: as the key before."),
       vector("axis", "Direction of the y axis, instead of a rotation; turned the shortest way.",
              ""),
       {.name = "ease", .type = Type::flag, .meaning = "Comes to rest at this key."},
       {.name = "hold",
        .meaning = "Rests here for so long.",
        .unit = "s",
        .minimum = kShortestHold,
        .maximum = kLongest}},
      {{{"rotation", "axis"}, false}}};
  return format;
}

const TableFormat& circle_format() {
  static const TableFormat format{
      {needed(vector("centre", "Of the circle.")),
       needed(vector("start", "Where the path rests until 0 s.")),
       needed(vector("axis", "It turns about, right-handed; at right angles to the radius.", "")),
       needed({.name = "frequency",
               .meaning = "Turns per second, after the ramp.",
               .unit = "1/s",
               .minimum = 1e-3,
               .maximum = 1e3}),
       needed({.name = "ramp",
               .meaning = "How long the angular speed takes to rise, as a smoothstep.",
               .unit = "s",
               .minimum = 0,
               .maximum = kLongest,
               .above = true})}};
  return format;
}

const TableFormat& axle_format() {
  static const TableFormat angles =
      number_keys("angle", "Right-handed about the axis.", "rad", kMostTurn);
  static const TableFormat format{
      {needed(vector("position", "Where the path is.")),
       needed(vector("axis", "It turns about, the y axis of its frame.", "")),
       needed({.name = "keys",
               .type = Type::tables,
               .meaning = "How far it has turned when; smooth between.",
               .least = 1,
               .table = &angles}),
       {.name = "pitch",
        .meaning = "By how much each turn moves it along the axis, as a screw; default: 0.",
        .unit = "m"}}};
  return format;
}

}  // namespace

const TableFormat& path_format() {
  static const TableFormat format{
      {{.name = "keys",
        .type = Type::tables,
        .meaning = "Where the path is when; smooth between.",
        .least = 1,
        .table = &path_key_format()},
       {.name = "file",
        .type = Type::file,
        .meaning = "A CSV file with columns t,x,y,z[,qw,qx,qy,qz] instead of keys."},
       table("circle", "Round and round, from rest, instead of keys.", circle_format()),
       table("axle", "In one place, turning about an axis, instead of keys.", axle_format())},
      {{{"keys", "file", "circle", "axle"}}}};
  return format;
}

}  // namespace taut::scenes
