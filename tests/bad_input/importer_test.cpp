// Faults of the library that reads models, planted: the scene's place is named, nothing else
// happens.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cstdlib>

#include "tests/support/fault_table.h"
#include "tests/support/filters.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"
#include "tests/unit/scenes/model_files.h"

namespace taut {
namespace {

constexpr const char* kScene = R"(duration = 1.0
[bodies.ball]
mass = 1.0
shape = { sphere = { diameter = 0.1 } }
position = [0, 1, 0]
mesh = "ball.glb"
)";

struct Fault {
  const char* how;  // what the library that stands in front of the importer's calls it
  const char* name;
  const char* says;
};

TEST(BadImporter, EndsAloneAndIsNamed) {
#ifdef TAUT_SANITIZED
  GTEST_SKIP() << "a sanitizer's library must be loaded before all others";
#endif
  if (!has_filters()) GTEST_SKIP() << "no filters of system calls here";
  const Fault faults[] = {
      {"crash", "writes where nothing is", "its reader was ended by signal 11"},
      {"abort", "aborts", "its reader was ended by signal 6"},
      {"throw", "throws what it should not", "its reader failed: a list has no end"},
      {"exit", "ends the program", "its reader gave no model"},
      {"memory", "takes memory for ever", "takes more than 2048 MiB of memory to be read"},
      {"loop", "never ends", "takes longer than 5 s to be read"},
      {"socket", "opens a connection", "its reader asked the system for more than memory"},
      {"read", "opens a file", "its reader asked the system for more than memory"},
      {"file", "makes a file", "its reader asked the system for more than memory"},
      {"remove", "removes a file", "its reader asked the system for more than memory"},
  };
  const Folder folder;
  FaultTable table("Faults in the library that reads models", folder.path());
  folder.write("scene.toml", kScene);
  folder.write("ball.glb", triangle().bytes());
  for (const Fault& fault : faults) {
    SCOPED_TRACE(fault.name);
    const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path(), [&] {
      setenv("LD_PRELOAD", TAUT_IMPORTER_LIBRARY, 1);
      setenv("TAUT_IMPORTER_FAULT", fault.how, 1);
    });
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.output, "");
    const std::string start = "taut: scene.toml:6:8: bodies.ball.mesh: ball.glb: ";
    EXPECT_EQ(outcome.messages.rfind(start + fault.says, 0), 0u) << outcome.messages;
    table.add(fault.name, outcome);
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "planted"));
  EXPECT_EQ(read_file(folder.path() / "scene.toml"), kScene);
  EXPECT_TRUE(table.is_as_accepted());
  EXPECT_EQ(run_taut({"check", "scene.toml"}, folder.path()).code, 0);
}

/// The limit of whoever runs the program is no fault of the scene.
TEST(BadImporter, ALimitOfTheProgramsMemoryIsToldAsThat) {
#ifdef TAUT_SANITIZED
  GTEST_SKIP() << "a sanitizer's library must be loaded before all others";
#endif
  const Folder folder;
  folder.write("scene.toml", kScene);
  folder.write("ball.glb", triangle().bytes());
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path(), [&] {
    setenv("LD_PRELOAD", TAUT_IMPORTER_LIBRARY, 1);
    setenv("TAUT_IMPORTER_FAULT", "memory", 1);
    const rlimit limit{1u << 30, 1u << 30};
    setrlimit(RLIMIT_AS, &limit);
  });
  EXPECT_EQ(outcome.code, 8) << outcome.messages;
  EXPECT_EQ(outcome.messages, "taut: out of memory\n");
}

}  // namespace
}  // namespace taut
