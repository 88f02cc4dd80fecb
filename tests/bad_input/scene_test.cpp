// Bad scenes, as the program meets them: exit code 3, the place and the cause on standard error,
// nothing on standard output. Their messages make the table of faults.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/bad_input/good_scene.h"
#include "tests/bad_input/scene_faults.h"
#include "tests/support/fault_table.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

/// The good scene with the fault in it, and the place (line:column) that the message must name.
std::pair<std::string, std::string> spoilt(const SpoiltScene& fault) {
  std::string text(kGoodScene);
  const std::size_t at = text.find(fault.good);
  if (at == std::string::npos) return {};
  text.replace(at, fault.good.size(), fault.bad);
  if (!fault.place.empty()) return {text, fault.place};
  const std::size_t mark = text.find('^');
  text.erase(mark, 1);
  const auto begin = text.begin(), end = begin + static_cast<std::ptrdiff_t>(mark);
  const auto line = 1 + std::count(begin, end, '\n');
  const std::size_t column = mark - text.rfind('\n', mark - 1);
  return {text, fmt::format("{}:{}", line, column)};
}

TEST(BadScene, TheGoodSceneIsGood) {
  const Folder folder;
  folder.write("scene.toml", std::string(kGoodScene));
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
  EXPECT_EQ(outcome.messages, "");
}

TEST(BadScene, EveryFaultIsNamedWithItsPlace) {
  const Folder folder;
  FaultTable table("Scenes", folder.path());
  for (const SpoiltScene& fault : spoilt_scenes()) {
    SCOPED_TRACE(fault.name);
    const auto [text, place] = spoilt(fault);
    ASSERT_NE(text, "") << "the good scene has no \"" << fault.good << '"';
    folder.write("scene.toml", text);
    const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.output, "");
    EXPECT_TRUE(outcome.messages.starts_with("taut: scene.toml:" + place + ": "))
        << place << '\n'
        << outcome.messages;
    EXPECT_NE(outcome.messages.find(fault.says), std::string::npos) << outcome.messages;
    // One fault is one line: its consequences are no faults of their own.
    EXPECT_EQ(std::ranges::count(outcome.messages, '\n'), 1) << outcome.messages;
    table.add(fault.name, outcome);
  }
  EXPECT_TRUE(table.is_as_accepted());
}

// Of different kinds, in different entries and in the same one.
TEST(BadScene, AllFaultsAreToldAtOnce) {
  std::string text(kGoodScene);
  const auto spoil = [&](std::string_view good, std::string_view bad) {
    ASSERT_NE(text.find(good), std::string::npos) << good;
    text.replace(text.find(good), good.size(), bad);
  };
  spoil("duration = 1.0\n", "");
  spoil("hold = 0.1", "hold = 0.1, colour = 3");
  spoil("step = 0.001", "step = 0.005");
  spoil("rotation = [1, 0, 0, 0]", "rotation = [0, 0, 0, 0]");
  spoil("at = 0.06\n", "at = 0.6\n");
  text +=
      "[connectors.tight]\nlength = 1\nmass = 0.1\nparticles = 5\n"
      "from = { fixed = [0, 0, 0] }\nto = { fixed = [3, 0, 0] }\n"
      "[bodies.round]\nmass = 1\nshape = { sphere = { diameter = 0.1 } }\n"
      "position = [0, 0, 0]\nrotation = [0, 0, 0, 0]\nmesh = \"none.glb\"\n";
  const Folder folder;
  folder.write("scene.toml", text);
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(outcome.code, 3);
  for (const char* says :
       {"duration is missing", "paths.hand.keys[1].colour", "method.step",
        "connectors.tight: the ends are 3 m apart", "bodies.round.rotation", "bodies.round.mesh"}) {
    EXPECT_NE(outcome.messages.find(says), std::string::npos) << says << '\n' << outcome.messages;
  }
}

TEST(BadScene, AMethodThatFollowsLinksAloneTakesNoSpans) {
  const Folder folder;
  folder.write("scene.toml",
               "duration = 1\n[method]\nname = \"xpbd\"\n[connectors.rope]\nlength = 1.0\n"
               "mass = 0.1\nparticles = 5\nmodel = \"span\"\nfrom = { fixed = [0, 1, 0] }\n"
               "to = { point_mass = 0.2 }\nstart = { direction = [0, -1, 0] }\n");
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.messages.find("scene.toml:8:1: connectors.rope.model: the method xpbd does not "
                                  "follow massless spans, expected one of: impulse, direct"),
            std::string::npos)
      << outcome.messages;
}

TEST(BadScene, MoreParticlesThanMemoryIsFor) {
  std::string text = "duration = 1\n";
  for (int i = 0; i < 11; ++i) {
    text += fmt::format(
        "[connectors.rope_{}]\nlength = 1.0\nmass = 1.0\nparticles = 100000\n"
        "from = {{ fixed = [0, 1, 0] }}\nto = {{ free = true }}\n",
        i);
  }
  const Folder folder;
  folder.write("scene.toml", text);
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.messages.find("scene.toml:65:13: connectors.rope_10.particles: found 100000, "
                                  "expected at most 1000000 in all connectors together"),
            std::string::npos)
      << outcome.messages;
}

TEST(BadScene, FilesThatAreNoScenes) {
  const Folder folder;
  fs::create_directory(folder.path() / "folder.toml");
  folder.write("empty.toml", "");
  folder.write("binary.toml", std::string("\x7f"
                                          "ELF\0\0\1\2",
                                          8));
  folder.write("deep.toml", "a = " + std::string(100000, '['));
  std::string dots = "a";
  for (int i = 0; i < 100000; ++i) dots += ".a";
  folder.write("dots.toml", dots + " = 1");
  folder.write("huge.toml", "");
  fs::resize_file(folder.path() / "huge.toml", std::uintmax_t{1} << 30);  // sparse
  fs::create_symlink("loop.toml", folder.path() / "loop.toml");

  FaultTable table("Files that are no scenes", folder.path());
  const auto expect = [&](const char* name, const char* file, const char* says) {
    SCOPED_TRACE(file);
    const ProgramResult outcome = run_taut({"check", file}, folder.path());
    EXPECT_EQ(outcome.code, 3);
    EXPECT_EQ(outcome.output, "");
    EXPECT_EQ(outcome.messages.rfind(std::string("taut: ") + file + ":", 0), 0u);
    EXPECT_NE(outcome.messages.find(says), std::string::npos) << outcome.messages;
    table.add(name, outcome);
  };
  expect("missing", "missing.toml", "No such file");
  expect("a directory", "folder.toml", "is a directory");
  expect("below a file", "empty.toml/scene.toml", "Not a directory");
  expect("a link to itself", "loop.toml", "symbolic links");
  expect("empty", "empty.toml", "duration is missing");
  expect("binary", "binary.toml", "not a TOML file");
  expect("100,000 brackets", "deep.toml", "not a TOML file");
  expect("a key of 100,000 dots", "dots.toml", "dots");
  fs::create_symlink("/proc/self/mem", folder.path() / "unreadable.toml");
  expect("unreadable", "unreadable.toml", "cannot be read: Input/output error");
  expect("sparse, 1 GiB", "huge.toml", "larger than 16 MiB");
  mkfifo((folder.path() / "pipe.toml").c_str(), 0600);
  expect("a pipe", "pipe.toml", "is a pipe");
  expect("a device", "/dev/zero", "is a device");
  folder.write("extends.toml", "extends = \"none.toml\"\n");
  expect("extends no file", "extends.toml", "1:11: extends: none.toml: cannot be opened");
  folder.write("extends.toml", "extends = \"folder.toml\"\n");
  expect("extends a folder", "extends.toml", "1:11: extends: folder.toml: is a directory");
  folder.write("extends.toml", "extends = \"pipe.toml\"\n");
  expect("extends a pipe", "extends.toml", "1:11: extends: pipe.toml: is a pipe");
  EXPECT_TRUE(table.is_as_accepted());
}

TEST(BadScene, UnreadableFile) {
  const Folder folder;
  fs::permissions(folder.path(), fs::perms::all);
  const auto file = folder.write("scene.toml", std::string(kGoodScene));
  fs::permissions(file, fs::perms::none);
  // Root reads everything, so the program runs as somebody else.
  const auto drop_root = [] {
    if (geteuid() == 0 && setuid(65534) != 0) _exit(126);
  };
  const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path(), drop_root);
  if (outcome.code == 127) GTEST_SKIP() << "somebody else cannot run the program";
  EXPECT_EQ(outcome.code, 3);
  EXPECT_EQ(outcome.messages, "taut: scene.toml: cannot be opened: Permission denied\n");
}

TEST(BadScene, FilesOutsideOfTheRootAreRefused) {
  const Folder folder;
  folder.write("hand.csv", "t,x,y,z\n0,0,1,0\n");
  folder.write("repository/CMakePresets.json", "");
  folder.write("repository/inside.csv", "t,x,y,z\n0,0,1,0\n");
  fs::create_symlink("../hand.csv", folder.path() / "repository/link.csv");
  const auto check = [&](const std::string& file) {
    folder.write("repository/scenes/scene.toml",
                 "duration = 1.0\n[paths.hand]\nfile = \"" + file + "\"\n");
    return run_taut({"check", "repository/scenes/scene.toml"}, folder.path());
  };
  EXPECT_EQ(check("inside.csv").code, 0);
  EXPECT_EQ(check("../inside.csv").code, 0);
  for (const char* file : {"../../hand.csv", "../hand.csv", "link.csv", "/etc/passwd"}) {
    const ProgramResult outcome = check(file);
    EXPECT_EQ(outcome.code, 3) << file;
    EXPECT_NE(outcome.messages.find("scene.toml:3:8: paths.hand.file: found"), std::string::npos)
        << outcome.messages;
  }
}

TEST(BadScene, PathFiles) {
  const Folder folder;
  folder.write("scene.toml", "duration = 1.0\n[paths.hand]\nfile = \"hand.csv\"\n");
  FaultTable table("Path files (CSV)", folder.path());
  const auto expect = [&](const char* name, const std::string& csv, const char* says) {
    folder.write("hand.csv", csv);
    const ProgramResult outcome = run_taut({"check", "scene.toml"}, folder.path());
    EXPECT_EQ(outcome.code, 3) << csv;
    EXPECT_NE(outcome.messages.find(std::string("hand.csv") + says), std::string::npos)
        << outcome.messages;
    table.add(name, outcome);
  };
  expect("empty", "", ":1: has no rows");
  expect("other columns", "time,x,y,z\n", ":1: expected the columns t,x,y,z");
  expect("a field too few", "t,x,y,z\n0,1,2\n", ":2: expected 4 finite numbers");
  expect("a word", "t,x,y,z\n0,1,2,three\n", ":2: expected 4 finite numbers");
  expect("nan", "t,x,y,z\n0,1,2,nan\n", ":2: expected 4 finite numbers");
  expect("time standing still", "t,x,y,z\n0,1,2,3\n0,1,2,3\n", ":3: found the time 0");
  expect("quaternion of length 0", "t,x,y,z,qw,qx,qy,qz\n0,1,2,3,0,0,0,0\n",
         ":2: found a quaternion");
  expect("times beyond a day", "t,x,y,z\n0,1,2,3\n1e300,1,2,3\n", ":3: found the time 1e+300");
  expect("a line of 10 MB", "t,x,y,z\n0," + std::string(10'000'000, ' ') + "1,2,3\n",
         ":2: a line of 10000007 bytes");
  fs::remove(folder.path() / "hand.csv");
  mkfifo((folder.path() / "hand.csv").c_str(), 0600);
  const ProgramResult pipe = run_taut({"check", "scene.toml"}, folder.path());
  EXPECT_EQ(pipe.code, 3);
  EXPECT_NE(pipe.messages.find("scene.toml:3:8: paths.hand.file: hand.csv: is a pipe"),
            std::string::npos)
      << pipe.messages;
  table.add("a pipe", pipe);
  EXPECT_TRUE(table.is_as_accepted());
}

}  // namespace
}  // namespace taut
