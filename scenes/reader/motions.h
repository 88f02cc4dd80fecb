// The prescribed motions of a scene: paths, driven bodies, characters; and numbers over time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/format/document.h"
#include "scenes/reader/common.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

struct Character {
  std::shared_ptr<const Model> model;
  std::shared_ptr<const Performance> performance;
};

/// The prescribed motions of a scene: its paths, and the bones of its characters.
/// All throw BadScene.
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
  /// The path of what a character, in the order of the file, holds in its right hand.
  std::shared_ptr<const Path> hand(std::size_t index);
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
  std::map<std::size_t, std::shared_ptr<const Path>> hands_;  // of those with an animation
  std::map<std::pair<std::size_t, std::size_t>, std::shared_ptr<const Path>> bones_;
};

/// The attachment of an end or a pin: `body`, `path`, or `bone` of a `character`, with `point`;
/// or the point in space that the key `space` gives.
Attachment read_attachment(const Document& document, const Value& table, std::string_view space,
                           Motions& motions);

/// The paths of a scene, in the order of the file.
std::vector<std::shared_ptr<const Path>> read_paths(const Document& document);

/// A path from rows t,x,y,z[,qw,qx,qy,qz] of a CSV file. Throws BadAsset with file:line.
Path read_path_csv(const std::filesystem::path& file);
/// The same from the file's text.
Path path_from_csv(const std::string& text, const std::filesystem::path& file);

/// A number over time, from the values of keys: the x of a path (Hold::turn, Winch::paths).
std::shared_ptr<const Path> read_number_keys(const Document& document, const Value& list,
                                             std::string_view value);

}  // namespace taut::scenes
