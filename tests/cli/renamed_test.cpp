// Commands and keys of scenes that have another name now: the former ones work, with a note.
#include <gtest/gtest.h>

#include "tests/cli/swing_scene.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

TEST(Renamed, CommandsWorkUnderTheirFormerNames) {
  const Folder folder;
  folder.write("scene.toml", kShortSwing);
  const ProgramResult now =
      run_taut({"classify", "scene.toml", "--methods", "direct"}, folder.path());
  const ProgramResult before =
      run_taut({"judge", "scene.toml", "--methods", "direct"}, folder.path());
  EXPECT_EQ(before.code, 0) << before.messages;
  EXPECT_EQ(before.output, now.output);
  EXPECT_NE(before.messages.find("taut: judge is called classify now\n"), std::string::npos)
      << before.messages;
  EXPECT_EQ(now.messages.find("is called"), std::string::npos) << now.messages;
  EXPECT_EQ(run_taut({"reach", "--help"}, folder.path()).code, 0);
}

TEST(Renamed, KeysOfScenesAreReadUnderTheirFormerNames) {
  const Folder folder;
  const std::string text = read_file(TAUT_SOURCE_DIR "/scenes/two_bodies.toml");
  const std::string key = "restitution = 0.3\n";
  const std::size_t at = text.find(key);
  ASSERT_NE(at, std::string::npos);
  const auto scene = [&](const std::string& name, const std::string& other) {
    folder.write(name, std::string(text).replace(at, key.size(), other));
    return run_taut({"simulate", name, "--method", "impulse", "--csv", "-"}, folder.path());
  };
  const ProgramResult now = scene("now.toml", "restitution = 0.3\n");
  const ProgramResult before = scene("before.toml", "elasticity = 0.3\n");
  const ProgramResult none = scene("none.toml", "");
  ASSERT_EQ(now.code, 0) << now.messages;
  ASSERT_EQ(before.code, 0) << before.messages;
  EXPECT_EQ(before.output, now.output);
  EXPECT_NE(none.output, now.output);
  EXPECT_NE(before.messages.find(
                "before.toml:29:1: connectors.cord.elasticity is called restitution now\n"),
            std::string::npos)
      << before.messages;
  EXPECT_EQ(now.messages.find("is called"), std::string::npos) << now.messages;
  EXPECT_EQ(run_taut({"simulate", "before.toml", "-q"}, folder.path()).messages, "");

  const ProgramResult both = scene("both.toml", "restitution = 0.3\nelasticity = 0.3\n");
  EXPECT_EQ(both.code, 3);
  EXPECT_NE(both.messages.find("both.toml:30:1"), std::string::npos) << both.messages;
}

}  // namespace
}  // namespace taut
