#include "render/chart/table.h"

#include <algorithm>
#include <charconv>
#include <stdexcept>

#include "sim/motion/printable.h"

namespace taut::chart {
namespace {

std::string csv_cell(const std::string& cell) {
  if (cell.find_first_of(",\"\n\r") == std::string::npos) return cell;
  std::string out = "\"";
  for (const char c : cell) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

// Letters of UTF-8 text.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (c & 0xc0) != 0x80; }));
}

bool is_number(const std::string& cell) {
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && (*end == '\0' || *end == ' ' || *end == '%');
}

/// True where the column holds numbers, and else only dashes or nothing.
bool numeric(const Table& table, std::size_t column) {
  bool any = false;
  for (const auto& row : table.rows) {
    const std::string& cell = row[column];
    if (is_number(cell)) {
      any = true;
    } else if (!cell.empty() && cell != "-") {
      return false;
    }
  }
  return any;
}

template <class Cell>
std::string line(const std::vector<std::string>& cells, const char* open, const char* between,
                 const char* close, Cell&& cell) {
  std::string out = open;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i) out += between;
    out += cell(i);
  }
  return out + close;
}

}  // namespace

void Table::add(std::vector<std::string> row) {
  if (row.size() != columns.size()) throw std::invalid_argument("a row does not fit its table");
  rows.push_back(std::move(row));
}

std::string to_csv(const Table& table) {
  const auto write = [](const std::vector<std::string>& row) {
    return line(row, "", ",", "\n", [&](std::size_t i) { return csv_cell(row[i]); });
  };
  std::string out = write(table.columns);
  for (const auto& row : table.rows) out += write(row);
  return out;
}

std::string to_text(const Table& any) {
  Table table = any;
  for (std::string& name : table.columns) name = printable(name);
  for (auto& row : table.rows)
    for (std::string& cell : row) cell = printable(cell);
  std::vector<std::size_t> widths(table.columns.size());
  std::vector<bool> right(table.columns.size());
  for (std::size_t i = 0; i < widths.size(); ++i) {
    widths[i] = width(table.columns[i]);
    right[i] = numeric(table, i);
    for (const auto& row : table.rows) widths[i] = std::max(widths[i], width(row[i]));
  }
  const auto write = [&](const std::vector<std::string>& row) {
    std::string out = line(row, "", "  ", "", [&](std::size_t i) {
      const std::string pad(widths[i] - width(row[i]), ' ');
      return right[i] ? pad + row[i] : row[i] + pad;
    });
    while (!out.empty() && out.back() == ' ') out.pop_back();
    return out + "\n";
  };
  std::string out = write(table.columns);
  for (const auto& row : table.rows) out += write(row);
  return out;
}

namespace {

std::size_t widest_line(const std::string& text) {
  std::size_t widest = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    widest = std::max(widest, width(text.substr(begin, end - begin)));
    begin = end + 1;
  }
  return widest;
}

Table transposed(const Table& table) {
  Table result{{table.columns.front()}, {}};
  for (const auto& row : table.rows) result.columns.push_back(row.front());
  for (std::size_t c = 1; c < table.columns.size(); ++c) {
    std::vector<std::string> cells{table.columns[c]};
    for (const auto& row : table.rows) cells.push_back(row[c]);
    result.add(std::move(cells));
  }
  return result;
}

std::string paragraphs(const Table& table) {
  std::string text;
  for (const auto& row : table.rows) {
    Table one{{table.columns.front(), row.front()}, {}};
    for (std::size_t c = 1; c < row.size(); ++c) one.add({table.columns[c], row[c]});
    if (!text.empty()) text += '\n';
    text += to_text(one);
  }
  return text;
}

}  // namespace

std::string to_text(const Table& table, std::size_t most) {
  std::string text = to_text(table);
  if (widest_line(text) <= most || table.columns.size() < 2) return text;
  text = to_text(transposed(table));
  return widest_line(text) <= most ? text : paragraphs(table);
}

std::string to_markdown(const Table& table) {
  const auto write = [](const std::vector<std::string>& row) {
    return line(row, "| ", " | ", " |\n", [&](std::size_t i) {
      std::string out;
      for (const char c : row[i]) out += c == '|' ? std::string("\\|") : std::string(1, c);
      return out;
    });
  };
  std::string out = write(table.columns);
  out += line(table.columns, "|", "|", "|\n",
              [&](std::size_t i) { return std::string(numeric(table, i) ? "---:" : "---"); });
  for (const auto& row : table.rows) out += write(row);
  return out;
}

std::string escape_html(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string to_html(const Table& table) {
  const auto write = [&](const std::vector<std::string>& row, const std::string& tag) {
    return line(row, "<tr>", "", "</tr>\n", [&](std::size_t i) {
      const char* side = numeric(table, i) ? " class=\"number\"" : "";
      return "<" + tag + side + ">" + escape_html(row[i]) + "</" + tag + ">";
    });
  };
  std::string out = "<table>\n" + write(table.columns, "th");
  for (const auto& row : table.rows) out += write(row, "td");
  return out + "</table>\n";
}

Table from_csv(const std::string& text) {
  std::vector<std::vector<std::string>> lines;
  std::vector<std::string> row;
  std::string cell;
  bool in_quotes = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_quotes) {
      if (c != '"') {
        cell += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        cell += c;
        ++i;
      } else {
        in_quotes = false;
      }
    } else if (c == '"') {
      in_quotes = true;
    } else if (c == ',' || c == '\n') {
      row.push_back(std::move(cell));
      cell.clear();
      if (c == '\n') lines.push_back(std::move(row)), row.clear();
    } else {
      cell += c;
    }
  }
  if (in_quotes || !cell.empty() || !row.empty()) {
    throw std::invalid_argument("the table's last line is incomplete");
  }
  Table table;
  if (lines.empty()) throw std::invalid_argument("the table is empty");
  table.columns = std::move(lines.front());
  for (std::size_t i = 1; i < lines.size(); ++i) table.add(std::move(lines[i]));
  return table;
}

}  // namespace taut::chart
