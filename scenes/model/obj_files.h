// The files that an OBJ model is read from.
#pragma once

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>

#include "scenes/model/obj.h"

namespace taut::scenes {

/// Gives the importer a checked model and its materials, and no other file.
class ObjFiles : public Assimp::IOSystem {
 public:
  static constexpr const char* kModel = "model.obj";

  explicit ObjFiles(const CheckedObj& model);

  bool Exists(const char* name) const override { return bytes_of(name) != nullptr; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override;
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  const std::string* bytes_of(const char* name) const;

  std::string text_;
  const std::string& materials_;
};

}  // namespace taut::scenes
