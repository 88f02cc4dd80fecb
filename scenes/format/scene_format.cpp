#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "scenes/format/format_keys.h"
#include "scenes/format/scene_keys.h"
#include "sim/run/method.h"

namespace taut::scenes {

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

const TableFormat& character_format() {
  static const TableFormat format{
      {needed({.name = "mesh", .type = Type::file, .meaning = "A skinned glTF or GLB model."}),
       needed(text("right_hand", "Name of the path that the right hand's grip follows.")),
       {.name = "head",
        .type = Type::tables,
        .meaning = "How the head turns when, beyond what follows from the hand; smooth between.",
        .least = 1,
        .table = &head_key_format()}}};
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
