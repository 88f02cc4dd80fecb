// The parts of a scene file, one function each. They run after check_format, so that they look only
// at what keys mean together: names, files, and numbers that must fit each other.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "scenes/files/error.h"
#include "scenes/format/document.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

/// The scene that a document describes. Throws BadScene.
Scene read_scene(Document document, bool with_stage);

/// The names of all methods that have a trait, in words that end "expected one of: ".
std::string methods_with(bool MethodInfo::*trait);

/// The file that `value` names, in the first of the asset_folders() that has it. Throws BadScene
/// when the name is absolute, or the file missing or outside of the folder.
std::filesystem::path find_file(const Document& document, const Value& value);

/// Does what needs the asset that `value` names. A BadAsset becomes a BadScene that names the
/// scene's place too.
auto with_place(const Document& document, const Value& value, auto&& use) {
  try {
    return use();
  } catch (const BadAsset& error) {
    document.fail(value, error.what());
  }
}

/// How far places that should be one may be apart, as a share of a connector's length: the rounding
/// of numbers that people type.
inline constexpr double kRounding = 1e-6;

// Members that may be left out.
double number_or(const Value& table, std::string_view key, double fallback);
Vec3 vec3_or(const Value& table, std::string_view key, const Vec3& fallback);
bool flag_or(const Value& table, std::string_view key, bool fallback);
std::string_view text_or(const Value& table, std::string_view key, std::string_view fallback);

/// A direction of any length but zero, as a unit vector.
Vec3 direction(const Document& document, const Value& value);
/// A quaternion [w, x, y, z] of any length but zero, as a rotation.
Quat rotation(const Document& document, const Value& value);

/// Names that values may say, found without a look at each.
class Names {
 public:
  explicit Names(std::vector<std::string_view> names);
  /// Of the members of a table of tables, in the order of the file; none for null.
  explicit Names(const Value* table);

  /// The index of the name that `value` says; `what` as in "body". Throws BadScene.
  std::size_t index_of(const Document& document, const Value& value, std::string_view what) const;
  std::size_t size() const { return names_.size(); }

 private:
  std::vector<std::string_view> names_;
  std::unordered_map<std::string_view, std::size_t> indices_;
};

/// In the order of the file.
std::vector<std::shared_ptr<const Path>> read_paths(const Document& document);

struct Character {
  std::shared_ptr<const Model> model;
  std::shared_ptr<const Performance> performance;
};

/// The prescribed motions of a scene: its paths, and the bones of its characters. All throw
/// BadScene.
class Motions {
 public:
  explicit Motions(const Document& document);

  /// The index of the body, or of the character, of that name.
  std::size_t body(const Value& name) const;
  std::size_t character_named(const Value& name) const;
  /// The path of that name, and as the file describes it.
  std::shared_ptr<const Path> path(const Value& name) const;
  const Value& path_value(const Value& name) const;
  /// The path of the bone that a table's `character` and `bone` name.
  std::shared_ptr<const Path> bone(const Value& table);
  /// A character, in the order of the file: read and acted out when it is first asked for.
  const Character& character(std::size_t index);
  std::size_t characters() const { return character_names_.size(); }
  /// Checks the characters before they act.
  void check_characters() const;

 private:
  Character act(const Value& character) const;

  const Document& document_;
  std::vector<std::shared_ptr<const Path>> paths_;  // as they follow each other in the file
  Names path_names_, body_names_, character_names_;
  std::map<std::size_t, Character> characters_;
  std::map<std::pair<std::size_t, std::size_t>, std::shared_ptr<const Path>> bones_;
};

/// A path from rows t,x,y,z[,qw,qx,qy,qz] of a CSV file. Throws BadAsset with file:line.
Path read_path_csv(const std::filesystem::path& file);
/// The same from the file's text.
Path path_from_csv(const std::string& text, const std::filesystem::path& file);

/// The method that a table names, with its settings; the default method for null.
MethodChoice read_method(const Document& document, const Value* table, int fps);

/// Fails where a connector that is curved at rest may leave the plane across that.
void check_curvatures(const Document& document, const World& world, const Timeline& timeline);

/// Bodies with their masses; those that hang have no place yet.
std::vector<Body> read_bodies(const Document& document, Motions& motions);
/// Connectors with their shapes; places the bodies that hang.
void read_connectors(const Document& document, Motions& motions, World& world);
/// Nets, whose cords become connectors behind all others.
void read_nets(const Document& document, World& world);
/// How many connectors a net is.
std::size_t cord_count(const Value& net);
/// The mass (kg) that a connector of this length has by its mass or its material.
double mass_of(const Value& connector, double length);
/// The sections of the connector's links, and the air's drag on them; changes its masses where they
/// follow the links.
void read_sections(const Document& document, const Value& value, Connector& connector);
/// A number over time, from the values of keys: the x of a path (Hold::turn, Winch::paths).
std::shared_ptr<const Path> read_number_keys(const Document& document, const Value& list,
                                             std::string_view value);
/// The same of lengths (m), which start with zero.
std::shared_ptr<const Path> read_length_keys(const Document& document, const Value& list,
                                             std::string_view key);
/// Fails at `key` where winches whose lengths are all known take in more than the links have.
void check_least(const Document& document, const Value& key, const Winch& winch);
/// The paths of the winches at the first end of `first` and the last of `last`, once those have
/// their holds; null where there is none.
std::array<std::shared_ptr<const Path>, 2> read_winches(const Document& document,
                                                        const Value& value, const World& world,
                                                        const Connector& first,
                                                        const Connector& last);
/// The winches at a connector's ends, once it has its holds. Throws BadScene.
void read_winches(const Document& document, const Value& value, const World& world,
                  Connector& connector);
/// Fails where a winch or pulley stands in a scene with what does not go with one, or a method
/// without.
void refuse_winches(const Document& document, const MethodInfo& method);
/// The air of a scene.
Air read_air(const Document& document);
/// Obstacles, behind bodies and connectors. Moving ones that are shown come with a driven body, by
/// which they are seen.
void read_obstacles(const Document& document, Motions& motions, World& world);
/// A single obstacle.
Obstacle read_obstacle(const Document& document, const Value& value, Motions& motions,
                       const World& world);
/// Moves beads that would start inside of obstacles to their surfaces, of connectors that ask for
/// it and the way that they say; links keep their lengths.
void push_out_starts(const Document& document, World& world);
/// Whether pictures show it.
bool shows_obstacle(const Value& value);
/// Fails where a bead or body starts inside an obstacle; of a world that is finished.
void check_obstacles(const Document& document, const World& world);
/// Friction and restitution of an obstacle or of bodies that touch each other.
void read_friction(const Document& document, const Value& value, double& static_friction,
                   double& kinetic_friction, double& restitution);
/// Pairs of free bodies that touch each other.
void read_touching(const Document& document, World& world);
/// Whether these start apart; of a world that is finished.
void check_touching(const Document& document, const World& world);
/// Pins and cuts, of a world that is finished.
Timeline read_timeline(const Document& document, Motions& motions, const World& world,
                       double duration);

/// The attachment of an end or a pin: `body`, `path`, or `bone` of a `character`, with `point`; or
/// the point in space that the key `space` gives.
Attachment read_attachment(const Document& document, const Value& table, std::string_view space,
                           Motions& motions);

/// A plan made earlier, whether or not the scene is still the one that it was made for. Checks its
/// format, too. Throws BadScene.
Plan read_plan(const Document& document, const Value& table, int fps);

/// Reads the models too, and works out what the characters do.
void read_stage(const Document& document, Motions& motions, Scene& scene);
/// Reads the models of a scene without a stage, only to say what is wrong with them.
void check_models(const Document& document);

/// Particles a link apart along straight pieces through `corners`, from the first on. Fewer than
/// `particles` when the line is too short.
std::vector<Vec3> along_line(const std::vector<Vec3>& corners, std::size_t particles, double link);

/// As many places along all of it, equally far from each other on it.
std::vector<Vec3> evenly_along(const std::vector<Vec3>& corners, std::size_t particles);

/// A regular polygon across `axis` whose sides are the links of a connector; from `first` on, or
/// from anywhere.
std::vector<Vec3> polygon(const Vec3& axis, const Vec3& centre, const Connector& connector,
                          const std::optional<Vec3>& first);

/// How a rope lies on a round obstacle.
struct Winding {
  double turns = 0.5;            // about the obstacle's y axis, right-handed
  double before = 0, after = 0;  // m, of the straight pieces on either side
};

/// Corners of the line of beads of `radius` (m): straight up to a round obstacle, about it, and
/// straight on. Turns lie side by side, in the middle of the obstacle.
std::vector<Vec3> wound_line(const Obstacle& around, double radius, const Vec3& gravity,
                             const Winding& winding);

}  // namespace taut::scenes
