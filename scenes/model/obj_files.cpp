#include "scenes/model/obj_files.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "scenes/files/regular_file.h"
#include "scenes/model/limits.h"

namespace taut::scenes {
namespace {

/// Bytes as the importer reads a file.
class Bytes : public Assimp::IOStream {
 public:
  explicit Bytes(std::string bytes) : bytes_(std::move(bytes)) {}

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
  std::string bytes_;
  std::size_t at_ = 0;
};

}  // namespace

bool ObjFiles::Exists(const char* name) const {
  std::error_code error;
  return name == file_.string() || std::filesystem::exists(name, error);
}

Assimp::IOStream* ObjFiles::Open(const char* name, const char*) {
  const std::filesystem::path file(name);
  if (file == file_) return new Bytes(content_);
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return nullptr;
  if (std::filesystem::weakly_canonical(file, error).parent_path() !=
      std::filesystem::weakly_canonical(file_, error).parent_path()) {
    throw bad_asset(file, "is not beside the model that names it");
  }
  return new Bytes(read_regular_file(file, model_limits::bytes, "a library of materials"));
}

}  // namespace taut::scenes
