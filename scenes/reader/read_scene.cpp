#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "scenes/files/files.h"
#include "scenes/format/format.h"
#include "scenes/format/scene_format.h"
#include "scenes/reader/reader.h"

namespace taut::scenes {
namespace {

/// A plan is the program's own: one of another version's format spoils no scene.
std::optional<Value> take_plan(Document& document) {
  std::vector<Value>& all = document.root.children;
  const auto plan = std::ranges::find(all, "plan", &Value::name);
  if (plan == all.end()) return std::nullopt;
  Value taken = std::move(*plan);
  all.erase(plan);
  return taken;
}

void try_plan(const Document& document, const Value& plan, Scene& scene) {
  try {
    scene.plan = read_plan(document, plan, scene.fps);
  } catch (const BadScene& error) {
    scene.strange_plan = error.what();
  }
}

}  // namespace

Scene read_scene(Document document, bool with_stage) {
  const std::optional<Value> plan = take_plan(document);
  rename_old_keys(document);
  check_format(document);
  const Value& root = document.root;
  Scene scene;
  scene.file = document.file;
  const bool is_input = document.file == kStandardInput;
  scene.title = text_or(root, "title", is_input ? "standard input" : document.file.stem().string());
  scene.duration = root.find("duration")->number;
  scene.fps = static_cast<int>(number_or(root, "fps", scene.fps));
  if (const Value* size = root.find("size")) {
    scene.width = static_cast<int>(size->children[0].number);
    scene.height = static_cast<int>(size->children[1].number);
  }
  scene.method = read_method(document, root.find("method"), scene.fps, scene.duration);
  scene.world.gravity = vec3_or(root, "gravity", scene.world.gravity);
  scene.world.air = read_air(document);
  Motions motions(document);
  scene.world.bodies = read_bodies(document, motions);
  read_connectors(document, motions, scene.world);
  read_nets(document, scene.world);
  read_obstacles(document, motions, scene.world);
  read_touching(document, scene.world);
  push_out_starts(document, scene.world);
  refuse_unfollowed(document, scene);
  finish(scene.world);
  check_obstacles(document, scene.world);
  check_touching(document, scene.world);
  scene.timeline = read_timeline(document, motions, scene.world, scene.duration);
  refuse_unfollowed(document, scene);
  check_curvatures(document, scene.world, scene.timeline);
  if (const Value* table = root.find("choreography")) {
    read_choreography(document, *table, motions, scene);  // only to say what is wrong with it
  }
  if (plan) try_plan(document, *plan, scene);
  if (with_stage && root.find("stage")) read_stage(document, motions, scene);
  return scene;
}

MethodChoice read_method(const Document& document, const Value* table, int fps, double duration) {
  if (!table) return default_method();
  const Value& name = *table->find("name");
  const MethodInfo& method = *find_method(name.text);
  if (!method.missing.empty()) {
    document.mismatch(name, fmt::format("a method that this build has ({})", method.missing));
  }
  MethodChoice choice{name.text, {}};
  for (const Value& member : table->children) {
    if (&member == &name) continue;
    if (member.kind == Value::Kind::flag) {
      choice.settings[member.name] = member.flag;
    } else if (member.kind == Value::Kind::text) {
      choice.settings[member.name] = member.text;
    } else {
      choice.settings[member.name] = member.number;
    }
  }
  if (const Value* step = table->find("step")) {
    const std::string wrong = step_complaint(choice.settings, duration);
    if (!wrong.empty()) document.fail(*step, wrong);
    const auto exact = dividing_step(step->number, fps);
    if (!exact) document.mismatch(*step, dividing_text(step->number, fps));
    choice.settings["step"] = *exact;
  }
  return choice;
}

namespace {

std::uint64_t hexadecimal(const Document& document, const Value& value) {
  std::uint64_t number = 0;
  const char* const end = value.text.data() + value.text.size();
  const auto [last, error] = std::from_chars(value.text.data(), end, number, 16);
  if (error != std::errc() || last != end || value.text.size() != 16) {
    document.mismatch(value, "16 hexadecimal digits");
  }
  return number;
}

Plan::Afterwards read_afterwards(const Value& table) {
  using Work = Plan::Afterwards::Work;
  const std::string_view work = table.find("work")->text;
  return {.work = work == "none"    ? Work::none
                  : work == "known" ? Work::known
                                    : Work::unknown,
          .energy = table.find("energy")->number,
          .stretch = table.find("stretch")->number,
          .speeds = table.find("speeds")->number};
}

/// Calls `visit` for each member of the table `name`, all of which must be members of the scene's.
template <class Visit>
void each_of_scene(const Document& document, const Value& plan, std::string_view name,
                   const char* unknown, Visit visit) {
  const Value* all = document.root.find(name);
  const Value* some = plan.find(name);
  if (!some) return;
  for (const Value& one : some->children) {
    if (!all || !all->find(one.name)) document.fail_at_key(one, unknown);
    visit(one);
  }
}

}  // namespace

Plan read_plan(const Document& document, const Value& table, int fps) {
  check_format(document, table, plan_format());
  Plan plan;
  const Value& tolerance = *table.find("tolerance");
  if (!read_length(tolerance.text)) document.mismatch(tolerance, "as in 1px or 0.5mm");
  plan.tolerance = tolerance.text;
  plan.error = table.find("error")->number;
  plan.until = table.find("until")->number;
  plan.end = text_or(table, "end", "");
  if (const Value* later = table.find("afterwards")) plan.afterwards = read_afterwards(*later);
  plan.exposures = static_cast<int>(number_or(table, "exposures", 0));
  plan.stamp = hexadecimal(document, *table.find("stamp"));
  plan.program = hexadecimal(document, *table.find("program"));
  plan.method = read_method(document, table.find("method"), fps, plan.until);
  if (const Value* neglected = table.find("neglected")) {
    for (const Value& name : neglected->children) {
      const auto physics = physics_named(name.text);
      if (!physics) document.mismatch(name, "one of: air, twist, bending, stretch");
      plan.neglected.push_back(*physics);
    }
  }
  each_of_scene(
      document, table, "connectors", "is no connector of the scene", [&](const Value& one) {
        plan.particles[one.name] = static_cast<std::size_t>(number_or(one, "particles", 0));
      });
  each_of_scene(document, table, "bodies", "is no body of the scene",
                [&](const Value& one) { plan.links.push_back(one.name); });
  return plan;
}

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
