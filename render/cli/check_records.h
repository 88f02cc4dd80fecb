// What a copy of this process tells the one that waits: records, so that what is said when the copy
// is stopped may be cut off anywhere.
#pragma once

#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "render/base/bounded.h"

namespace taut::cli {

/// Bytes that a copy may have beyond what the process has.
inline constexpr std::size_t kCopyMemory = 3e9;

enum class Said : char { mark = 'm', again = 'a', state = 's', diverged = 'd' };

inline void tell(const render::Say& say, Said what, std::string_view bytes) {
  const std::size_t size = bytes.size();
  std::string record(1, static_cast<char>(what));
  record.append(reinterpret_cast<const char*>(&size), sizeof size);
  record.append(bytes);
  say(record);
}

inline void tell(const render::Say& say, Said what, std::initializer_list<double> numbers) {
  tell(say, what,
       {reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(double)});
}

/// Calls visit(what, bytes) for every record that is whole.
template <typename Visit>
void each_record(std::string_view said, Visit visit) {
  constexpr std::size_t kHead = 1 + sizeof(std::size_t);
  while (said.size() >= kHead) {
    std::size_t size = 0;
    std::memcpy(&size, said.data() + 1, sizeof size);
    if (said.size() - kHead < size) return;
    visit(Said{said[0]}, said.substr(kHead, size));
    said.remove_prefix(kHead + size);
  }
}

inline std::vector<double> numbers_of(std::string_view bytes) {
  std::vector<double> numbers(bytes.size() / sizeof(double));
  std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(double));
  return numbers;
}

}  // namespace taut::cli
