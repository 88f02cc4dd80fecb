// The library as others see it once it is installed.
#include <algorithm>
#include <sstream>

#include "tests/package/prefix.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  EXPECT_FALSE(files.empty()) << folder;
  return files;
}

TEST(InstalledLibrary, ShowsItsOwnNamesAlone) {
  const fs::path library = library_folder() / "libtaut_sim.so.0";
  ASSERT_TRUE(fs::exists(library));
  const auto names = must_run({"nm", "-DC", "--defined-only", library.string()}, prefix());
  std::istringstream lines(names.output);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    const std::string name = line.substr(line.find(' ') + 3);
    const bool own = name.find("taut::") < name.find_first_of("(<") || name == "TAUT_0@@TAUT_0" ||
                     name == "TAUT_0";
    EXPECT_TRUE(own) << line;
    const bool cloned = line.find(" i ") < line.find(name) || name.find("[clone") < name.size();
    for (const char* inside : {"methods", "direct"}) {
      const bool shown = name.find("taut::" + std::string(inside) + "::") < name.size();
      EXPECT_TRUE(cloned || !shown) << line;
    }
  }
  EXPECT_GT(count, 100);
}

TEST(InstalledLibrary, NeedsNoOtherThanTheRuntime) {
  const auto dynamic =
      must_run({"objdump", "-p", (library_folder() / "libtaut_sim.so").string()}, prefix());
  EXPECT_NE(dynamic.output.find("SONAME               libtaut_sim.so.0\n"), std::string::npos);
  std::istringstream lines(dynamic.output);
  for (std::string line; std::getline(lines, line);) {
    if (line.find("NEEDED") == std::string::npos) continue;
    const std::string name = line.substr(line.rfind(' ') + 1);
    const bool runtime = name.starts_with("libstdc++.") || name.starts_with("libm.") ||
                         name.starts_with("libgcc_s.") || name.starts_with("libc.");
    EXPECT_TRUE(runtime || name.starts_with("ld-")) << name;
  }
}

TEST(InstalledLibrary, HeadersIncludeWhatIsThere) {
  for (const fs::path& file : files_below(prefix() / "include/taut")) {
    std::istringstream lines(read_file(file));
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("#include \"")) continue;
      const std::string name = line.substr(10, line.rfind('"') - 10);
      EXPECT_TRUE(fs::exists(prefix() / "include" / name)) << file << ": " << line;
      EXPECT_TRUE(name.starts_with("taut/")) << file << ": " << line;
    }
  }
}

TEST(InstalledLibrary, PassesOnNoFlagsAndNoPlaces) {
  for (const fs::path& file : files_below(library_folder() / "cmake/taut")) {
    const std::string text = read_file(file);
    for (const char* word : {"-Wall", "-Werror", "-Wconversion", "taut_flags", TAUT_SOURCE_DIR}) {
      EXPECT_EQ(text.find(word), std::string::npos) << file << ": " << word;
    }
  }
}

TEST(InstalledLibrary, ExamplesAreShort) {
  for (const char* name : {"swing", "pin_and_release", "ten_thousand_ropes", "own_method"}) {
    const std::string text = read_file(fs::path(TAUT_SOURCE_DIR "/sim/examples") / name += ".cpp");
    EXPECT_GT(std::ranges::count(text, '\n'), 10) << name;
    EXPECT_LE(std::ranges::count(text, '\n'), 40) << name;
  }
}

class Examples : public testing::Test {
 protected:
  Folder folder_;

  std::string run(const fs::path& program) {
    return must_run({"env", "LD_LIBRARY_PATH=" + library_folder().string(), program.string()},
                    folder_.path())
        .output;
  }

  void expect_swing(const fs::path& programs) {
    const std::string swing = run(programs / "swing");
    EXPECT_TRUE(swing.starts_with("t,x,y,z\n0.0000,1.000000,0.000000,0.000000\n")) << swing;
    EXPECT_EQ(std::ranges::count(swing, '\n'), 62);
  }

  void expect_results(const fs::path& programs) {
    expect_swing(programs);
    EXPECT_NE(run(programs / "pin_and_release").find("released       t = 0.90 s"),
              std::string::npos);
    EXPECT_TRUE(run(programs / "ten_thousand_ropes").starts_with("10000 ropes, 1.0 s"));
    const std::string compared = run(programs / "own_method");
    std::istringstream lines(compared);
    std::string method, word;
    double error[3];
    for (double& e : error) {
      lines >> method >> word >> e;
      lines.ignore(1000, '\n');
    }
    EXPECT_LT(error[2], 1e-3) << compared;      // direct
    EXPECT_GT(error[0], error[2]) << compared;  // one's own
  }
};

TEST_F(Examples, AreBuiltByFindPackage) {
  const std::string build = (folder_.path() / "build").string();
  must_run({"cmake", "-S", TAUT_SOURCE_DIR "/sim/examples", "-B", build, "-G", "Ninja",
            "-DCMAKE_PREFIX_PATH=" + prefix().string(), "-DCMAKE_CXX_FLAGS=-Wall -Werror"},
           folder_.path());
  must_run({"cmake", "--build", build, "--parallel", "2"}, folder_.path());
  expect_results(build);
}

TEST_F(Examples, AreBuiltByPkgConfig) {
  const std::string flags = "PKG_CONFIG_PATH=" + (library_folder() / "pkgconfig").string();
  must_run({"sh", "-c",
            "export " + flags +
                R"sh(
g++ $(pkg-config --cflags taut) )sh" TAUT_SOURCE_DIR
                R"sh(/sim/examples/swing.cpp -o swing $(pkg-config --libs taut))sh"},
           folder_.path());
  expect_swing(folder_.path());
}

TEST(InstalledLibrary, RoomsAreFoundWithWhatTheyNeed) {
  Folder folder;
  folder.write("CMakeLists.txt", R"cmake(cmake_minimum_required(VERSION 3.25)
project(rooms LANGUAGES CXX)
find_package(taut 0.1 REQUIRED COMPONENTS scenes render)
add_executable(rooms rooms.cpp)
target_link_libraries(rooms PRIVATE taut::render)
)cmake");
  folder.write("rooms.cpp", R"cpp(#include <taut/render/picture/picture.h>
#include <taut/scenes/load/load_scene.h>
                                  int main() {
                                    return taut::find_method("multibody") && taut::scenes::frame_count(1, 60) == 60 ? 0 : 1;
                                  }
  )cpp");
  const std::string build = (folder.path() / "build").string();
  must_run({"cmake", "-S", folder.path().string(), "-B", build, "-G", "Ninja",
            "-DCMAKE_PREFIX_PATH=" + prefix().string()},
           folder.path());
  must_run({"cmake", "--build", build}, folder.path());
  must_run({build + "/rooms"}, folder.path());
}

}  // namespace
}  // namespace taut
