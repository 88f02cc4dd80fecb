#include "scenes/load/plan_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scenes/files/files.h"
#include "scenes/reader/reader.h"
#include "sim/motion/hash.h"
#include "sim/run/simulation.h"

namespace taut::scenes {
namespace {

constexpr std::string_view kRemark = "  # what taut plan found; --planned takes it";

/// Marks the lines on which the keys, headings and values of a table's member stand.
void mark(const Value& value, std::vector<bool>& lines) {
  for (int line = value.key_place.line; line <= value.last_line; ++line) {
    lines.at(static_cast<std::size_t>(line)) = true;
  }
  for (const Value& child : value.children) mark(child, lines);
}

/// The text without the plan, and without space at its end. Remarks within the plan go with it,
/// those behind it stay.
std::string without_plan(std::string_view text) {
  const Document document = parse_document("scene", text);
  const Value* plan = document.root.find("plan");
  std::vector<bool> lines(static_cast<std::size_t>(std::ranges::count(text, '\n')) + 2);
  if (plan) mark(*plan, lines);
  std::string rest, remarks;
  bool within = false;  // the last line but for remarks and empty ones is the plan's
  for (std::size_t begin = 0, number = 1; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    const std::string_view line = text.substr(begin, end - begin);
    const std::size_t first = line.find_first_not_of(" \t\r\n");
    const bool is_empty = first == std::string_view::npos;
    if (lines[number]) {
      within = true;
      remarks.clear();
    } else if (within && is_empty) {
      if (!remarks.empty()) remarks += line;
    } else if (within && line[first] == '#') {
      remarks += line;
    } else {
      rest += remarks;
      rest += line;
      remarks.clear();
      within = false;
    }
    begin = end;
  }
  rest += remarks;
  rest.erase(rest.find_last_not_of(" \n") + 1);
  return rest;
}

constexpr std::string_view words_of_work[] = {"none", "known", "unknown"};

/// A rope that swings in a plane.
World small_swing() {
  World world;
  Connector rope = straight_connector("rope", 0.1, 0.02, 6, {0, 0, 0}, {1, 0, 0});
  rope.holds = {{0, Attachment{}}};
  world.connectors.push_back(std::move(rope));
  finish(world);
  return world;
}

/// A driven chain in space that carries a stick.
World small_throw() {
  World world;
  Body stick;
  stick.name = "stick";
  stick.mass_properties = solid_cylinder(0.1, 0.2, 0.02);
  stick.position = {0.1, -0.1, 0};
  stick.spin = {1, 0, 0};
  world.bodies.push_back(stick);
  Connector chain = straight_connector("chain", 0.1, 0.02, 6, {0, 0, 0}, {1, 0, 0});
  Attachment hand, tip;
  hand.kind = Attachment::Kind::path;
  hand.path = std::make_shared<const Path>(
      std::vector<PathKey>{{0, {0, 0, 0}}, {0.1, {0.01, 0.02, 0.01}}, {0.2, {0, 0, 0.02}}});
  tip.kind = Attachment::Kind::body;
  tip.point = {0, 0.1, 0};
  chain.holds = {{0, hand}, {5, tip}};
  world.connectors.push_back(std::move(chain));
  finish(world);
  return world;
}

std::string toml(const Setting& value) {
  const bool quoted = std::holds_alternative<std::string>(value);
  return quoted ? '"' + setting_text(value) + '"' : setting_text(value);
}

}  // namespace

std::uint64_t plan_stamp(const std::filesystem::path& scene) {
  const Document document = read_document(scene);
  Hash hash;
  hash.text(without_plan(read_scene_text(scene)));
  if (!document.base.empty()) hash.text(without_plan(read_bytes(document.base)));
  if (const Value* paths = document.root.find("paths")) {
    for (const Value& path : paths->children) {
      if (const Value* file = path.find("file")) hash.text(read_bytes(find_file(document, *file)));
    }
  }
  if (const Value* choreography = document.root.find("choreography")) {
    const Value* file = choreography->find("file");
    if (file) hash.text(read_bytes(find_file(document, *file)));
  }
  return hash.value();
}

std::uint64_t method_stamp(const MethodChoice& method) {
  constexpr double kSame = 1e-9;  // m
  Hash hash;
  for (const World& world : {small_swing(), small_throw()}) {
    try {
      Simulation simulation(world, make_method(method.name, method.settings));
      for (const double time : {0.05, 0.1}) {
        simulation.advance_to(time);
        const Snapshot state = simulation.state();
        for (const Vec3& at : state.connectors[0]) {
          for (const double x : at) hash.number(std::llround(x / kSame));
        }
      }
    } catch (const Diverged&) {
      hash.text("diverged");
    }
  }
  return hash.value();
}

std::string with_plan(std::string_view text, const Plan& plan) {
  std::string method = fmt::format("name = \"{}\"", plan.method.name);
  for (const auto& [name, value] : plan.method.settings) {
    method += fmt::format(", {} = {}", name, toml(value));
  }
  std::string connectors;
  for (const auto& [name, particles] : plan.particles) {
    const std::string model =
        particles > 0 ? fmt::format("particles = {}", particles) : "model = \"span\"";
    connectors += fmt::format("{}{} = {{ {} }}", connectors.empty() ? "" : ", ", name, model);
  }
  std::string bodies;
  for (const std::string& name : plan.links) {
    bodies += fmt::format("{}{} = {{ model = \"link\" }}", bodies.empty() ? "" : ", ", name);
  }
  std::string table =
      fmt::format("[plan]{}\ntolerance = \"{}\"\nerror = {:.3g}\nuntil = {:.6g}  # s\n", kRemark,
                  plan.tolerance, plan.error, plan.until);
  if (!plan.end.empty()) table += fmt::format("end = \"{}\"\n", plan.end);
  if (const auto& later = plan.afterwards) {
    table += fmt::format(
        "afterwards = {{ work = \"{}\", energy = {:.3g}, stretch = {:.3g}, speeds = {:.3g} }}\n",
        words_of_work[static_cast<std::size_t>(later->work)], later->energy, later->stretch,
        later->speeds);
  }
  if (plan.exposures > 0) table += fmt::format("exposures = {}\n", plan.exposures);
  table += fmt::format("stamp = \"{:016x}\"\nprogram = \"{:016x}\"\nmethod = {{ {} }}\n",
                       plan.stamp, plan.program, method);
  if (!plan.neglected.empty()) {
    std::string names;
    for (const Physics one : plan.neglected) {
      names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", name_of(one));
    }
    table += fmt::format("neglected = [{}]\n", names);
  }
  if (!connectors.empty()) table += fmt::format("connectors = {{ {} }}\n", connectors);
  if (!bodies.empty()) table += fmt::format("bodies = {{ {} }}\n", bodies);
  return without_plan(text) + "\n\n" + table;
}

}  // namespace taut::scenes
