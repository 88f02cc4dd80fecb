// Any bytes as a scene: it is read or refused with a message, nothing else.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "scenes/error.h"
#include "scenes/reader/document.h"
#include "scenes/reader/reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    taut::read_scene(taut::parse_document("fuzz.toml", text), false);
  } catch (const taut::BadScene&) {
  }
  return 0;
}
