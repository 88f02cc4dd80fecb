// The targets of fuzzing: bytes in, nothing out; only the errors that are meant may be thrown.
#pragma once

#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace taut {

/// A reader of foreign input, in this process and, where it can, from memory.
struct Reader {
  const char* name;
  void (*read)(std::string_view bytes);
};

/// Names it in messages of the tests.
inline void PrintTo(const Reader& reader, std::ostream* out) {
  *out << reader.name;
}

/// States that the reader of that name takes: what it reads is of one scene.
std::vector<std::string> saved_states();

/// All readers of the program.
std::span<const Reader> readers();

/// The reader of that name, or null.
const Reader* find_reader(std::string_view name);

}  // namespace taut
