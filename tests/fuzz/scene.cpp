// libFuzzer's way into the scene reader.
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  taut::fuzz_scene({reinterpret_cast<const char*>(data), size});
  return 0;
}
