#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "scenes/reader/reader.h"

namespace taut {

namespace {

ScenePin read_pin(const Document& document, const Value& value, const Paths& paths,
                  const World& world, double duration) {
  std::vector<std::string_view> names;
  for (const Connector& connector : world.connectors) names.push_back(connector.name);
  ScenePin pin;
  pin.connector = index_of(document, *value.find("connector"), names, "connector");
  pin.source = fmt::format("{}:{}", document.file.string(), value.place.line);

  const double length = world.connectors[pin.connector].length;
  const Value& at = *value.find("at");
  if (at.number > length) {
    document.mismatch(at,
                      fmt::format("at most the length of {}, {} m", names[pin.connector], length));
  }
  pin.at = at.number;

  const Value& from = *value.find("from");
  if (from.number >= duration) {
    document.mismatch(from, fmt::format("a time before the end of the scene, {} s", duration));
  }
  pin.from = from.number;
  pin.until = std::numeric_limits<double>::infinity();
  if (const Value* until = value.find("until")) {
    if (until->number <= pin.from) {
      document.mismatch(*until, fmt::format("a time after {} s", pin.from));
    }
    pin.until = until->number;
  }

  if (!value.find("point") && !value.find("body") && !value.find("path")) {
    document.fail(value, "expected a point, a body or a path that holds the pin");
  }
  pin.to = read_attachment(document, value, "point", paths, world);
  return pin;
}

/// Refuses two pins that hold a connector at the same time in places it cannot have. Only points
/// in space are known beforehand; what bodies do is seen when it happens.
void check_together(const Document& document, const Value& value, const ScenePin& a,
                    const ScenePin& b) {
  if (a.connector != b.connector || b.from >= a.until || a.from >= b.until) return;
  const double between = std::abs(a.at - b.at);
  if (between == 0) {
    document.fail(value,
                  fmt::format("holds the same place at the same time as the pin of {}", a.source));
  }
  const auto fixed = Attachment::Kind::fixed;
  if (a.to.kind != fixed || b.to.kind != fixed) return;
  const double apart = (a.to.point - b.to.point).norm();
  if (apart > between) {
    document.fail(value, fmt::format("is {:.6g} m away from the pin of {}, expected at most the "
                                     "{:.6g} m between them",
                                     apart, a.source, between));
  }
}

}  // namespace

std::vector<ScenePin> read_pins(const Document& document, const Paths& paths, const World& world,
                                double duration) {
  std::vector<ScenePin> pins;
  if (const Value* list = document.root.find("pins")) {
    for (const Value& value : list->children) {
      const ScenePin pin = read_pin(document, value, paths, world, duration);
      for (const ScenePin& other : pins) check_together(document, value, other, pin);
      pins.push_back(pin);
    }
  }
  return pins;
}

}  // namespace taut
