// A TOML file as a tree of plain values that know where they stand. The only place that knows the
// TOML library.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sim/motion/types.h"

namespace taut::scenes {

/// Line and column in the file, from 1; columns count characters.
struct SourcePosition {
  int line = 1, column = 1;
};

struct Value {
  enum class Kind { flag, whole, number, text, date, list, table };

  std::string name;          // its key, or [2] in a list
  std::string path;          // from the root: connectors.chain.start.points[2]
  SourcePosition key_place;  // of its key (in a list: of the value)
  SourcePosition place;      // of the value
  int last_line = 1;         // of the value, or of a table's heading
  Kind kind = Kind::table;
  bool flag = false;
  double number = 0;  // whole numbers too
  std::string text = {};
  std::vector<Value> children = {};  // members or elements, in the order of the file
  bool inherited = false;            // stands in the file that the document's extends

  /// The member of that name, or null.
  const Value* find(std::string_view member) const;
  bool is_number() const { return kind == Kind::number || kind == Kind::whole; }
  /// The first three elements of a list of numbers.
  Vec3 vec3() const { return {children[0].number, children[1].number, children[2].number}; }
};

/// A value as a message shows it: short, strings in quotes.
std::string shown(const Value& value);

/// The word of `known` that is nearest to `word` in spelling, as `, did you mean "x"?`; empty when
/// none is near.
std::string suggestion(std::string_view word, const std::vector<std::string_view>& known);

struct Document {
  std::filesystem::path file;
  Value root;
  std::filesystem::path base = {};  // the file that this one extends; empty: none

  /// Throws BadScene: file:line:column: KEY: `message`.
  [[noreturn]] void fail(const Value& value, const std::string& message) const;
  /// The same, pointing at the value's key.
  [[noreturn]] void fail_at_key(const Value& value, const std::string& message) const;
  /// Throws BadScene: file:line:column: KEY: found VALUE, expected `expected`.
  [[noreturn]] void mismatch(const Value& value, const std::string& expected) const;
};

/// Reads a file of at most 16 MiB of UTF-8. Where it `extends` another beside it, what that one has
/// at the top and this one has not stands here too, but for a plan. Throws BadScene when a file is
/// missing, no regular file, unreadable, too large, not UTF-8 or not TOML.
Document read_document(const std::filesystem::path& file);

/// The same of text that is already here; `file` is what messages call it.
Document parse_document(const std::filesystem::path& file, std::string_view text);

/// Throws BadScene: file:line:column: KEY: `message`, of the last of these keys that is there, each
/// a member of the one before it.
[[noreturn]] void fail_at(const std::filesystem::path& file, const std::vector<std::string>& keys,
                          const std::string& message);

/// Puts `text`, a value as TOML writes it, at the dotted `path` of the document, in place of what
/// stands there. Throws BadScene where the path leads through something that is no table, or the
/// text is no value.
void change(Document& document, std::string_view path, const std::string& text);

}  // namespace taut::scenes
