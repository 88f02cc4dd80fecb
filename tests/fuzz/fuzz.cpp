// libFuzzer's way into a reader, which TAUT_READER in the environment names.
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/readers.h"

namespace {

const taut::Reader* chosen = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const char* name = std::getenv("TAUT_READER");
  chosen = name ? taut::find_reader(name) : nullptr;
  if (chosen) return 0;
  std::fputs("expected TAUT_READER to be one of:", stderr);
  for (const taut::Reader& reader : taut::readers()) std::fprintf(stderr, " %s", reader.name);
  std::fputs("\n", stderr);
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  chosen->read({reinterpret_cast<const char*>(data), size});
  return 0;
}
