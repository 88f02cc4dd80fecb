#include "scenes/format/scene_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "scenes/format/format.h"
#include "sim/run/method.h"

namespace taut::scenes {
namespace {

class Renaming {
 public:
  explicit Renaming(const Document& document) : document_(document) {}

  void go_through(Value& table, const TableFormat& format) {
    for (Value& member : table.children) {
      const auto now = std::ranges::find_if(format.keys, [&](const KeyFormat& key) {
        return !key.formerly.empty() && key.formerly == member.name && !table.find(key.name);
      });
      if (now != format.keys.end()) {
        tell(member, now->name);
        member.name = now->name;
      }
      const KeyFormat* key = format.find(member.name);
      if (!key || !key->table) continue;
      if (key->type == KeyFormat::Type::table) {
        go_through(member, *key->table);
      } else {
        for (Value& element : member.children) go_through(element, *key->table);
      }
    }
  }

  std::vector<std::string> told;

 private:
  void tell(const Value& key, std::string_view now) {
    const std::string file = (key.inherited ? document_.base : document_.file).string();
    const std::string place =
        key.place.line > 0 ? fmt::format("{}:{}:{}", file, key.key_place.line, key.key_place.column)
                           : file;
    told.push_back(fmt::format("{}: {} is called {} now", place, key.path, now));
  }

  const Document& document_;
};

}  // namespace

std::vector<std::string> rename_old_keys(Document& document) {
  Renaming renaming(document);
  renaming.go_through(document.root, scene_format());
  return renaming.told;
}

namespace {

using namespace format_keys;

KeyFormat time_of(std::string_view name, std::string_view meaning) {
  return {.name = name, .meaning = meaning, .unit = "s", .minimum = -kLongest, .maximum = kLongest};
}

const TableFormat& waypoint_format() {
  static const TableFormat format{{needed(time_of("t", "When it is passed.")),
                                   needed(vector("position", "Where the body's point is then."))}};
  return format;
}

const TableFormat& curve_format() {
  static const TableFormat end{
      {vector("centre", "Its middle."), vector("across", "To its side."), vector("up", "Upward.")}};
  static const TableFormat format{
      {needed({.name = "figure",
               .type = Type::choice,
               .meaning = "circle: centre + across sin(a) - up cos(a), from its lowest point; "
                          "eight: centre + across sin(a) + up sin(2 a), from its middle.",
               .choices = {"circle", "eight"}}),
       needed(time_of("from", "When it begins.")), needed(time_of("until", "When it ends.")),
       needed(
           {.name = "laps",
            .meaning =
                "How often the angle a goes round: six waypoints of a circle, eight of an eight.",
            .minimum = 1,
            .maximum = kMostLaps,
            .whole = true}),
       needed(vector("centre", "Its middle.")), needed(vector("across", "From there to its side.")),
       needed(vector("up", "From there upward: half of its height.")),
       table("to", "What is another at its end; even between.", end)}};
  return format;
}

const TableFormat& limits_format() {
  static const TableFormat format{
      {needed(vector("shoulder", "From where the hand's reach is measured.")),
       positive("reach", "The farthest from there; default: any.", "m"),
       positive("speed", "Default: any.", "m/s"),
       positive("acceleration", "Default: any.", "m/s^2"),
       positive(
           "clearance",
           "How far the body, from where it hangs to the point, stays from a line from the pivot "
           "to the chain's end; default: it may pass through it.",
           "m")}};
  return format;
}

}  // namespace

const TableFormat& choreography_format() {
  static const TableFormat format{
      {needed(text("body", "Name of the free body that is led.")),
       vector("point", "Of that body, on the line that it hangs by; default: its origin."),
       needed(text(
           "path",
           "Name of the path that leads it, of keys: it rests from the last before the waypoints "
           "on, and until the first after `until`.")),
       needed({.name = "file",
               .type = Type::file,
               .meaning =
                   "A CSV file beside the scene, which taut choreograph writes: the path's keys "
                   "until then."}),
       needed(time_of("until", "When the path rests again, where it did before.")),
       positive("within", "How near each waypoint is passed; default: 2 mm.", "m"),
       table("limits", "Of the hand.", limits_format()),
       positive("pivot",
                "How far behind the end that leads the connector is the place that the held body "
                "points away from; default: the body keeps its orientation.",
                "m"),
       table("waypoints", "Where the point is when.", waypoint_format(), Type::tables),
       table("curves", "Figures that it follows.", curve_format(), Type::tables)}};
  return format;
}

// The format of a connector's ends, and of the pulleys that it passes.

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

using namespace format_keys;

const TableFormat& material_format() {
  static const TableFormat format{
      {needed(positive("youngs_modulus", "Stress per strain, in stretch and in bending.", "Pa")),
       needed(positive("diameter", "Of the rod.", "m")),
       needed(positive("density", "Of what it is made of.", "kg/m^3")),
       {.name = "poissons_ratio",
        .meaning = "Of it, by which GJ follows from EI; default: 0.3.",
        .minimum = -1,
        .maximum = 0.5,
        .above = true}}};
  return format;
}

const TableFormat& drag_format() {
  static const TableFormat format{
      {not_negative("across", "For flow across it; 1.2 for a round rope.", "1"),
       not_negative("along", "For flow along it; 0.01 to 0.1, more for a rough rope.", "1")}};
  return format;
}

std::vector<KeyFormat> cord_keys() {
  return {
      {.name = "restitution",
       .meaning = "Coefficient of restitution when it goes taut.",
       .minimum = 0,
       .maximum = 1},
      {.name = "look",
       .type = Type::choice,
       .meaning = "How it is drawn.",
       .choices = {"chain", "rope", "cord"}},
      not_negative("radius",
                   "Of its particles, as beads that touch obstacles; default: half of the "
                   "diameter as drawn.",
                   "m"),
      {.name = "contact",
       .type = Type::choice,
       .meaning = "What touches obstacles: its beads, or the links between them as well, as "
                  "capsules.",
       .choices = {"beads", "links"}},
      {.name = "touches_itself",
       .type = Type::flag,
       .meaning = "Whether its links touch each other, as capsules of its radius, and those of "
                  "its copies or cords; default: false."},
      friction("Coulomb's coefficient where it touches itself, of what slides; default: 0."),
      static_friction(),
      positive("diameter", "As drawn: of the rope or cord, or across a link of the chain.", "m"),
      color("color", "Linear colour."),
      positive("axial_stiffness", "EA: tension per strain; default: links are rigid.", "N"),
      not_negative("axial_damping", "Tension per rate of strain, of links that stretch.", "N s"),
      not_negative("bending_stiffness", "EI: moment per curvature; default: it bends freely.",
                   "N m^2"),
      not_negative("bending_damping", "Moment per rate of curvature.", "N m^2 s"),
      table("material", "Gives mass, EA, EI and GJ of a solid round rod instead.",
            material_format()),
      positive(
          "breaks_at",
          "Tension at which it breaks: it is cut in the middle of the first link whose tension "
          "is above; default: never.",
          "N"),
      table("drag", "Coefficients of the air's drag on it, of its diameter.", drag_format())};
}

std::vector<Alternatives> cord_alternatives() {
  return {{{"mass", "material"}},
          {{"axial_stiffness", "material"}, false},
          {{"bending_stiffness", "material"}, false}};
}

const TableFormat& air_format() {
  static const TableFormat format{
      {not_negative("density", "Default: 1.225.", "kg/m^3"),
       vector("wind", "Velocity of the air, the same everywhere; default: [0, 0, 0].", "m/s"),
       {.name = "file",
        .type = Type::file,
        .meaning = "A CSV file with the columns t,x,y,z: the wind (m/s) over time (s), smooth "
                   "between its rows and constant beyond them."}},
      {{{"wind", "file"}, false}}};
  return format;
}

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

using namespace format_keys;

const TableFormat& stage_format() {
  constexpr double kRound = 1000;       // rad
  constexpr double kUpright = 1.5;      // rad, the steepest
  constexpr double kFarthest = 1e6;     // m
  constexpr double kLongestTrail = 60;  // s
  static const TableFormat orbit{{{.name = "azimuth",
                                   .meaning = "From the z axis towards the x axis; default: 0.",
                                   .unit = "rad",
                                   .minimum = -kRound,
                                   .maximum = kRound},
                                  {.name = "elevation",
                                   .meaning = "Above the level of the target; default: 0.",
                                   .unit = "rad",
                                   .minimum = -kUpright,
                                   .maximum = kUpright},
                                  needed({.name = "distance",
                                          .meaning = "From the target.",
                                          .unit = "m",
                                          .minimum = 0,
                                          .maximum = kFarthest,
                                          .above = true})}};
  static const TableFormat trail{
      {text("body", "Name of the body whose point leaves it."),
       vector("point", "Of that body, in its frame; default: its origin."),
       text("connector", "Name of the connector one of whose particles leaves it."),
       not_negative("at", "Where along it, from its first end; default: its last end.", "m"),
       {.name = "lasts",
        .meaning = "How long ago it begins; default: 0.5.",
        .unit = "s",
        .minimum = 0,
        .maximum = kLongestTrail,
        .above = true},
       not_negative("from", "When it appears; default: at once.", "s"),
       positive("until", "When it goes; default: never.", "s"),
       {.name = "width",
        .meaning = "Where the point is, as a share of the picture's height; default: 0.012.",
        .minimum = 0,
        .maximum = 0.2,
        .above = true},
       color("color", "Linear colour.")},
      {{{"body", "connector"}}, {{"point", "connector"}, false}, {{"at", "body"}, false}}};
  static const TableFormat camera{
      {needed({.name = "t", .meaning = "Time of the key.", .unit = "s"}),
       vector("position", "Of the eye."),
       table("orbit",
             "Where the eye is as seen from the target, instead of its position; between two keys "
             "that have it, it goes round.",
             orbit),
       needed(vector("target", "What it looks at; with `follow` from there.")),
       text("follow",
            "Name of a body or connector: the target goes along with its origin or the middle of "
            "its particles, and so does an eye on an orbit. The same in all keys of a camera."),
       {.name = "field_of_view",
        .meaning = "From the lower to the upper edge of the picture.",
        .unit = "rad",
        .minimum = 0,
        .maximum = 3,
        .above = true},
       {.name = "aperture",
        .meaning = "The lens's f-number on a picture 24 mm high, as 2.8: what is out of focus is "
                   "blurred; default: none, all is sharp.",
        .minimum = 0.5,
        .maximum = 1000},
       {.name = "focus",
        .meaning = "How far along the view the lens is focused; default: at the target.",
        .unit = "m",
        .minimum = 0.05,
        .maximum = 1000}},
      {{{"position", "orbit"}}}};
  static const KeyFormat camera_keys{.name = "camera",
                                     .type = Type::tables,
                                     .meaning = "Where the camera is when; smooth between.",
                                     .least = 1,
                                     .table = &camera};
  static const TableFormat shot{{needed(not_negative("from", "Time of its first frame.", "s")),
                                 needed(positive("until", "Time after its last frame.", "s")),
                                 {.name = "rate",
                                  .meaning = "How fast it goes: 0.25 is slow motion; default: 1.",
                                  .minimum = 0.001,
                                  .maximum = 1000},
                                 camera_keys}};
  static const TableFormat card{
      {needed(positive("duration", "How long it stays.", "s")),
       needed(text("heading", "Its first line, in large letters.")),
       text("text", "The lines below; {method} stands for the method's name.")}};
  static const TableFormat light{{vector("direction", "The way the key light travels.", ""),
                                  color("color", "Linear radiance of the key light."),
                                  color("sky", "Linear ambient light from above."),
                                  color("ground", "Linear ambient light from below."),
                                  color("rim",
                                        "Linear radiance at the edges of what moves, as of a "
                                        "light behind it; default: none."),
                                  {.name = "scenery_casts",
                                   .type = Type::flag,
                                   .meaning = "The scenery throws shadows: the key light comes in "
                                              "only where it is open; default: false."}}};
  static const TableFormat caption{
      {needed(not_negative("from", "When it appears.", "s")),
       needed(positive("until", "When it goes.", "s")),
       needed(text("text", "What it says; a newline breaks the line.")),
       text("list",
            "Captions of one list have what follows a tab in "
            "one column.")}};
  static const TableFormat format{
      {{.name = "scenery",
        .type = Type::files,
        .meaning = "Models that stand still, in world space."},
       camera_keys,
       {.name = "shots",
        .type = Type::tables,
        .meaning = "What the clip shows, one after another, cut hard; default: the whole scene by "
                   "the camera above, which is also that of a shot without its own.",
        .least = 1,
        .table = &shot},
       table("title", "A card before the first shot.", card),
       table("end", "A card after the last shot.", card),
       {.name = "shutter",
        .meaning = "Share of a frame's time for which the shutter is open, around the frame's own "
                   "instant; 0.5: 180 degrees; default: 0, no motion blur.",
        .minimum = 0,
        .maximum = 1},
       table("light", "The key light and the light from all around.", light),
       color("background", "Linear colour where nothing is, as it comes out; 1: all there is."),
       table("captions", "Lines of text on the picture.", caption, Type::tables),
       table("trails", "Ribbons that show which way a point came.", trail, Type::tables)}};
  return format;
}

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

namespace {

using namespace format_keys;

const TableFormat& head_key_format() {
  static const TableFormat format{
      {needed({.name = "t", .meaning = "Time of the key.", .unit = "s"}),
       {.name = "yaw", .meaning = "To the left.", .unit = "rad"},
       {.name = "lean", .meaning = "Forward.", .unit = "rad"},
       {.name = "tilt", .meaning = "To the right.", .unit = "rad"},
       {.name = "ease", .type = Type::flag, .meaning = "Comes to rest at this key."}}};
  return format;
}

const TableFormat& animation_format() {
  static const TableFormat format{
      {text("name", "Which animation of the file; default: its first."),
       {.name = "from",
        .meaning = "Its time when the scene begins; default: 0.",
        .unit = "s",
        .minimum = -kLongest,
        .maximum = kLongest},
       {.name = "speed",
        .meaning = "How many of its seconds pass in one of the scene's; default: 1.",
        .unit = "1",
        .minimum = 0,
        .maximum = 1000},
       vector("position", "Where the model's origin stands; default: [0, 0, 0]."),
       rotation("How the model is turned, [w, x, y, z].")}};
  return format;
}

const TableFormat& character_format() {
  static const TableFormat format{
      {needed({.name = "mesh",
               .type = Type::file,
               .meaning = "A skinned glTF or GLB model, or a BVH file of motion capture."}),
       text("right_hand", "Name of the path that the right hand's grip follows."),
       table("animation", "The character moves as this animation of its file says, instead.",
             animation_format()),
       {.name = "bones",
        .type = Type::names,
        .meaning = "The model's names of bones: mixamo, or a table as { Head = \"head_1\" }.",
        .choices = {"mixamo"}},
       positive("scale", "Of the model's lengths, as 0.01 for centimetres; default: 1.", "1"),
       {.name = "head",
        .type = Type::tables,
        .meaning = "How the head turns when, beyond what follows from the hand; smooth between.",
        .least = 1,
        .table = &head_key_format()}},
      {{{"right_hand", "animation"}}, {{"head", "animation"}, false}}};
  return format;
}

const TableFormat& shape_format() {
  static const TableFormat cylinder{{needed(positive("length", "Along the body's y axis.", "m")),
                                     needed(positive("diameter", "Across it.", "m"))}};
  static const TableFormat sphere{{needed(positive("diameter", "Of the ball.", "m"))}};
  static const TableFormat box{{needed([] {
    KeyFormat key = vector("size", "Along x, y and z.");
    key.minimum = 0;
    key.above = true;
    return key;
  }())}};
  static const TableFormat format{
      {table("cylinder", "A solid cylinder along y.", cylinder),
       table("sphere", "A solid ball.", sphere), table("box", "A solid box.", box)},
      {{{"cylinder", "sphere", "box"}}}};
  return format;
}

const TableFormat& driver_format() {
  static const TableFormat format{{text("path", "Name of a path."),
                                   text("character", "Name of a character."),
                                   {.name = "hand",
                                    .type = Type::choice,
                                    .meaning = "Which hand holds the body.",
                                    .choices = {"right"}},
                                   text("bone", "Name of the character's bone that carries it.")},
                                  {{{"path", "character"}}, {{"path", "hand", "bone"}, false}}};
  return format;
}

const TableFormat& capsule_format() {
  static const TableFormat format{
      {positive("radius", "About the line; default: of the cylinder or sphere.", "m"),
       vector("from",
              "Where the line begins, in the body's frame; default: on the cylinder's axis, "
              "the radius from its end."),
       vector("to", "Where it ends; default: at the cylinder's other end."),
       {.name = "ignores",
        .type = Type::texts,
        .meaning = "Names of free bodies that it passes through, whatever stands in `touching`; "
                   "default: none."}}};
  return format;
}

const TableFormat& body_format() {
  static const TableFormat format{
      {positive("mass",
                "Of the body alone; default, of one that stands or is driven: 1, of no account.",
                "kg"),
       table("shape", "A solid of even density, centred on the body's origin.", shape_format()),
       {.name = "inertia",
        .type = Type::numbers,
        .meaning = "About the centre of mass: xx, yy, zz and, if they are not zero, all of xy, yz, "
                   "zx; instead of a shape.",
        .unit = "kg m^2",
        .least = 3,
        .most = 6},
       vector("centre", "Centre of mass in the body's frame, with `inertia`; default: its origin."),
       table("driven_by", "What moves the body; without it the body is free.", driver_format()),
       vector("fixed", "Where the body's origin stands for good.", "m"),
       vector("grip", "Point of a driven body that the path carries; default: its origin."),
       vector("hangs", "The body hangs from its connector's end in this direction.", ""),
       vector("position", "Of the body's origin at the start."),
       rotation("Of the body's frame at the start, as a quaternion [w, x, y, z]."),
       vector("velocity", "Of the centre of mass at the start.", "m/s"),
       vector("spin", "At the start, about the world's axes.", "rad/s"),
       table(
           "contact",
           "The capsule as which a free body touches obstacles, and other bodies where `touching` "
           "says so; {}: that of its cylinder or sphere. Without it the body touches nothing.",
           capsule_format()),
       {.name = "mesh",
        .type = Type::file,
        .meaning = "A glTF, GLB or OBJ model in the body's frame; default: its shape."},
       color("color", "Linear colour of the shape, where no mesh is named.")},
      {{{"shape", "inertia"}}, {{"driven_by", "fixed", "hangs", "position"}}}};
  return format;
}

const TableFormat& repeat_format() {
  static const TableFormat format{
      {needed({.name = "count",
               .meaning = "How many, the first included.",
               .minimum = 1,
               .maximum = kMostParticles,
               .whole = true}),
       needed(vector("by", "From one to the next.")),
       not_negative("delay", "How much later the next one's paths are.", "s")}};
  return format;
}

const TableFormat& connector_format() {
  static const TableFormat format = [] {
    TableFormat made{
        {needed(not_negative("length", "Of all links together; 0: a joint of two particles.", "m")),
         not_negative("mass",
                      "Shared evenly by the particles, ends included; with a taper or in a closed "
                      "loop by the links, whose ends have half each.",
                      "kg"),
         needed({.name = "particles",
                 .meaning = "How many; one more than links.",
                 .unit = "",
                 .minimum = 2,
                 .maximum = kMostParticles,
                 .whole = true}),
         needed(table("from", "What holds the first particle.", end_format())),
         needed(table("to", "What holds the last particle.", end_format())),
         table("start",
               "Its shape at the start; default: hanging between ends whose places are "
               "known, as one with those that are joined to it end to end, else straight along "
               "gravity.",
               start_format()),
         {.name = "over",
          .type = Type::texts,
          .meaning =
              "Names of the pulleys that the rope passes, from its first end to its last. Its "
              "spans between them are connectors NAME, NAME#2 and so on, of so many "
              "`particles` each. Where both of its ends are held and the length is within "
              "1e-4 of taut, it starts taut.",
          .least = 1},
         table("repeat", "Copies in a row; a second entry: copies of that row, and so on.",
               repeat_format(), Type::tables),
         {.name = "model",
          .type = Type::choice,
          .meaning = "Rigid links with mass, or a massless span.",
          .choices = {"links", "span"}},
         {.name = "links",
          .type = Type::choice,
          .meaning = "Rigid rods, or strings that only pull, and are free to fold.",
          .choices = {"rigid", "pull"}},
         vector("rest_curvature",
                "How it is curved at rest, about the axis across the plane in which it moves, "
                "right-handed from its first end.",
                "1/m"),
         positive("twisting_stiffness",
                  "GJ: moment per twist, between ends that are clamped; default: it twists freely.",
                  "N m^2"),
         not_negative("twisting_damping", "Moment per rate of twist.", "N m^2 s"),
         {.name = "rest_twist",
          .meaning = "How much it is twisted at rest, beyond what it is at the start.",
          .unit = "rad/m"},
         {.name = "taper",
          .type = Type::numbers,
          .meaning = "Diameters along it, evenly spaced and linear between, as shares of its "
                     "diameter: stiffness goes with the fourth power in bending and twist and the "
                     "second in stretch, mass with the second.",
          .minimum = 0,
          .above = true,
          .least = 2}},
        cord_alternatives()};
    made.alternatives.push_back({{"twisting_stiffness", "material"}, false});
    std::ranges::copy(cord_keys(), std::back_inserter(made.keys));
    std::ranges::find(made.keys, "restitution", &KeyFormat::name)->formerly = "elasticity";
    return made;
  }();
  return format;
}

const TableFormat& pin_format() {
  static const TableFormat format{
      {needed(text("connector", "Name of the connector that is held.")),
       needed(not_negative("at", "Where along it, from its first end.", "m")),
       needed(not_negative("from", "When it is caught.", "s")),
       positive("until", "When it is released; default: never.", "s"),
       not_negative("over", "How long it takes to get to where it is held; default: at once.", "s"),
       vector(
           "point",
           "Where it is held: in space, or on the body, path or bone; without these, where it is."),
       text("body", "Name of the body that holds it."),
       text("path", "Name of the path that carries it."),
       text("bone", "Name of the bone that carries it, of a character."),
       text("character", "Name of that character.")},
      {{{"body", "path", "bone"}, false}}};
  return format;
}

const TableFormat& cut_format() {
  static const TableFormat format{
      {needed(text("connector", "Name of the connector that is cut.")),
       needed(not_negative("at", "Where along it, from its first end.", "m")),
       needed(not_negative("t", "When.", "s"))}};
  return format;
}

KeyFormat setting_format(const SettingInfo& info) {
  KeyFormat key{.name = info.name,
                .meaning = info.meaning,
                .unit = info.unit,
                .minimum = info.minimum,
                .maximum = info.maximum,
                .above = info.above,
                .whole = info.whole,
                .choices = info.choices};
  if (std::holds_alternative<bool>(info.fallback)) key.type = Type::flag;
  if (std::holds_alternative<std::string>(info.fallback)) key.type = Type::choice;
  return key;
}

}  // namespace

const std::map<std::string_view, TableFormat>& method_formats() {
  static const auto formats = [] {
    std::map<std::string_view, TableFormat> list;
    std::vector<std::string_view> names;
    for (const MethodInfo& method : all_methods()) names.push_back(method.name);
    for (const MethodInfo& method : all_methods()) {
      TableFormat format{{needed(
          {.name = "name", .type = Type::choice, .meaning = method.summary, .choices = names})}};
      for (const SettingInfo& setting : method.settings) {
        format.keys.push_back(setting_format(setting));
      }
      list.emplace(method.name, std::move(format));
    }
    return list;
  }();
  return formats;
}

const TableFormat& scene_format() {
  static const TableFormat format{{
      {.name = "schema_version",
       .meaning = "Version of this format.",
       .minimum = 1,
       .maximum = 1,
       .whole = true},
      text("extends",
           "A scene file beside this one; what stands at the top there and not here holds here, "
           "too."),
      text("title", "What the clip is called; default: the file's name."),
      needed({.name = "duration",
              .meaning = "Simulated time.",
              .unit = "s",
              .minimum = 0,
              .maximum = kLongest,
              .above = true}),
      {.name = "fps",
       .meaning = "Frames per second.",
       .minimum = 1,
       .maximum = kMostFps,
       .whole = true},
      {.name = "size",
       .type = Type::numbers,
       .meaning = "Width and height of the picture.",
       .unit = "pixels",
       .minimum = 1,
       .maximum = kWidest,
       .whole = true,
       .least = 2,
       .most = 2},
      gravity(),
      table("air", "What connectors with drag move through.", air_format()),
      {.name = "method", .type = Type::method, .meaning = "How the world is advanced."},
      table("paths", "Motions that are given.", path_format(), Type::named),
      table("characters", "People who hold bodies.", character_format(), Type::named),
      table("bodies", "Rigid bodies.", body_format(), Type::named),
      table("connectors", "Ropes, chains and cords.", connector_format(), Type::named),
      table("pulleys", "Eyes and sheaves that ropes pass, without size.", pulley_format(),
            Type::named),
      table("nets", "Nets, rope ladders and webs; their cords are connectors NAME#1 and so on.",
            net_format(), Type::named),
      table("obstacles", "Solids that beads of connectors and free bodies touch.",
            obstacle_format(), Type::named),
      table("touching",
            "Free bodies and connectors that touch each other; others pass through each other.",
            touching_format(), Type::named),
      table("pins", "Points of a connector that are held for a while.", pin_format(), Type::tables),
      table("cuts", "Places where a connector is divided for good.", cut_format(), Type::tables),
      table("choreography", "Where a free body is led; taut choreograph finds the hand's path.",
            choreography_format()),
      table("stage", "What pictures need beside the world.", stage_format()),
      table("plan", "What taut plan found; --planned takes it.", plan_format()),
  }};
  return format;
}

const KeyFormat* TableFormat::find(std::string_view name) const {
  const auto found = std::ranges::find(keys, name, &KeyFormat::name);
  return found == keys.end() ? nullptr : &*found;
}

std::vector<std::string_view> TableFormat::names() const {
  std::vector<std::string_view> list;
  for (const KeyFormat& key : keys) list.push_back(key.name);
  return list;
}

bool is_scene_key(std::string_view key) {
  return scene_format().find(key.substr(0, key.find_first_of(".["))) != nullptr;
}

}  // namespace taut::scenes
