// The prescribed motions of a scene.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/reader/common.h"

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

}  // namespace taut::scenes
