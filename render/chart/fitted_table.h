// Tables for terminals.
#pragma once

#include "render/chart/table.h"

namespace taut::chart {

/// As to_text(), in lines of at most `width` letters where that can be: a table that is wider is
/// transposed, and where that is wider, too, it is a paragraph per row, of a line per column.
std::string to_text(const Table& table, std::size_t width);

}  // namespace taut::chart
