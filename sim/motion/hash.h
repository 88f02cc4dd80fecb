// FNV-1a, 64 bits: a fingerprint of states, inputs and files, not a defence against anyone.
#pragma once

#include <bit>
#include <concepts>
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
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ byte[i]) * kPrime;
    return *this;
  }
  Hash& text(std::string_view text) { return number(text.size()).bytes(text.data(), text.size()); }
  /// A number or another value without padding.
  template <typename T>
  Hash& number(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return bytes(&value, sizeof value);
  }
  /// All bits of a number at once, in an eighth of the time; not the hash that its bytes have.
  template <std::integral T>
  Hash& word(T value) {
    value_ = (value_ ^ static_cast<std::uint64_t>(value)) * kPrime;
    value_ ^= value_ >> 32;  // high bits of a word reach the low bits of the hash
    return *this;
  }
  Hash& word(double value) { return word(std::bit_cast<std::uint64_t>(value)); }

  std::uint64_t value() const { return value_; }

 private:
  static constexpr std::uint64_t kPrime = 1099511628211ull;
  std::uint64_t value_ = 14695981039346656037ull;
};

}  // namespace taut
