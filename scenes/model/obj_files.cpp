#include "scenes/model/obj_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string_view>

namespace taut::scenes {
namespace {

constexpr const char* kMaterials = "model.mtl";

/// Bytes as the importer reads a file.
class Bytes : public Assimp::IOStream {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  std::size_t Read(void* to, std::size_t size, std::size_t count) override {
    if (size == 0) return 0;
    const std::size_t whole = std::min(count, (bytes_.size() - at_) / size);
    std::memcpy(to, bytes_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  std::size_t Write(const void*, std::size_t, std::size_t) override { return 0; }
  aiReturn Seek(std::size_t offset, aiOrigin origin) override {
    const std::size_t from = origin == aiOrigin_SET   ? 0
                             : origin == aiOrigin_CUR ? at_
                                                      : bytes_.size();
    if (offset > bytes_.size() - from) return aiReturn_FAILURE;
    at_ = from + offset;
    return aiReturn_SUCCESS;
  }
  std::size_t Tell() const override { return at_; }
  std::size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace

ObjFiles::ObjFiles(const CheckedObj& model)
    : text_(fmt::format("mtllib {}\n{}", kMaterials, model.text)), materials_(model.materials) {}

const std::string* ObjFiles::bytes_of(const char* name) const {
  const std::filesystem::path file = std::filesystem::path(name).filename();
  return file == kModel ? &text_ : file == kMaterials ? &materials_ : nullptr;
}

Assimp::IOStream* ObjFiles::Open(const char* name, const char*) {
  const std::string* bytes = bytes_of(name);
  return bytes ? new Bytes(*bytes) : nullptr;
}

}  // namespace taut::scenes
