// FNV-1a, 64 bits: a fingerprint of states, inputs and files, not a defence against anyone.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace taut {

class Hash {
 public:
  Hash& bytes(const void* data, std::size_t size) {
    const auto* byte = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ byte[i]) * 1099511628211ull;
    return *this;
  }
  Hash& text(std::string_view text) { return number(text.size()).bytes(text.data(), text.size()); }
  /// A number or another value without padding.
  template <typename T>
  Hash& number(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return bytes(&value, sizeof value);
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

}  // namespace taut
