// The fuzzers' corpus again, and mutations of it: nothing but the errors that are meant.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <random>
#include <vector>

#include "tests/fuzz/targets.h"
#include "tests/support/folder.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_in(const fs::path& folder, std::string_view extension = "") {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && (extension.empty() || entry.path().extension() == extension))
      files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<std::string> contents;
  for (const fs::path& file : files) contents.push_back(read_file(file));
  return contents;
}

/// A few bytes changed, a piece cut out, doubled, or put in from another input.
std::string mutated(std::string bytes, const std::vector<std::string>& others,
                    std::mt19937& chance) {
  const auto below = [&](std::size_t n) { return n ? chance() % n : 0; };
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    const std::size_t at = below(bytes.size()),
                      length = below(std::min<std::size_t>(bytes.size() - at + 1, 40));
    switch (below(5)) {
      case 0:
        if (!bytes.empty()) bytes[at] = static_cast<char>(chance());
        break;
      case 1:
        bytes.erase(at, length);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 3: {
        const std::string& other = others[below(others.size())];
        bytes.insert(at, other.substr(below(other.size()), below(60)));
        break;
      }
      case 4: {
        constexpr const char* kNumbers[] = {
            "0", "-1", "nan", "inf", "1e308", "-1e-308", "4294967296", "9223372036854775807"};
        bytes.replace(at, length, kNumbers[below(std::size(kNumbers))]);
        break;
      }
    }
  }
  return bytes;
}

void run(const std::function<void(std::string_view)>& target,
         const std::vector<std::string>& inputs, int mutations) {
  ASSERT_FALSE(inputs.empty());
  for (const std::string& input : inputs) target(input);
  std::mt19937 chance(1);
  for (int i = 0; i < mutations; ++i)
    target(mutated(inputs[chance() % inputs.size()], inputs, chance));
}

std::vector<std::string> scenes() {
  std::vector<std::string> inputs = files_in(TAUT_SOURCE_DIR "/scenes", ".toml");
  std::ranges::copy(files_in(TAUT_SOURCE_DIR "/tests/fuzz/corpus/scene"),
                    std::back_inserter(inputs));
  return inputs;
}

std::vector<std::string> meshes() {
  return files_in(TAUT_SOURCE_DIR "/tests/fuzz/corpus/mesh");
}

TEST(Fuzz, Scenes) {
  run(fuzz_scene, scenes(), 10'000);
}
TEST(Fuzz, Meshes) {
  run(fuzz_mesh, meshes(), 10'000);
}
TEST(LongFuzz, Scenes) {
  run(fuzz_scene, scenes(), 1'000'000);
}
TEST(LongFuzz, Meshes) {
  run(fuzz_mesh, meshes(), 1'000'000);
}

}  // namespace
}  // namespace taut
