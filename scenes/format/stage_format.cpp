#include "scenes/format/format_keys.h"

namespace taut::scenes {

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

}  // namespace taut::scenes
