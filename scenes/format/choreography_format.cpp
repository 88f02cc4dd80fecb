#include "scenes/format/format_keys.h"

namespace taut::scenes {
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

}  // namespace taut::scenes
