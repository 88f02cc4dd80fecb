// Debian packages, where dpkg is; with lintian, what that says of them.
#include <map>

#include "tests/package/prefix.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

bool is_installed(const char* program) {
  return Child({"sh", "-c", std::string("command -v ") + program}, "/").wait().code == 0;
}

std::string listing(const fs::path& package) {
  return must_run({"dpkg-deb", "--contents", package.string()}, package.parent_path()).output;
}

TEST(DebianPackages, HoldWhatTheirNamesSayAndSatisfyLintian) {
  if (!is_installed("dpkg-deb")) GTEST_SKIP() << "dpkg is not installed";
  Folder folder;
  std::vector<std::string> cpack{"cpack", "--config", TAUT_BUILD_DIR "/CPackConfig.cmake", "-B",
                                 folder.path().string()};
  const bool whole = is_installed("dpkg-shlibdeps") && is_installed("lintian");
  if (!whole) {  // what the files are linked with is not looked up, and packing is quick
    cpack.insert(cpack.end(), {"-D", "CPACK_DEBIAN_PACKAGE_SHLIBDEPS=OFF", "-D",
                               "CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS=OFF", "-D",
                               "CPACK_DEBIAN_COMPRESSION_TYPE=gzip"});
  }
  must_run(cpack, folder.path());
  std::vector<std::string> lintian{"lintian", "--fail-on", "error,warning"};
  std::map<std::string, fs::path> packages;
  for (const auto& entry : fs::directory_iterator(folder.path())) {
    if (entry.path().extension() != ".deb") continue;
    const std::string name = entry.path().filename().string();
    packages[name.substr(0, name.find('_'))] = entry.path();
    lintian.push_back(entry.path().string());
  }
#ifdef TAUT_PYTHON_PROGRAM
  const std::size_t count = 4;
  for (const char* file :
       {"/dist-packages/taut.cpython-", "/dist-packages/taut-stubs/__init__.pyi\n"}) {
    EXPECT_NE(listing(packages["python3-taut"]).find(file), std::string::npos) << file;
  }
#else
  const std::size_t count = 3;
#endif
  ASSERT_EQ(packages.size(), count);
  for (const char* file : {"./usr/bin/taut\n", "/man1/taut-render.1.gz\n",
                           "/scenes/nunchaku.toml\n", "/scenes/scene.schema.json\n",
                           "/assets/martial_artist.glb\n", "/completions/taut\n", "/_taut\n"}) {
    EXPECT_NE(listing(packages["taut"]).find(file), std::string::npos) << file;
  }
  EXPECT_NE(listing(packages["libtaut0"]).find("/libtaut_sim.so.0 -> "), std::string::npos);
  for (const char* file : {"/include/taut/sim/world/world.h\n", "/include/taut/sim/options.h\n",
                           "/tautConfig.cmake\n", "/pkgconfig/taut.pc\n", "/libtaut_sim.so -> "}) {
    EXPECT_NE(listing(packages["libtaut-dev"]).find(file), std::string::npos) << file;
  }
  if (whole) must_run(lintian, folder.path());
}

}  // namespace
}  // namespace taut
