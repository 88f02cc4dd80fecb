// Numbers as bytes, the lowest first.
#pragma once

#include <bit>
#include <cstring>
#include <span>
#include <string>
#include <string_view>

namespace taut::exporting {

static_assert(std::endian::native == std::endian::little, "written as they are in memory");

template <typename... Numbers>
std::string little_endian(Numbers... numbers) {
  std::string bytes;
  const auto add = [&bytes](auto number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  (add(numbers), ...);
  return bytes;
}

template <typename Number>
std::string_view bytes_of(std::span<const Number> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

}  // namespace taut::exporting
