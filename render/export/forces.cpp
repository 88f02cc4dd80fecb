#include "render/export/forces.h"

#include <fmt/format.h>

#include <algorithm>

namespace taut::exporting {
namespace {

std::string numbers(const Vec3& v) {
  return fmt::format("{:.17g},{:.17g},{:.17g}", v.x(), v.y(), v.z());
}

std::string holder(const World& world, const Forces::Hold& hold) {
  const auto& holds = world.connectors[hold.connector].holds;
  const auto at = std::ranges::find(holds, hold.particle, &Hold::particle);
  if (at == holds.end()) return "";
  switch (at->to.kind) {
    case Attachment::Kind::fixed:
      return "fixed";
    case Attachment::Kind::path:
      return "path";
    case Attachment::Kind::body:
      return world.bodies[at->to.body].name;
  }
  return "";
}

std::string cells(const Named& of) {
  return of.name + ',' + of.part;
}

}  // namespace

std::string forces_header() {
  return "t,what,of,part,with,with_part,x,y,z,fx,fy,fz,size\n";
}

std::string forces_rows(const World& world, const Forces& forces, std::span<const Event> events) {
  std::string text;
  for (const Event& event : events) {
    const std::string_view kind = kind_name(event.kind);
    const bool strikes = event.kind == Event::Kind::impulse || event.kind == Event::Kind::hit;
    const std::string size = strikes ? fmt::format("{:.17g}", event.size) : "";
    if (event.of_contact) {
      text += fmt::format("{:.17g},{},{},{},{},,,,{}\n", event.time, kind,
                          cells(named(world, event.one)), cells(named(world, event.other)),
                          numbers(event.place), size);
    } else {
      text += fmt::format("{:.17g},{},{},{},,,,,,,,,{}\n", event.time, kind,
                          world.connectors[event.connector].name, event.span, size);
    }
  }
  const auto add = [&](const char* what, const Named& of, const Named& with, const Vec3& place,
                       const Vec3& force, double size) {
    text += fmt::format("{:.17g},{},{},{},{},{},{:.17g}\n", forces.time, what, cells(of),
                        cells(with), numbers(place), numbers(force), size);
  };
  for (const Forces::Link& at : forces.links) {
    add("tension", named(world, at), {}, at.place, at.tension * at.direction, at.tension);
  }
  for (const Forces::Hold& at : forces.holds) {
    add("hold", named(world, at), {holder(world, at), ""}, at.place, at.force, at.force.norm());
    if (at.moment.isZero(0)) continue;
    add("moment", named(world, at), {holder(world, at), ""}, at.place, at.moment, at.moment.norm());
  }
  for (const Forces::Contact& at : forces.contacts) {
    add("contact", named(world, at.one), named(world, at.other), at.place, at.force,
        at.force.norm());
  }
  return text;
}

}  // namespace taut::exporting
