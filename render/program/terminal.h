// The terminal that results go to: its width and its colours.
#pragma once

#include <string>

#include "render/chart/table.h"

namespace taut::program {

/// True where words on this stream (1 or 2) may be coloured: on a terminal unless NO_COLOR says
/// otherwise, and wherever CLICOLOR_FORCE does.
bool is_colored(int stream);

/// The table as standard output shows it: in lines no wider than the terminal, or than COLUMNS
/// says, the names of its columns bold where there are colours. A pipe or file gets whole lines.
std::string table_text(const chart::Table& table);

}  // namespace taut::program
