// libFuzzer's way into the model loader.
#include <cstdint>

#include "tests/fuzz/targets.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  taut::fuzz_mesh({reinterpret_cast<const char*>(data), size});
  return 0;
}
