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

}  // namespace
}  // namespace taut
#endif
