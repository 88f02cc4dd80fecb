// The targets of fuzzing: bytes in, nothing out; only the errors that are meant may be thrown.
#pragma once

#include <string>
#include <string_view>

#include "scenes/files/error.h"
#include "scenes/format/document.h"
#include "scenes/model/import.h"
#include "scenes/reader/reader.h"

namespace taut {

/// As a scene file without a stage.
inline void fuzz_scene(std::string_view bytes) {
  try {
    scenes::read_scene(scenes::parse_document("fuzz.toml", bytes), false);
  } catch (const scenes::BadScene&) {
  }
}

/// As a model, read in this process, so that a fault of the importer's is seen where it happens.
inline void fuzz_model(const char* name, std::string_view bytes) {
  try {
    scenes::NamedFiles none;
    scenes::import_model(name, std::string(bytes), none);
  } catch (const scenes::BadAsset&) {
  }
}

/// The same; the first byte chooses the format.
inline void fuzz_mesh(std::string_view bytes) {
  if (bytes.empty()) return;
  constexpr const char* kFormats[] = {"fuzz.glb", "fuzz.gltf", "fuzz.obj"};
  fuzz_model(kFormats[static_cast<unsigned char>(bytes[0]) % 3], bytes.substr(1));
}

/// As a path's CSV file.
inline void fuzz_path(std::string_view bytes) {
  try {
    scenes::path_from_csv(std::string(bytes), "fuzz.csv");
  } catch (const scenes::BadAsset&) {
  }
}

}  // namespace taut
