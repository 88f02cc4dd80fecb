// Reads archives of numpy arrays, as far as they hold stored arrays of float64.
#pragma once

#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace taut {

struct NumpyArray {
  std::string shape;  // as numpy writes it: "(6, 3)"
  std::vector<double> numbers;
};

/// From the archive's list at its end, as readers of zip files do.
inline std::map<std::string, NumpyArray> read_npz(const std::string& bytes) {
  const auto number = [&]<typename T>(std::size_t at, T) {
    T value;
    if (at + sizeof value > bytes.size()) throw std::runtime_error("it ends too early");
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return std::size_t(value);
  };
  constexpr std::uint16_t k16 = 0;
  constexpr std::uint32_t k32 = 0;
  constexpr std::uint64_t k64 = 0;
  const std::size_t locator = bytes.size() - 22 - 20;
  if (number(locator, k32) != 0x07064b50) throw std::runtime_error("no locator");
  const std::size_t end = number(locator + 8, k64);
  const std::size_t files = number(end + 32, k64);
  std::size_t entry = number(end + 48, k64);
  std::map<std::string, NumpyArray> arrays;
  for (std::size_t i = 0; i < files; ++i) {
    if (number(entry, k32) != 0x02014b50) throw std::runtime_error("no entry");
    const std::size_t name_size = number(entry + 28, k16), extra_size = number(entry + 30, k16);
    const std::string name = bytes.substr(entry + 46, name_size);
    const std::size_t extra = entry + 46 + name_size;
    const std::size_t size = number(extra + 4, k64), offset = number(extra + 20, k64);
    const std::size_t data = offset + 30 + number(offset + 26, k16) + number(offset + 28, k16);
    const std::size_t header = number(data + 8, k16);
    if (bytes.compare(data, 6, "\x93NUMPY") != 0 || (header + 10) % 64 != 0) {
      throw std::runtime_error(name + ": no array");
    }
    const std::string text = bytes.substr(data + 10, header);
    const std::size_t open = text.find("'shape': ") + 9;
    NumpyArray& array = arrays[name];
    array.shape = text.substr(open, text.find(')', open) + 1 - open);
    array.numbers.resize((size - header - 10) / sizeof(double));
    std::memcpy(array.numbers.data(), bytes.data() + data + 10 + header, size - header - 10);
    entry = extra + extra_size;
  }
  return arrays;
}

}  // namespace taut
