// A table of text, and the forms in which it is written.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace taut::chart {

struct Table {
  std::vector<std::string> columns;  // with units
  std::vector<std::vector<std::string>> rows;

  /// Adds a row; throws std::invalid_argument where it has not one cell per column.
  void add(std::vector<std::string> row);
};

std::string to_csv(const Table& table);
/// Columns aligned with spaces: numbers to the right, words to the left.
std::string to_text(const Table& table);
/// As to_text(), in lines of at most `width` letters where that can be: a table that is wider is
/// transposed, and where that is wider, too, it is a paragraph per row, of a line per column.
std::string to_text(const Table& table, std::size_t width);
std::string to_markdown(const Table& table);
std::string to_html(const Table& table);

/// `text` with the characters that HTML gives a meaning written out.
std::string escape_html(const std::string& text);

/// A table that to_csv() wrote. Throws std::invalid_argument where rows and header disagree.
Table from_csv(const std::string& text);

}  // namespace taut::chart
