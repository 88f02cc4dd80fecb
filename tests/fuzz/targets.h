// What is fuzzed: bytes in, nothing out; only the errors that are meant may be thrown.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "scenes/error.h"
#include "scenes/model/model.h"
#include "scenes/reader/document.h"
#include "scenes/reader/reader.h"

namespace taut {

/// As a scene file without a stage.
inline void fuzz_scene(std::string_view bytes) {
  try {
    read_scene(parse_document("fuzz.toml", bytes), false);
  } catch (const BadScene&) {
  }
}

/// As a model; the first byte chooses the format. The importer takes files, so it goes through one,
/// in memory where the system has such a place.
inline void fuzz_mesh(std::string_view bytes) {
  static const std::filesystem::path folder = std::filesystem::exists("/dev/shm")
                                                  ? std::filesystem::path("/dev/shm")
                                                  : std::filesystem::temp_directory_path();
  static const std::string stem = folder / ("taut_fuzz_" + std::to_string(getpid()));
  if (bytes.empty()) return;
  constexpr const char* kFormats[] = {".glb", ".gltf", ".obj"};
  const std::string file = stem + kFormats[static_cast<unsigned char>(bytes[0]) % 3];
  std::ofstream(file, std::ios::binary) << bytes.substr(1);
  try {
    load_model(file);
  } catch (const BadAsset&) {
  }
  std::filesystem::remove(file);
}

}  // namespace taut
