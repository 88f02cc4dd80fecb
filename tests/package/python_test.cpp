// The module for Python as it is once it is installed.
#ifdef TAUT_PYTHON_PROGRAM
#include "tests/package/prefix.h"

namespace taut {
namespace {

TEST(InstalledPython, ImportsTheModuleAndFindsScenes) {
  Folder folder;
  const std::string path = "PYTHONPATH=" + (prefix() / "lib/python3/dist-packages").string();
  const std::string scene = (prefix() / "share/taut/scenes/rope_swing.toml").string();
  const auto said = must_run({"env", path, TAUT_PYTHON_PROGRAM, "-c",
                              "import taut; print(taut.__version__, taut.load('" + scene +
                                  "').simulate('direct').positions['rope'].shape)"},
                             folder.path());
  EXPECT_EQ(said.output, "0.1.0 (90, 21, 3)\n");
}

/// Out of the build folder: `pip wheel .` calls the same with one of its own.
TEST(Wheel, HasTheModuleAndItsStubs) {
  Folder folder;
  const std::string source = TAUT_SOURCE_DIR;
  must_run({TAUT_PYTHON_PROGRAM, "-B", "-c",
            "import sys; sys.path.insert(0, '" + source +
                "/render/python'); import build_wheel; "
                "print(build_wheel.build_wheel('.', {'build-dir': '" TAUT_BUILD_DIR "'}))"},
           folder.path());
  const auto said = must_run({TAUT_PYTHON_PROGRAM, "-B", "-c", R"(
import base64, glob, hashlib, subprocess, sys, zipfile
(wheel,) = glob.glob('taut-0.1.0-cp3*.whl')
with zipfile.ZipFile(wheel) as archive:
    archive.extractall('site')
    names = archive.namelist()
    for line in archive.read('taut-0.1.0.dist-info/RECORD').decode().splitlines():
        name, digest, size = line.split(',')
        data = archive.read(name)
        if digest:
            found = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()
            assert (digest, int(size)) == ('sha256=' + found, len(data)), name
        names.remove(name)
print(names)
sys.path.insert(0, 'site')
import taut
print(taut.__version__, taut.__file__.endswith('.so'), 'site' in taut.__file__)
)"},
                             folder.path());
  EXPECT_EQ(said.output, "[]\n0.1.0 True True\n");
}

}  // namespace
}  // namespace taut
#endif
