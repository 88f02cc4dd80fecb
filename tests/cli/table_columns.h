// Columns of tables by their names.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "render/chart/table.h"

namespace taut {

inline std::size_t column(const chart::Table& table, const std::string& name) {
  return static_cast<std::size_t>(std::ranges::find(table.columns, name) - table.columns.begin());
}

inline std::vector<std::string> cells(const chart::Table& table, const std::string& name) {
  std::vector<std::string> list;
  for (const auto& row : table.rows) list.push_back(row.at(column(table, name)));
  return list;
}

}  // namespace taut
