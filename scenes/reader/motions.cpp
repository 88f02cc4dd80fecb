#include "scenes/reader/motions.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "scenes/character/character.h"
#include "scenes/character/skeleton.h"
#include "scenes/files/files.h"
#include "scenes/format/scene_format.h"
#include "scenes/model/load_model.h"
#include "scenes/reader/common.h"
#include "sim/motion/rotation.h"

namespace taut::scenes {
namespace {

/// A character's performance is worked out as a whole, beforehand; a longer one would fill a
/// machine's memory.
constexpr double kLongestPerformance = 600;  // s

/// The figure's names of bones, and the model's, as a table says them.
BoneNames read_bone_names(const Document& document, const Value& table) {
  static const Names known(known_bones());
  BoneNames names;
  for (const Value& member : table.children) {
    Value name = member;  // the key itself is what is looked for
    name.text = member.name;
    name.place = member.key_place;
    known.index_of(document, name, "bone");
    names.emplace_back(member.name, member.text);
  }
  return names;
}

/// The model of a character, in metres and with the figure's names of bones. Throws BadAsset too.
std::shared_ptr<Model> read_figure(const Document& document, const Value& character) {
  const Value& mesh = *character.find("mesh");
  const Value* names = character.find("bones");
  const bool listed = names && names->kind == Value::Kind::table;
  const BoneNames of_table = listed ? read_bone_names(document, *names) : BoneNames();
  const FoundFile found = find_asset(document, mesh);
  return with_place(document, mesh, [&] {
    auto model = std::make_shared<Model>(load_model(found.file, found.within));
    if (const Value* scale = character.find("scale")) enlarge(*model, scale->number);
    if (names && !listed) rename_bones(*model, mixamo_names(*model));
    if (listed) with_place(document, *names, [&] { rename_bones(*model, of_table); });
    return model;
  });
}

/// The stick that hangs by a chain from the body of that name, or none.
std::optional<FreeStick> read_free_stick(const Document& document, const Value& held) {
  const Value* connectors = document.root.find("connectors");
  if (!connectors) return {};
  for (const Value& connector : connectors->children) {
    const Value *from = connector.find("from"), *to = connector.find("to");
    if (!from || !to || text_or(*from, "body", "") != held.name) continue;
    const Value* bodies = document.root.find("bodies");
    const Value* free = to->find("body") ? bodies->find(to->find("body")->text) : nullptr;
    const Value* shape = free && free->find("hangs") ? free->find("shape") : nullptr;
    const Value* cylinder = shape ? shape->find("cylinder") : nullptr;
    if (!cylinder || !free->find("mass")) continue;
    return FreeStick{
        .from = vec3_or(*from, "point", Vec3::Zero()) - vec3_or(held, "grip", Vec3::Zero()),
        .chain = connector.find("length")->number,
        .chain_mass = number_or(connector, "mass", 0),
        .mass = free->find("mass")->number,
        .length = cylinder->find("length")->number,
        .diameter = cylinder->find("diameter")->number};
  }
  return {};
}

/// The body that the character of that name holds, with a shape; null where it holds none.
const Value* find_held(const Document& document, const Value& character) {
  const Value* bodies = document.root.find("bodies");
  const Value* held = nullptr;
  if (!bodies) return held;
  for (const Value& body : bodies->children) {
    const Value* driver = body.find("driven_by");
    if (!driver || !driver->find("hand") || !body.find("shape")) continue;
    if (text_or(*driver, "character", "") == character.name) held = &body;
  }
  return held;
}

double held_diameter(const Value* held, double fallback) {
  return held ? number_or(held->find("shape")->children.front(), "diameter", fallback) : fallback;
}

/// The stick that the character of that name holds; the path alone where it holds none.
HeldStick read_held_stick(const Document& document, const Value& character,
                          const Motions& motions) {
  HeldStick stick{motions.path(*character.find("right_hand"))};
  if (const Value* held = find_held(document, character)) {
    stick.diameter = held_diameter(held, stick.diameter);
    stick.free = read_free_stick(document, *held);
  }
  return stick;
}

/// How the animation of a character is played.
Playback read_playback(const Document& document, const Value& table, const Model& model) {
  if (model.animations.empty())
    document.fail(table, fmt::format("{} has no animation that moves it", model.name));
  Playback playback;
  if (const Value* name = table.find("name")) {
    std::vector<std::string_view> names;
    for (const Animation& animation : model.animations) names.push_back(animation.name);
    playback.animation = Names(names).index_of(document, *name, "animation");
  }
  playback.from = number_or(table, "from", 0);
  playback.speed = number_or(table, "speed", 1);
  playback.place.position = vec3_or(table, "position", Vec3::Zero());
  if (const Value* turn = table.find("rotation")) {
    playback.place.rotation = rotation(document, *turn);
  }
  return playback;
}

/// Keys in order of their times; `place_of(entry)` is the position of each.
template <typename PlaceOf>
Path keyed_path(const Document& document, const Value& list, const PlaceOf& place_of) {
  std::vector<PathKey> keys;
  for (const Value& entry : list.children) {
    const Value& time = *entry.find("t");
    if (!keys.empty() && !(time.number > keys.back().time)) {
      document.mismatch(
          time, fmt::format("a time after {} s, that of the key before it", keys.back().time));
    }
    keys.push_back({time.number, place_of(entry), Quat::Identity(), flag_or(entry, "ease", false)});
  }
  return Path(std::move(keys));
}

/// How the head turns, as make_performance() wants it.
Path read_head(const Document& document, const Value& list) {
  return keyed_path(document, list, [](const Value& entry) {
    return Vec3(number_or(entry, "yaw", 0), number_or(entry, "lean", 0),
                number_or(entry, "tilt", 0));
  });
}

}  // namespace

Motions::Motions(const Document& document)
    : document_(document),
      paths_(read_paths(document)),
      path_names_(document.root.find("paths")),
      body_names_(document.root.find("bodies")),
      character_names_(document.root.find("characters")) {}

std::size_t Motions::body(const Value& name) const {
  return body_names_.index_of(document_, name, "body");
}

std::size_t Motions::character_named(const Value& name) const {
  return character_names_.index_of(document_, name, "character");
}

std::shared_ptr<const Path> Motions::path(const Value& name) const {
  return paths_[path_names_.index_of(document_, name, "path")];
}

const Value& Motions::path_value(const Value& name) const {
  return document_.root.find("paths")->children[path_names_.index_of(document_, name, "path")];
}

const Character& Motions::character(std::size_t index) {
  const auto known = characters_.find(index);
  if (known != characters_.end()) return known->second;
  const Value& value = document_.root.find("characters")->children.at(index);
  return characters_.emplace(index, act(value)).first->second;
}

Character Motions::act(const Value& character) const {
  const Value& mesh = *character.find("mesh");
  const Value& duration = *document_.root.find("duration");
  if (duration.number > kLongestPerformance) {
    document_.mismatch(duration, fmt::format("at most {} s with characters", kLongestPerformance));
  }
  const std::shared_ptr<Model> model = read_figure(document_, character);
  if (const Value* animation = character.find("animation")) {
    const Playback playback = read_playback(document_, *animation, *model);
    const double diameter = held_diameter(find_held(document_, character), 0);
    return with_place(document_, mesh, [&] {
      return Character{model, play_animation(model, playback, diameter)};
    });
  }
  leave_out_animations(*model, mesh.text);
  return with_place(document_, mesh, [&] {
    const HeldStick stick = read_held_stick(document_, character, *this);
    const Value* keys = character.find("head");
    std::optional<Path> head;
    if (keys) head = read_head(document_, *keys);
    return Character{model,
                     make_performance(model, stick, duration.number, head ? &*head : nullptr)};
  });
}

void Motions::check_characters() const {
  const Value* characters = document_.root.find("characters");
  if (!characters) return;
  for (const Value& character : characters->children) {
    const Value& mesh = *character.find("mesh");
    if (const Value* animation = character.find("animation")) {
      read_playback(document_, *animation, *read_figure(document_, character));
      continue;
    }
    const HeldStick stick = read_held_stick(document_, character, *this);
    if (const Value* keys = character.find("head")) read_head(document_, *keys);
    const std::shared_ptr<const Model> model = read_figure(document_, character);
    with_place(document_, mesh, [&] { check_figure(*model, stick); });
  }
}

std::shared_ptr<const Path> Motions::hand(std::size_t index) {
  const Value& value = document_.root.find("characters")->children.at(index);
  if (const Value* name = value.find("right_hand")) return path(*name);
  auto& path = hands_[index];
  if (!path) {
    const Character& found = character(index);
    const double diameter = held_diameter(find_held(document_, value), HeldStick().diameter);
    const double duration = document_.root.find("duration")->number;
    path = with_place(document_, *value.find("mesh"), [&] {
      return std::make_shared<const Path>(
          held_path(*found.performance, *found.model, diameter, duration));
    });
  }
  return path;
}

std::shared_ptr<const Path> Motions::bone(const Value& table) {
  const Value& name = *table.find("bone");
  const Value* who = table.find("character");
  if (!who) document_.fail_at_key(name, "needs character");
  const std::size_t index = character_named(*who);
  const Character& found = character(index);
  std::vector<std::string_view> names;
  for (const Bone& bone : found.model->bones) names.push_back(bone.name);
  const std::size_t bone = Names(names).index_of(document_, name, "bone");
  auto& path = bones_[{index, bone}];
  if (!path) {
    const double duration = document_.root.find("duration")->number;
    path = std::make_shared<const Path>(bone_path(*found.performance, bone, duration));
  }
  return path;
}

Attachment read_attachment(const Document& document, const Value& table, std::string_view space,
                           Motions& motions) {
  const Value* character = table.find("character");
  if (character && !table.find("bone")) document.fail_at_key(*character, "needs bone");
  Attachment to;
  if (const Value* body = table.find("body")) {
    to.kind = Attachment::Kind::body;
    to.body = motions.body(*body);
    to.point = vec3_or(table, "point", Vec3::Zero());
  } else if (const Value* path = table.find("path")) {
    to.kind = Attachment::Kind::path;
    to.path = motions.path(*path);
    to.point = vec3_or(table, "point", Vec3::Zero());
  } else if (table.find("bone")) {
    to.kind = Attachment::Kind::path;
    to.path = motions.bone(table);
    to.point = vec3_or(table, "point", Vec3::Zero());
  } else {
    to.point = table.find(space)->vec3();
  }
  return to;
}

namespace {

/// The rotation that takes the frame `before` to one whose y axis is `axis` the shortest way, so
/// that a path of directions does not spin about them.
Quat turned_to(const Quat& before, const Vec3& axis) {
  return (rotation_between(before * Vec3::UnitY(), axis) * before).normalized();
}

/// Puts a choreography's keys where they belong; the path rests before and after.
void insert(const Document& document, const Value& list, const std::vector<PathKey>& found,
            std::vector<PathKey>& keys) {
  const double from = found.front().time, until = found.back().time;
  const auto later = std::ranges::lower_bound(keys, from, {}, &PathKey::time);
  if (later == keys.begin() || (later != keys.end() && later->time <= until)) {
    document.fail_at_key(list, fmt::format("the choreography's file has the keys from {} to {} s: "
                                           "expected one key before and none there",
                                           from, until));
  }
  std::prev(later)->ease = true;
  const auto first = keys.insert(later, found.begin(), found.end());
  (first + static_cast<std::ptrdiff_t>(found.size()) - 1)->ease = true;
}

/// With the keys that a choreography has found.
Path read_keys(const Document& document, const Value& list, const std::vector<PathKey>& found) {
  std::vector<PathKey> keys;
  for (const Value& entry : list.children) {
    const Value& time = *entry.find("t");
    PathKey key{time.number, entry.find("position")->vec3(),
                keys.empty() ? Quat::Identity() : keys.back().rotation,
                flag_or(entry, "ease", false)};
    if (!keys.empty() && !(key.time > keys.back().time)) {
      document.mismatch(
          time, fmt::format("a time after {} s, where the key before it ends", keys.back().time));
    }
    if (const Value* value = entry.find("rotation")) key.rotation = rotation(document, *value);
    if (const Value* value = entry.find("axis")) {
      key.rotation = turned_to(key.rotation, direction(document, *value));
    }
    const double hold = number_or(entry, "hold", 0);
    if (hold > 0) key.ease = true;
    keys.push_back(key);
    if (hold > 0) {
      key.time += hold;
      keys.push_back(key);
    }
  }
  if (!found.empty()) insert(document, list, found, keys);
  return Path(std::move(keys));
}

Path read_circle(const Document& document, const Value& value) {
  const Circle circle{value.find("centre")->vec3(), value.find("start")->vec3(),
                      direction(document, *value.find("axis")), value.find("frequency")->number,
                      value.find("ramp")->number};
  constexpr double kOblique = 1e-9;  // of numbers that people type, as a share of the radius
  const Vec3 radius = circle.start - circle.centre;
  if (!(radius.norm() > 0) || std::abs(radius.dot(circle.axis)) > kOblique * radius.norm()) {
    document.mismatch(*value.find("start"),
                      "a point beside the centre, at right angles to the axis");
  }
  return Path::round(circle);
}

Path read_axle(const Document& document, const Value& value) {
  return Path::about({value.find("position")->vec3(), direction(document, *value.find("axis")),
                      read_number_keys(document, *value.find("keys"), "angle"),
                      number_or(value, "pitch", 0)});
}

/// A row of numbers between commas; false when a field is none.
bool split(std::string_view line, std::vector<double>& row) {
  row.clear();
  for (;;) {
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
    if (error != std::errc() || !std::isfinite(number)) return false;
    row.push_back(number);
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    if (line.empty()) return true;
    if (line.front() != ',') return false;
    line.remove_prefix(1);
  }
}

constexpr std::size_t kMaxPathBytes = 64 << 20;
constexpr std::size_t kMaxLine = 4096;  // bytes

}  // namespace

Path read_path_csv(const std::filesystem::path& file) {
  return path_from_csv(read_regular_file(file, kMaxPathBytes, "rows of t,x,y,z"), file);
}

Path path_from_csv(const std::string& text, const std::filesystem::path& file) {
  const auto fail = [&](std::size_t line, const std::string& message) {
    throw BadAsset(fmt::format("{}:{}: {}", file.string(), line, message));
  };
  std::vector<PathKey> keys;
  std::vector<double> row;
  std::size_t columns = 0, number = 1;
  for (std::size_t start = 0; start < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    std::string_view line = std::string_view(text).substr(start, end - start);
    start = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.size() > kMaxLine) {
      fail(number, fmt::format("a line of {} bytes, expected at most {}", line.size(), kMaxLine));
    }
    if (number == 1) {
      columns = line == "t,x,y,z" ? 4 : line == "t,x,y,z,qw,qx,qy,qz" ? 8 : 0;
      if (columns == 0) fail(1, "expected the columns t,x,y,z or t,x,y,z,qw,qx,qy,qz");
      continue;
    }
    if (line.empty()) continue;
    if (!split(line, row) || row.size() != columns) {
      fail(number, fmt::format("expected {} finite numbers between commas", columns));
    }
    PathKey key{row[0], {row[1], row[2], row[3]}, Quat::Identity(), false};
    if (!(std::abs(key.time) <= format_keys::kLongest)) {
      fail(number, fmt::format("found the time {}, expected one from {} to {} s", key.time,
                               -format_keys::kLongest, format_keys::kLongest));
    }
    if (columns == 8) {
      key.rotation = Quat(row[4], row[5], row[6], row[7]);
      if (!(key.rotation.norm() > 0)) fail(number, "found a quaternion of length 0");
      key.rotation.normalize();
    }
    if (!keys.empty() && !(key.time > keys.back().time)) {
      fail(number,
           fmt::format("found the time {}, expected one after {}", key.time, keys.back().time));
    }
    keys.push_back(key);
  }
  if (keys.empty()) fail(1, "has no rows, expected at least one key");
  return Path(std::move(keys));
}

namespace {

/// The keys of the file that the scene's choreography names, where it leads the path of that name;
/// else none.
std::vector<PathKey> choreographed_keys(const Document& document, std::string_view path) {
  const Value* table = document.root.find("choreography");
  if (!table || table->find("path")->text != path) return {};
  const Value& file = *table->find("file");
  const auto found = find_file(document, file);
  return with_place(document, file, [&] { return read_path_csv(found).keys(); });
}

Path read_file(const Document& document, const Value& value) {
  const auto file = find_file(document, value);
  return with_place(document, value, [&] { return read_path_csv(file); });
}

}  // namespace

std::vector<std::shared_ptr<const Path>> read_paths(const Document& document) {
  std::vector<std::shared_ptr<const Path>> paths;
  if (const Value* table = document.root.find("paths")) {
    for (const Value& entry : table->children) {
      const Value& motion = entry.children.front();
      paths.push_back(std::make_shared<const Path>(
          motion.name == "keys"
              ? read_keys(document, motion, choreographed_keys(document, entry.name))
          : motion.name == "circle" ? read_circle(document, motion)
          : motion.name == "axle"   ? read_axle(document, motion)
                                    : read_file(document, motion)));
    }
  }
  return paths;
}

std::shared_ptr<const Path> read_number_keys(const Document& document, const Value& list,
                                             std::string_view value) {
  return std::make_shared<const Path>(keyed_path(
      document, list, [&](const Value& entry) { return Vec3(entry.find(value)->number, 0, 0); }));
}

}  // namespace taut::scenes
