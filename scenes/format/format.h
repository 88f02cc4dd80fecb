// The format of scene files: one description, from which files are checked, misspelt keys are told,
// and the JSON Schema for editors is made.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/files/error.h"
#include "scenes/format/document.h"

namespace taut::scenes {

struct TableFormat;

/// One key of a table.
struct KeyFormat {
  enum class Type {
    flag,
    number,
    numbers,  // a list of numbers, at least `least` and at most `most`
    text,
    texts,   // a list of them
    file,    // a path, of characters that are safe in one
    choice,  // one of `choices`
    names,   // the same, or a table of texts by names that the author chooses
    points,  // a list of [x, y, z]
    table,   // of `table`
    named,   // a table of tables of `table`, by names that the author chooses
    tables,  // a list of tables of `table`
    files,   // a list of paths
    method,  // the method's name and its settings
  };

  std::string_view name;
  Type type = Type::number;
  std::string_view meaning;  // one sentence
  std::string_view unit = "";
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  bool above = false;  // the minimum itself is refused
  bool whole = false;
  bool required = false;
  std::size_t least = 0, most = std::numeric_limits<std::size_t>::max();  // elements of a list
  std::vector<std::string_view> choices = {};
  const TableFormat* table = nullptr;
  std::string_view formerly = "";  // a name that it had; files with that one are read, with a note
};

/// Keys of which a table needs exactly one (or, when not `required`, may have at most one).
struct Alternatives {
  std::vector<std::string_view> keys;
  bool required = true;
};

struct TableFormat {
  std::vector<KeyFormat> keys;
  std::vector<Alternatives> alternatives = {};

  const KeyFormat* find(std::string_view name) const;
  std::vector<std::string_view> names() const;
};

/// The whole file.
const TableFormat& scene_format();

/// The keys of [method] for each method's name, from the methods' own lists.
const std::map<std::string_view, TableFormat>& method_formats();

/// Checks names, types, ranges and what is required, everywhere in the document. After it the
/// readers of the parts need only look at what keys mean together. Throws BadScene.
void check_format(const Document& document, const TableFormat& format = scene_format());
/// The same of one of the document's tables.
void check_format(const Document& document, const Value& table, const TableFormat& format);

/// All faults of a document's format; check_format() throws the first.
FirstFaults format_faults(const Document& document);

/// True if the first word of a dotted key, as in connectors.rope.length, is of the scene format.
bool is_scene_key(std::string_view key);

/// A JSON Schema of scene files for editors (draft 7, which most support), made from the
/// description by which scenes are checked.
std::string scene_schema();

}  // namespace taut::scenes
