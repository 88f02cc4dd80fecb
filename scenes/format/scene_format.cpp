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
  static const TableFormat format{
      {needed(time_of("t", "Time at which it is passed.")),
       needed(vector("position", "Position of the body's point at that time."))}};
  return format;
}

const TableFormat& curve_format() {
  static const TableFormat end{{vector("centre", "Its centre."),
                                vector("across", "Vector from the centre to its side."),
                                vector("up", "Vector from the centre upward.")}};
  static const TableFormat format{
      {needed({.name = "figure",
               .type = Type::choice,
               .meaning = "circle: centre + across sin(a) - up cos(a), from its lowest point; "
                          "eight: centre + across sin(a) + up sin(2 a), from its middle.",
               .choices = {"circle", "eight"}}),
       needed(time_of("from", "When it begins.")), needed(time_of("until", "When it ends.")),
       needed({.name = "laps",
               .meaning = "Number of turns of the angle a: six waypoints each for a circle, eight "
                          "for an eight.",
               .minimum = 1,
               .maximum = kMostLaps,
               .whole = true}),
       needed(vector("centre", "Its centre.")),
       needed(vector("across", "Vector from the centre to its side.")),
       needed(vector("up", "Vector from the centre upward: half of its height.")),
       table("to", "Values that differ at its end; linear in between.", end)}};
  return format;
}

const TableFormat& limits_format() {
  static const TableFormat format{
      {needed(vector("shoulder", "Point from which the hand's reach is measured.")),
       positive("reach", "Largest distance from the shoulder; default: unlimited.", "m"),
       positive("speed", "Largest speed; default: unlimited.", "m/s"),
       positive("acceleration", "Largest acceleration; default: unlimited.", "m/s^2"),
       positive("clearance",
                "Smallest distance of the body, between its hold and the point, from the line "
                "between the pivot and the chain's end; default: it may pass through the line.",
                "m")}};
  return format;
}

}  // namespace

const TableFormat& choreography_format() {
  static const TableFormat format{
      {needed(text("body", "Name of the free body that is guided.")),
       vector("point",
              "Point of that body, on the line through its hold and its centre of mass; default: "
              "its origin."),
       needed(text("path",
                   "Name of the path that guides it, with `keys`: it rests at the last key before "
                   "the waypoints, and from `until` to the next key.")),
       needed({.name = "file",
               .type = Type::file,
               .meaning = "A CSV file beside the scene with the path's keys up to `until`, written "
                          "by `taut choreograph`."}),
       needed(time_of("until", "Time at which the path rests again, at the same place as before.")),
       positive("within", "Largest distance from each waypoint; default: 2 mm.", "m"),
       table("limits", "Limits of the hand.", limits_format()),
       positive("pivot",
                "Distance from the connector's driven end back to the pivot, from which the held "
                "body points away; default: the body keeps its orientation.",
                "m"),
       table("waypoints", "Positions of the point over time.", waypoint_format(), Type::tables),
       table("curves", "Figures that the point follows.", curve_format(), Type::tables)}};
  return format;
}

// The format of a connector's ends, and of the pulleys that it passes.

using namespace format_keys;

const TableFormat& end_format() {
  static const TableFormat turns =
      number_keys("angle", "Right-handed about the clamp's direction.", "rad", kMostTurn);
  static const TableFormat lengths =
      length_keys("paid_out", "Length paid out since the start; negative: taken in.");
  static const TableFormat format{
      {text("body", "Name of the body that holds the end."),
       vector("point", "Position on the body, path or bone, in its frame; default: its origin."),
       vector("fixed", "A point in space."),
       text("path", "Name of the path that carries the end."),
       text("bone", "Name of the character's bone that carries the end."),
       text("character", "Name of that character."),
       text("connector",
            "Name of the connector that the end is joined to: the two particles become one. Its "
            "own name makes a closed loop."),
       not_negative("at", "Position along that connector, at one of its particles.", "m"),
       positive("point_mass", "Mass of a point mass at the end.", "kg"),
       {.name = "free",
        .type = Type::flag,
        .meaning = "true: nothing holds the end.",
        .minimum = 1},
       vector("clamp",
              "Also holds the connector's direction, from first end to last, in the frame of the "
              "hold.",
              ""),
       {.name = "turn",
        .type = Type::tables,
        .meaning = "Rotation of the clamp about that direction over time, which twists the "
                   "connector; with angle 0 it starts untwisted. Smooth between keys.",
        .least = 1,
        .table = &turns},
       {.name = "winch",
        .type = Type::tables,
        .meaning = "Length paid out over time, at a fixed or driven end; all links share it, and "
                   "their number is constant. Smooth between keys.",
        .least = 1,
        .table = &lengths}},
      {{{"body", "fixed", "path", "bone", "connector", "point_mass", "free"}}}};
  return format;
}

const TableFormat& pulley_format() {
  static const TableFormat passed =
      length_keys("passed", "Length passed since the start; negative: backwards.");
  static const TableFormat format{
      {text("body", "Name of the body that carries it."),
       vector("point", "Position on the body, path or bone, in its frame; default: its origin."),
       vector("fixed", "A point in space."),
       text("path", "Name of the path that carries it."),
       text("bone", "Name of the character's bone that carries it."),
       text("character", "Name of that character."),
       not_negative("inertia",
                    "Moment of inertia of a sheave about its axle over its radius squared: for a "
                    "disc, half of its mass; default: an eye.",
                    "kg"),
       {.name = "friction",
        .meaning = "Coefficient of friction of the rope on an eye: tension ratio exp(friction "
                   "angle).",
        .unit = "1",
        .minimum = 0,
        .maximum = 8},
       {.name = "bearing",
        .meaning = "Friction coefficient of a sheave's axle times axle radius over sheave radius: "
                   "difference of the tensions over their sum, at half a turn.",
        .unit = "1",
        .minimum = 0,
        .maximum = 0.99},
       {.name = "passed",
        .type = Type::tables,
        .meaning = "Length of rope passed over time, for a driven pulley; default: it turns "
                   "freely. Not on a free body. Smooth between keys.",
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
       needed(positive("diameter", "Diameter of the rod.", "m")),
       needed(positive("density", "Density of the material.", "kg/m^3")),
       {.name = "poissons_ratio",
        .meaning = "Poisson's ratio, which gives GJ from EI; default: 0.3.",
        .minimum = -1,
        .maximum = 0.5,
        .above = true}}};
  return format;
}

const TableFormat& drag_format() {
  static const TableFormat format{
      {not_negative("across", "Coefficient for flow across it; 1.2 for a round rope.", "1"),
       not_negative("along", "Coefficient for flow along it; 0.01 to 0.1, more for a rough rope.",
                    "1")}};
  return format;
}

std::vector<KeyFormat> cord_keys() {
  return {
      {.name = "restitution",
       .meaning = "Coefficient of restitution when a span or a string becomes taut; default: 0.",
       .minimum = 0,
       .maximum = 1},
      {.name = "look",
       .type = Type::choice,
       .meaning = "How it is drawn.",
       .choices = {"chain", "rope", "cord"}},
      not_negative(
          "radius",
          "Radius of its beads and links for contact; default: half of the drawn diameter.", "m"),
      {.name = "contact",
       .type = Type::choice,
       .meaning = "Shape for contact with obstacles: beads, or capsules along the links.",
       .choices = {"beads", "links"}},
      {.name = "touches_itself",
       .type = Type::flag,
       .meaning = "Whether its links, as capsules, collide with each other, and with those of its "
                  "copies or cords; default: false."},
      friction("Coefficient of kinetic friction for `touches_itself`; default: 0."),
      static_friction(),
      positive("diameter", "Drawn diameter of the rope or cord, or width of a chain's links.", "m"),
      color("color", "Colour, linear RGB."),
      positive("axial_stiffness", "EA: tension per strain; default: links are rigid.", "N"),
      not_negative("axial_damping", "Tension per rate of strain, for links that stretch.", "N s"),
      not_negative("bending_stiffness", "EI: moment per curvature; default: it bends freely.",
                   "N m^2"),
      not_negative("bending_damping", "Moment per rate of curvature.", "N m^2 s"),
      table("material", "Solid round rod, which gives mass, EA, EI and GJ instead.",
            material_format()),
      positive("breaks_at",
               "Tension at which it breaks, in the middle of the first link that exceeds it; "
               "default: never.",
               "N"),
      table("drag", "Coefficients of air drag, based on its diameter.", drag_format())};
}

std::vector<Alternatives> cord_alternatives() {
  return {{{"mass", "material"}},
          {{"axial_stiffness", "material"}, false},
          {{"bending_stiffness", "material"}, false}};
}

const TableFormat& air_format() {
  static const TableFormat format{
      {not_negative("density", "Density of the air; default: 1.225.", "kg/m^3"),
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
                 .meaning = "Crossing cords, ropes with rungs, or spokes with rings.",
                 .choices = {"net", "ladder", "web"}}),
         needed(vector("origin", "Its upper left corner; of a web, its hub.")),
         needed(vector("across", "Its direction from left to right.", "")),
         needed(vector("down", "Its direction downwards.", "")),
         needed({.name = "size",
                 .type = Type::numbers,
                 .meaning = "Lengths of its cords across and downwards; of a web, its diameters.",
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
          .meaning = "Links of a cord between two knots; rungs and rings have one. Default: 1.",
          .minimum = 1,
          .maximum = 1000,
          .whole = true},
         positive("mass", "Total mass of the cords, shared by length.", "kg"),
         needed({.name = "held",
                 .type = Type::choice,
                 .meaning = "Knots that are held at their starting positions.",
                 .choices = {"nothing", "upper corners", "upper edge", "corners", "edges"}}),
         {.name = "slack",
          .meaning = "Extra length of cords between held knots, as a share of their length; they "
                     "start in waves. Default: 0.",
          .minimum = 0,
          .maximum = 0.5},
         {.name = "pleats",
          .meaning = "Number of waves of a cord. Default: 1.",
          .minimum = 1,
          .maximum = 1000,
          .whole = true},
         {.name = "cords",
          .type = Type::choice,
          .meaning = "Links: rigid rods, or strings that only pull and can fold.",
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
  static const TableFormat plane{{positive("size", "Edge of the drawn square; default: 4.", "m")}};
  static const TableFormat sphere{{needed(positive("diameter", "Diameter of the ball.", "m"))}};
  static const TableFormat capsule{
      {needed(positive("length", "Length along the y axis, without the caps.", "m")),
       needed(positive("diameter", "Diameter across the y axis.", "m"))}};
  static const TableFormat cylinder{
      {needed(positive("length", "Length along the y axis.", "m")),
       needed(positive("diameter", "Diameter across the y axis.", "m")), rounding()}};
  static const TableFormat box{{needed([] {
                                  KeyFormat key = vector("size", "Lengths along x, y and z.");
                                  key.minimum = 0;
                                  key.above = true;
                                  return key;
                                }()),
                                rounding()}};
  static const TableFormat format{
      {table("plane", "The half-space below y = 0; {}: of the default size.", plane),
       table("sphere", "A ball.", sphere),
       table("capsule", "A cylinder along y with hemispherical caps.", capsule),
       table("cylinder", "A cylinder along y.", cylinder), table("box", "A box.", box)},
      {{{"plane", "sphere", "capsule", "cylinder", "box"}}}};
  return format;
}

}  // namespace

const TableFormat& obstacle_format() {
  static const TableFormat format{
      {table("shape",
             "The solid, centred on the obstacle's origin; default for a bone: a capsule about the "
             "skin that moves with it.",
             surface_format()),
       text("path", "Name of the path that it follows; without a path, body or bone it is fixed."),
       text("body", "Name of the driven body that carries it."),
       text("bone", "Name of the character's bone that carries it."),
       text("character", "Name of that character."),
       vector("position",
              "Position of its origin, in the world or in the frame of its path, body or bone; "
              "default: [0, 0, 0]."),
       rotation("Rotation of its frame, as a quaternion [w, x, y, z]; default: none."),
       friction(),
       static_friction(),
       restitution("Newton's coefficient of restitution; default: 0."),
       {.name = "ignores",
        .type = Type::texts,
        .meaning =
            "Names of connectors, nets and free bodies that pass through it; default: none."},
       color("color", "Colour, linear RGB."),
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
        .meaning = "Names of free bodies with `contact` that collide with each other."},
       {.name = "connectors",
        .type = Type::texts,
        .meaning = "Names of connectors and nets: their beads collide with these bodies, their "
                   "links, as capsules, with the links of the others."},
       friction(),
       static_friction(),
       restitution("Newton's coefficient of restitution; default: 0.")}};
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
       needed(vector("position", "Position of the path.")),
       rotation("Orientation as a quaternion [w, x, y, z]; default: that of the key before."),
       vector("axis",
              "Direction of the y axis, instead of `rotation`, reached by the smallest turn.", ""),
       {.name = "ease", .type = Type::flag, .meaning = "Comes to rest at this key."},
       {.name = "hold",
        .meaning = "How long the path rests at this key.",
        .unit = "s",
        .minimum = kShortestHold,
        .maximum = kLongest}},
      {{{"rotation", "axis"}, false}}};
  return format;
}

const TableFormat& circle_format() {
  static const TableFormat format{
      {needed(vector("centre", "Centre of the circle.")),
       needed(vector("start", "Position at which the path rests until 0 s.")),
       needed(vector("axis", "Axis of rotation, right-handed, normal to the radius.", "")),
       needed({.name = "frequency",
               .meaning = "Turns per second, after the ramp.",
               .unit = "1/s",
               .minimum = 1e-3,
               .maximum = 1e3}),
       needed({.name = "ramp",
               .meaning = "Time in which the angular speed rises, as a smoothstep.",
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
      {needed(vector("position", "Position of the path.")),
       needed(vector("axis", "Axis of rotation, the y axis of the path's frame.", "")),
       needed({.name = "keys",
               .type = Type::tables,
               .meaning = "Angle over time; smooth between keys.",
               .least = 1,
               .table = &angles}),
       {.name = "pitch",
        .meaning = "Displacement along the axis per turn, like a screw; default: 0.",
        .unit = "m"}}};
  return format;
}

}  // namespace

const TableFormat& path_format() {
  static const TableFormat format{
      {{.name = "keys",
        .type = Type::tables,
        .meaning = "Positions over time; smooth between keys.",
        .least = 1,
        .table = &path_key_format()},
       {.name = "file",
        .type = Type::file,
        .meaning = "A CSV file with columns t,x,y,z[,qw,qx,qy,qz], instead of `keys`."},
       table("circle", "Circular motion that starts from rest, instead of `keys`.",
             circle_format()),
       table("axle", "Rotation about a fixed axis, instead of `keys`.", axle_format())},
      {{{"keys", "file", "circle", "axle"}}}};
  return format;
}

using namespace format_keys;

const TableFormat& plan_format() {
  static const TableFormat connector{
      {{.name = "particles",
        .meaning = "Number of particles, both ends included.",
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
               .meaning = "Work done on the scene: known work is left out of `energy`; with "
                          "unknown work `energy` is the change of the mean energy.",
               .choices = {"none", "known", "unknown"}}),
       needed(not_negative("energy", "Largest difference of the energy, as a share.", "1")),
       needed(not_negative(
           "stretch", "Largest difference of a link's stretch, as a share of its length.", "1")),
       needed(not_negative("speeds", "Share of the points whose speed differs.", "1"))}};
  static const TableFormat format{
      {needed(text("tolerance", "The tolerance asked for: 1px, 0.5mm.")),
       needed(not_negative("error", "Largest error up to `until`, in the tolerance's unit.", "")),
       needed(not_negative("until", "How long the motion is predictable.", "s")),
       text("end", "What ends the predictable motion: a pin comes, a cut is made."),
       table("afterwards", "Largest differences from reference solutions after `until`.",
             afterwards),
       {.name = "exposures",
        .meaning =
            "Largest number of exposures of a frame while the shutter is open, a power of two.",
        .minimum = 1,
        .maximum = 1024,
        .whole = true},
       needed(text("stamp", "Hash of what the plan was made from.")),
       needed(text("program", "Hash of the method's motion, in the program that made the plan.")),
       needed({.name = "method", .type = Type::method, .meaning = "The method and its settings."}),
       {.name = "neglected",
        .type = Type::texts,
        .meaning = "Physics of connectors that can be neglected: air, twist, bending, stretch."},
       table("connectors", "Particles or models that suffice.", connector, Type::named),
       table("bodies", "Bodies that need not be rigid bodies.", body, Type::named)}};
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
                                          .meaning = "Distance from the target.",
                                          .unit = "m",
                                          .minimum = 0,
                                          .maximum = kFarthest,
                                          .above = true})}};
  static const TableFormat trail{
      {text("body", "Name of the body whose point leaves the trail."),
       vector("point", "Point of that body, in its frame; default: its origin."),
       text("connector", "Name of the connector whose particle leaves the trail."),
       not_negative("at", "Position along it, from its first end; default: its last end.", "m"),
       {.name = "lasts",
        .meaning = "Length of the trail in time; default: 0.5.",
        .unit = "s",
        .minimum = 0,
        .maximum = kLongestTrail,
        .above = true},
       not_negative("from", "When it appears; default: at once.", "s"),
       positive("until", "When it goes; default: never.", "s"),
       {.name = "width",
        .meaning = "Width at the point, as a share of the picture's height; default: 0.012.",
        .minimum = 0,
        .maximum = 0.2,
        .above = true},
       color("color", "Colour, linear RGB.")},
      {{{"body", "connector"}}, {{"point", "connector"}, false}, {{"at", "body"}, false}}};
  static const TableFormat camera{
      {needed({.name = "t", .meaning = "Time of the key.", .unit = "s"}),
       vector("position", "Position of the eye."),
       table("orbit",
             "Position of the eye about the target, instead of `position`; between two keys with "
             "an orbit the eye circles the target.",
             orbit),
       needed(
           vector("target",
                  "Point that the camera looks at; with `follow`, relative to what it follows.")),
       text("follow",
            "Name of a body or connector: the target, and an eye on an orbit, move with its origin "
            "or the middle of its particles. The same in all keys of a camera."),
       {.name = "field_of_view",
        .meaning = "Vertical field of view; default: 0.6.",
        .unit = "rad",
        .minimum = 0,
        .maximum = 3,
        .above = true},
       {.name = "aperture",
        .meaning = "F-number of the lens for a picture 24 mm high, such as 2.8, which blurs "
                   "scenery out of focus; default: all is sharp.",
        .minimum = 0.5,
        .maximum = 1000},
       {.name = "focus",
        .meaning =
            "Distance along the view at which the lens is focused; default: that of the target.",
        .unit = "m",
        .minimum = 0.05,
        .maximum = 1000}},
      {{{"position", "orbit"}}}};
  static const KeyFormat camera_keys{.name = "camera",
                                     .type = Type::tables,
                                     .meaning = "Camera positions over time; smooth between keys.",
                                     .least = 1,
                                     .table = &camera};
  static const TableFormat shot{{needed(not_negative("from", "Time of its first frame.", "s")),
                                 needed(positive("until", "Time after its last frame.", "s")),
                                 {.name = "rate",
                                  .meaning = "Playback speed: 0.25 is slow motion; default: 1.",
                                  .minimum = 0.001,
                                  .maximum = 1000},
                                 camera_keys}};
  static const TableFormat card{
      {needed(positive("duration", "How long the card is shown.", "s")),
       needed(text("heading", "Its first line, in large letters.")),
       text("text", "The lines below; {method} stands for the method's name.")}};
  static const TableFormat light{
      {vector("direction", "Direction in which the key light travels.", ""),
       color("color", "Linear radiance of the key light."),
       color("sky", "Linear ambient light from above."),
       color("ground", "Linear ambient light from below."),
       color("rim",
             "Linear radiance at the edges of moving objects, as of a light behind them; default: "
             "none."),
       {.name = "scenery_casts",
        .type = Type::flag,
        .meaning = "Whether the scenery casts shadows, so that the key light enters only through "
                   "openings; default: false."}}};
  static const TableFormat caption{
      {needed(not_negative("from", "When it appears.", "s")),
       needed(positive("until", "When it goes.", "s")),
       needed(text("text", "What it says; a newline breaks the line.")),
       text("list", "Name of a list: its captions align the text after a tab in one column.")}};
  static const TableFormat format{
      {{.name = "scenery",
        .type = Type::files,
        .meaning = "Models that do not move, in world space."},
       camera_keys,
       {.name = "shots",
        .type = Type::tables,
        .meaning = "Shots of the clip in order, with hard cuts; default: the whole scene by the "
                   "camera above, which is also that of shots without one.",
        .least = 1,
        .table = &shot},
       table("title", "A card before the first shot.", card),
       table("end", "A card after the last shot.", card),
       {.name = "shutter",
        .meaning = "Share of a frame's time for which the shutter is open, centred on the frame; "
                   "0.5: 180 degrees; default: 0, no motion blur.",
        .minimum = 0,
        .maximum = 1},
       table("light", "Key light and ambient light.", light),
       color("background", "Background colour, linear RGB from 0 to 1, not tone-mapped."),
       table("captions", "Lines of text on the picture.", caption, Type::tables),
       table("trails", "Ribbons along the past path of a point.", trail, Type::tables)}};
  return format;
}

using namespace format_keys;

namespace {

const TableFormat& winding_format() {
  static const TableFormat format{
      {needed(text("obstacle", "Name of a fixed cylinder or capsule.")),
       {.name = "turns",
        .meaning =
            "Number of turns, right-handed about its y axis, side by side; default: 0.5, over it.",
        .unit = "1",
        .minimum = 0,
        .maximum = 1000},
       needed(not_negative("before", "Length of the straight piece to the first end.", "m"))}};
  return format;
}

}  // namespace

const TableFormat& start_format() {
  static const TableFormat circle{{needed(vector("centre", "Centre of the circle.")),
                                   needed(vector("axis", "Normal of the circle's plane.", ""))}};
  static const TableFormat format{
      {vector("direction",
              "Straight in this direction, from the first end or from the last pulley.", ""),
       {.name = "points",
        .type = Type::points,
        .meaning = "Along the line through these points, from the first end to the last; as long "
                   "as the connector, or longer if it stretches and is held there.",
        .unit = "m",
        .least = 2},
       vector("hanging_to", "Hanging at rest between the first end and this point."),
       table("over", "Over a round obstacle, both ends hanging from it.", winding_format()),
       table("circle",
             "A closed loop: a polygon whose sides are the links; the last particle is joined to "
             "the first.",
             circle),
       not_negative(
           "before",
           "Length up to the first pulley; default: the distance from the hold of the first end.",
           "m"),
       vector("spin",
              "Angular velocity as one rigid body about the first particle, the circle's centre or "
              "the last pulley.",
              "rad/s"),
       vector("push_out",
              "Direction in which beads that would start inside obstacles are moved to their "
              "surfaces; links keep their lengths.",
              "")},
      {{{"direction", "points", "hanging_to", "over", "circle"}, false}}};
  return format;
}

namespace {

using namespace format_keys;

const TableFormat& head_key_format() {
  static const TableFormat format{
      {needed({.name = "t", .meaning = "Time of the key.", .unit = "s"}),
       {.name = "yaw", .meaning = "Rotation to the left.", .unit = "rad"},
       {.name = "lean", .meaning = "Rotation forward.", .unit = "rad"},
       {.name = "tilt", .meaning = "Rotation to the right.", .unit = "rad"},
       {.name = "ease", .type = Type::flag, .meaning = "Comes to rest at this key."}}};
  return format;
}

const TableFormat& animation_format() {
  static const TableFormat format{
      {text("name", "Name of the animation in the file; default: the first."),
       {.name = "from",
        .meaning = "Time of the animation when the scene begins; default: 0.",
        .unit = "s",
        .minimum = -kLongest,
        .maximum = kLongest},
       {.name = "speed",
        .meaning = "Playback speed; default: 1.",
        .unit = "1",
        .minimum = 0,
        .maximum = 1000},
       vector("position", "Position of the model's origin; default: [0, 0, 0]."),
       rotation("Rotation of the model, as a quaternion [w, x, y, z].")}};
  return format;
}

const TableFormat& character_format() {
  static const TableFormat format{
      {needed({.name = "mesh",
               .type = Type::file,
               .meaning = "A skinned glTF or GLB model, or a BVH file of motion capture."}),
       text("right_hand", "Name of the path that the right hand's grip follows."),
       table("animation", "Plays an animation of the character's file, instead of `right_hand`.",
             animation_format()),
       {.name = "bones",
        .type = Type::names,
        .meaning = "Names of the model's bones: mixamo, or a table such as { Head = \"head_1\" }.",
        .choices = {"mixamo"}},
       positive("scale", "Scale of the model's lengths, such as 0.01 for centimetres; default: 1.",
                "1"),
       {.name = "head",
        .type = Type::tables,
        .meaning = "Additional rotation of the head over time; smooth between keys.",
        .least = 1,
        .table = &head_key_format()}},
      {{{"right_hand", "animation"}}, {{"head", "animation"}, false}}};
  return format;
}

const TableFormat& shape_format() {
  static const TableFormat cylinder{
      {needed(positive("length", "Length along the body's y axis.", "m")),
       needed(positive("diameter", "Diameter across the y axis.", "m"))}};
  static const TableFormat sphere{{needed(positive("diameter", "Diameter of the ball.", "m"))}};
  static const TableFormat box{{needed([] {
    KeyFormat key = vector("size", "Lengths along x, y and z.");
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
      {positive("radius", "Radius about the line; default: that of the cylinder or sphere.", "m"),
       vector("from",
              "Start of the line, in the body's frame; default: on the cylinder's axis, the radius "
              "from its end."),
       vector("to", "End of the line; default: the same at the cylinder's other end."),
       {.name = "ignores",
        .type = Type::texts,
        .meaning = "Names of free bodies that it passes through, even if `touching` names both; "
                   "default: none."}}};
  return format;
}

const TableFormat& body_format() {
  static const TableFormat format{
      {positive("mass",
                "Mass without attached connectors; default for fixed and driven bodies: 1, which "
                "has no effect.",
                "kg"),
       table("shape", "A solid of even density, centred on the body's origin.", shape_format()),
       {.name = "inertia",
        .type = Type::numbers,
        .meaning = "Inertia about the centre of mass: xx, yy, zz and, if they are not zero, all of "
                   "xy, yz, zx; instead of `shape`.",
        .unit = "kg m^2",
        .least = 3,
        .most = 6},
       vector("centre", "Centre of mass in the body's frame, with `inertia`; default: its origin."),
       table("driven_by",
             "Path or character that moves the body; default: the body is free, unless it is "
             "`fixed`.",
             driver_format()),
       vector("fixed", "Fixed position of the body's origin.", "m"),
       vector("grip", "Point of a driven body that the path carries; default: its origin."),
       vector("hangs", "The body hangs from its connector's end in this direction.", ""),
       vector("position", "Position of the body's origin at the start."),
       rotation("Rotation of the body's frame at the start, as a quaternion [w, x, y, z]."),
       vector("velocity", "Velocity of the centre of mass at the start.", "m/s"),
       vector("spin", "Angular velocity at the start, in the world's axes.", "rad/s"),
       table("contact",
             "Capsule for contact of a free body with obstacles, and with bodies and connectors in "
             "`touching`; {}: that of its cylinder or sphere. Without it the body passes through "
             "everything.",
             capsule_format()),
       {.name = "mesh",
        .type = Type::file,
        .meaning = "A glTF, GLB or OBJ model in the body's frame; default: its shape."},
       color("color", "Colour of the shape, linear RGB, if there is no mesh.")},
      {{{"shape", "inertia"}}, {{"driven_by", "fixed", "hangs", "position"}}}};
  return format;
}

const TableFormat& repeat_format() {
  static const TableFormat format{
      {needed({.name = "count",
               .meaning = "Number of copies, the first included.",
               .minimum = 1,
               .maximum = kMostParticles,
               .whole = true}),
       needed(vector("by", "Offset from one to the next.")),
       not_negative("delay", "Delay of the paths from one to the next.", "s")}};
  return format;
}

const TableFormat& connector_format() {
  static const TableFormat format = [] {
    TableFormat made{
        {needed(not_negative("length", "Length of all links together; 0: a joint of two particles.",
                             "m")),
         not_negative("mass",
                      "Mass, shared evenly by the particles, ends included; with a taper or in a "
                      "closed loop by the links, half at each of their ends.",
                      "kg"),
         needed({.name = "particles",
                 .meaning = "Number of particles: one more than links.",
                 .unit = "",
                 .minimum = 2,
                 .maximum = kMostParticles,
                 .whole = true}),
         needed(table("from", "What holds the first particle.", end_format())),
         needed(table("to", "What holds the last particle.", end_format())),
         table("start",
               "Shape at the start; default: hanging between ends of known position, together with "
               "connectors joined end to end, else straight along gravity.",
               start_format()),
         {.name = "over",
          .type = Type::texts,
          .meaning = "Names of the pulleys that the rope passes, from its first end to its last. "
                     "Its spans between them are connectors NAME, NAME#2 and so on, each with "
                     "`particles` particles. If both ends are held and the length is within 1e-4 "
                     "of taut, it starts taut.",
          .least = 1},
         table("repeat", "Copies in a row; a second entry: copies of that row, and so on.",
               repeat_format(), Type::tables),
         {.name = "model",
          .type = Type::choice,
          .meaning = "Rigid links with mass, or a massless span.",
          .choices = {"links", "span"}},
         {.name = "links",
          .type = Type::choice,
          .meaning = "Rigid rods, or strings that only pull and can fold.",
          .choices = {"rigid", "pull"}},
         vector("rest_curvature",
                "Curvature at rest, along the normal of the plane of motion, right-handed from the "
                "first end.",
                "1/m"),
         positive("twisting_stiffness",
                  "GJ: moment per twist, between clamped ends; default: it twists freely.",
                  "N m^2"),
         not_negative("twisting_damping", "Moment per rate of twist.", "N m^2 s"),
         {.name = "rest_twist",
          .meaning = "Twist at rest in addition to that at the start.",
          .unit = "rad/m"},
         {.name = "taper",
          .type = Type::numbers,
          .meaning =
              "Diameters along it, evenly spaced and linear in between, as shares of its diameter: "
              "EI and GJ scale with the fourth power, EA and mass with the second.",
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
       needed(not_negative("at", "Position along it, from its first end.", "m")),
       needed(not_negative("from", "Time at which it is caught.", "s")),
       positive("until", "Time at which it is released; default: never.", "s"),
       not_negative("over", "Time in which it is drawn to where it is held; default: at once.",
                    "s"),
       vector(
           "point",
           "Where it is held: in space, or on the body, path or bone; without these, where it is."),
       text("body", "Name of the body that holds it."),
       text("path", "Name of the path that carries it."),
       text("bone", "Name of the character's bone that carries it."),
       text("character", "Name of that character.")},
      {{{"body", "path", "bone"}, false}}};
  return format;
}

const TableFormat& cut_format() {
  static const TableFormat format{
      {needed(text("connector", "Name of the connector that is cut.")),
       needed(not_negative("at", "Position along it, from its first end.", "m")),
       needed(not_negative("t", "Time of the cut.", "s"))}};
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
           "A scene file beside this one; tables and keys at the top level that are missing here "
           "are taken from it."),
      text("title", "Title of the clip; default: the file's name."),
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
      table("air", "Air, which drags connectors with `drag`.", air_format()),
      {.name = "method",
       .type = Type::method,
       .meaning = "The method that advances the world, and its settings."},
      table("paths", "Prescribed motions.", path_format(), Type::named),
      table("characters", "Characters.", character_format(), Type::named),
      table("bodies", "Rigid bodies.", body_format(), Type::named),
      table("connectors", "Ropes, chains and cords.", connector_format(), Type::named),
      table("pulleys", "Eyes and sheaves without size that ropes pass.", pulley_format(),
            Type::named),
      table("nets", "Nets, rope ladders and webs; their cords are connectors NAME#1 and so on.",
            net_format(), Type::named),
      table("obstacles", "Solids with which connectors and free bodies collide.", obstacle_format(),
            Type::named),
      table("touching",
            "Groups of free bodies and connectors that collide; others pass through each other.",
            touching_format(), Type::named),
      table("pins", "Points of a connector that are held for some time.", pin_format(),
            Type::tables),
      table("cuts", "Permanent cuts of a connector.", cut_format(), Type::tables),
      table("choreography",
            "Waypoints of a guided free body; `taut choreograph` finds the hand's path.",
            choreography_format()),
      table("stage", "Settings of the pictures.", stage_format()),
      table("plan", "Written by `taut plan --write`; used with `--planned`.", plan_format()),
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
