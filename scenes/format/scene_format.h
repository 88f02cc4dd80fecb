// The keys of scene files, table by table: type, unit, range and meaning.
#pragma once

#include <string>
#include <vector>

#include "scenes/format/document.h"
#include "scenes/format/format.h"

namespace taut::scenes::format_keys {

using Type = KeyFormat::Type;

// Generous, and small enough that no product of them overflows an int or fills a machine's memory.
inline constexpr double kLongest = 86400;      // s, a day
inline constexpr double kMostParticles = 1e5;  // of a connector
inline constexpr double kMostFps = 1000;
inline constexpr double kWidest = 16384;      // pixels
inline constexpr double kMostTurn = 1e6;      // rad
inline constexpr double kMostLaps = 1000;     // of a curve
inline constexpr double kMostPaidOut = 1e9;   // m, by a winch
inline constexpr double kFastestWinch = 1e4;  // m/s, by a winch
inline constexpr double kMostGravity = 1e9;   // m/s^2
inline constexpr double kMostFriction = 100;  // beyond, nothing ever slides

inline KeyFormat vector(std::string_view name, std::string_view meaning,
                        std::string_view unit = "m") {
  return {
      .name = name, .type = Type::numbers, .meaning = meaning, .unit = unit, .least = 3, .most = 3};
}

inline KeyFormat gravity() {
  KeyFormat key = vector("gravity", "Gravitational acceleration; default: [0, -9.81, 0].", "m/s^2");
  key.minimum = -kMostGravity;
  key.maximum = kMostGravity;
  return key;
}

inline KeyFormat color(std::string_view name, std::string_view meaning) {
  KeyFormat key = vector(name, meaning, "");
  key.minimum = 0;
  return key;
}

inline KeyFormat rotation(std::string_view meaning) {
  return {.name = "rotation", .type = Type::numbers, .meaning = meaning, .least = 4, .most = 4};
}

inline KeyFormat positive(std::string_view name, std::string_view meaning, std::string_view unit) {
  return {.name = name, .meaning = meaning, .unit = unit, .minimum = 0, .above = true};
}

inline KeyFormat not_negative(std::string_view name, std::string_view meaning,
                              std::string_view unit) {
  return {.name = name, .meaning = meaning, .unit = unit, .minimum = 0};
}

inline KeyFormat text(std::string_view name, std::string_view meaning) {
  return {.name = name, .type = Type::text, .meaning = meaning};
}

inline KeyFormat table(std::string_view name, std::string_view meaning, const TableFormat& format,
                       Type type = Type::table) {
  return {.name = name, .type = type, .meaning = meaning, .table = &format};
}

inline KeyFormat needed(KeyFormat key) {
  key.required = true;
  return key;
}

inline KeyFormat friction(
    std::string_view meaning = "Coefficient of kinetic friction; default: 0.") {
  return {
      .name = "friction", .meaning = meaning, .unit = "1", .minimum = 0, .maximum = kMostFriction};
}

inline KeyFormat static_friction() {
  return {.name = "static_friction",
          .meaning = "Coefficient of static friction; default: that of kinetic friction.",
          .unit = "1",
          .minimum = 0,
          .maximum = kMostFriction};
}

/// Keys of a number over time.
inline TableFormat number_keys(const char* name, const char* meaning, const char* unit,
                               double most) {
  return {
      {needed({.name = "t", .meaning = "Time of the key.", .unit = "s"}),
       needed({.name = name, .meaning = meaning, .unit = unit, .minimum = -most, .maximum = most}),
       {.name = "ease", .type = Type::flag, .meaning = "Comes to rest at this key."}}};
}

/// Keys of a length that changes, or of the speed at which it does.
inline TableFormat length_keys(const char* name, const char* meaning) {
  TableFormat format = number_keys(name, meaning, "m", kMostPaidOut);
  format.keys[1].required = false;
  format.keys.push_back({.name = "speed",
                         .meaning = "Speed at this key, instead of a length: 0 at the start, "
                                    "smooth and monotone between keys, constant after the last.",
                         .unit = "m/s",
                         .minimum = -kFastestWinch,
                         .maximum = kFastestWinch});
  format.alternatives = {{{name, "speed"}}, {{"ease", "speed"}, false}};
  return format;
}

}  // namespace taut::scenes::format_keys

namespace taut::scenes {

const TableFormat& path_format();
const TableFormat& obstacle_format();
const TableFormat& touching_format();
const TableFormat& material_format();
/// Keys of a connector that the cords of a net have, too, and which of them exclude each other.
std::vector<KeyFormat> cord_keys();
std::vector<Alternatives> cord_alternatives();
const TableFormat& drag_format();
const TableFormat& air_format();
const TableFormat& net_format();
const TableFormat& start_format();
const TableFormat& end_format();
const TableFormat& pulley_format();
const TableFormat& stage_format();
const TableFormat& choreography_format();
const TableFormat& plan_format();

// Keys of scene files that have another name now.

/// Gives every key that stands under the name it had (KeyFormat::formerly) its name of now, so that
/// the readers know one alone. Returns a sentence for each, with its place in the file.
std::vector<std::string> rename_old_keys(Document& document);

}  // namespace taut::scenes
