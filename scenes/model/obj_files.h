// The files that an OBJ model is read from.
#pragma once

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <filesystem>
#include <string>

namespace taut::scenes {

/// Gives the importer the model as it was checked, and the material libraries that it names: only
/// regular files of its own folder. Open() throws BadAsset for others.
class ObjFiles : public Assimp::IOSystem {
 public:
  ObjFiles(const std::filesystem::path& file, const std::string& content)
      : file_(file), content_(content) {}

  bool Exists(const char* name) const override;
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override;
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::filesystem::path& file_;
  const std::string& content_;
};

}  // namespace taut::scenes
