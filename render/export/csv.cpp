#include "render/export/csv.h"

#include <fmt/format.h>

#include <algorithm>

namespace taut::exporting {
namespace {

class CsvWriter final : public FrameWriter {
 public:
  CsvWriter(const scenes::Scene& scene, WriteBytes write) : write_(std::move(write)) {
    write_(csv_header(scene) + '\n');
  }
  void add(const ExportState& state) override { write_(csv_row(state.state) + '\n'); }
  void finish() override {}

 private:
  WriteBytes write_;
};

}  // namespace

std::string csv_header(const scenes::Scene& scene) {
  const World world = divided(scene.world, scene.timeline);
  std::string line = "t";
  for (const Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      for (const char axis : {'x', 'y', 'z'}) {
        line += fmt::format(",{}.{}.{}", connector.name, i, axis);
      }
    }
  }
  for (const Body& body : world.bodies) {
    for (const char* part : {"x", "y", "z", "qw", "qx", "qy", "qz"}) {
      line += fmt::format(",{}.{}", body.name, part);
    }
  }
  for (const Pulley& pulley : world.pulleys) line += fmt::format(",{}.passed", pulley.name);
  return line;
}

std::string csv_row(const Snapshot& state) {
  std::string line = fmt::format("{:.17g}", state.time);
  const auto add = [&line](double number) {
    fmt::format_to(std::back_inserter(line), ",{:.17g}", number);
  };
  for (const auto& particles : state.connectors) {
    for (const Vec3& particle : particles) std::ranges::for_each(particle, add);
  }
  for (const Pose& frame : state.bodies) {
    const Quat& q = frame.rotation;
    std::ranges::for_each(frame.position, add);
    for (const double part : {q.w(), q.x(), q.y(), q.z()}) add(part);
  }
  std::ranges::for_each(state.passed, add);
  return line;
}

std::unique_ptr<FrameWriter> csv_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<CsvWriter>(scene, std::move(write));
}

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
