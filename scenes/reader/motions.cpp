#include "scenes/reader/motions.h"

#include <fmt/format.h>

#include "scenes/character/animated.h"
#include "scenes/character/bone_names.h"
#include "scenes/character/character.h"
#include "scenes/model/load_model.h"
#include "scenes/reader/paths.h"

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

/// How the head turns, as make_performance() wants it.
Path read_head(const Document& document, const Value& list) {
  std::vector<PathKey> keys;
  for (const Value& entry : list.children) {
    const Value& time = *entry.find("t");
    if (!keys.empty() && !(time.number > keys.back().time)) {
      document.mismatch(
          time, fmt::format("a time after {} s, that of the key before it", keys.back().time));
    }
    const Vec3 angles(number_or(entry, "yaw", 0), number_or(entry, "lean", 0),
                      number_or(entry, "tilt", 0));
    keys.push_back({time.number, angles, Quat::Identity(), flag_or(entry, "ease", false)});
  }
  return Path(std::move(keys));
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

}  // namespace taut::scenes
