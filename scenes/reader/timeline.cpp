#include <fmt/format.h>

#include "scenes/reader/reader.h"

namespace taut::scenes {

namespace {

class TimelineReader {
 public:
  TimelineReader(const Document& document, Motions& motions, const World& world, double duration)
      : document_(document), motions_(motions), world_(world), duration_(duration), names_([&] {
          std::vector<std::string_view> names;
          for (const Connector& connector : world.connectors) names.push_back(connector.name);
          return names;
        }()) {}

  TimedPin pin(const Value& value) const {
    TimedPin pin;
    pin.connector = connector(value);
    pin.along = along(value, pin.connector);
    pin.from = time(*value.find("from"));
    if (const Value* until = value.find("until")) {
      if (until->number <= pin.from) {
        document_.mismatch(*until, fmt::format("a time after {} s", pin.from));
      }
      pin.until = until->number;
    }
    if (value.find("point") || value.find("body") || value.find("path") || value.find("bone") ||
        value.find("character")) {
      pin.to = read_attachment(document_, value, "point", motions_);
    }
    pin.over = number_or(value, "over", 0);
    pin.source = source(value);
    return pin;
  }

  TimedCut cut(const Value& value) const {
    TimedCut cut;
    cut.connector = connector(value);
    cut.along = along(value, cut.connector);
    cut.time = time(*value.find("t"));
    cut.source = source(value);
    return cut;
  }

 private:
  std::size_t connector(const Value& value) const {
    return names_.index_of(document_, *value.find("connector"), "connector");
  }

  double along(const Value& value, std::size_t connector) const {
    const double length = world_.connectors[connector].length;
    const Value& at = *value.find("at");
    if (at.number > length) {
      document_.mismatch(at, fmt::format("at most the length of {}, {} m",
                                         world_.connectors[connector].name, length));
    }
    return at.number;
  }

  double time(const Value& value) const {
    if (value.number >= duration_) {
      document_.mismatch(value, fmt::format("a time before the end of the scene, {} s", duration_));
    }
    return value.number;
  }

  std::string source(const Value& value) const {
    return fmt::format("{}:{}:{}", (value.inherited ? document_.base : document_.file).string(),
                       value.place.line, value.place.column);
  }

  const Document& document_;
  Motions& motions_;
  const World& world_;
  double duration_;  // s
  Names names_;
};

}  // namespace

Timeline read_timeline(const Document& document, Motions& motions, const World& world,
                       double duration) {
  const TimelineReader reader(document, motions, world, duration);
  const Value* pins = document.root.find("pins");
  const Value* cuts = document.root.find("cuts");
  Timeline timeline;
  if (pins) {
    for (const Value& value : pins->children) timeline.pins.push_back(reader.pin(value));
  }
  if (cuts) {
    for (const Value& value : cuts->children) timeline.cuts.push_back(reader.cut(value));
  }
  if (const auto flaw = find_flaw(world, timeline)) {
    document.fail((flaw->cut ? cuts : pins)->children[flaw->index], flaw->what);
  }
  return timeline;
}

}  // namespace taut::scenes
