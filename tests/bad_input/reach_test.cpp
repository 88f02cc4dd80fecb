// Holds that lead a connector where its links do not reach.
#include <gtest/gtest.h>

#include "tests/support/fault_table.h"
#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

/// A rope of 0.2 m that nothing pulls, and a hand that leaves for a while.
std::string scene(const std::string& fps, const std::string& particles, const std::string& to,
                  const std::string& start, const std::string& more) {
  return "duration = 2.0\nfps = " + fps + R"(
gravity = [0, 0, 0]
[paths.hand]
keys = [{ t = 0.2, position = [0, 0, 0], ease = true }, { t = 0.6, position = [0.3, 0, 0] }, { t = 0.9, position = [0, 0, 0], ease = true }]
[connectors.rope]
length = 0.2
mass = 0.1
particles = )" +
         particles + "\nfrom = { path = \"hand\" }\nto = " + to + '\n' + start + '\n' + more;
}

constexpr const char* kFolded = "start = { points = [[0, 0, 0], [0, -0.05, 0], [0.01, 0.2, 0]] }";
constexpr const char* kFull = "are at full length between two places that are held";
constexpr const char* kPin = "[[pins]]\nconnector = \"rope\"\nat = 0.09\nfrom = 0.1\n";

/// A hand that leaves a pin by thousandths of a millimetre while the links between are straight.
std::string dead_centre(const std::string& centre, const std::string& axis) {
  return R"(duration = 0.1
fps = 120
gravity = [0, 0, 0]
[method]
name = "direct"
tolerance = 0.0005
[paths.round]
circle = { centre = )" +
         centre + ", start = [0, 0, 0], axis = " + axis + R"(, frequency = 0.4826, ramp = 0.5571 }
[connectors.rope]
length = 1.0525
particles = 3
mass = 0.2183
from = { path = "round" }
to = { free = true }
[[pins]]
connector = "rope"
at = 0.7962
from = 0.01212
until = 0.0525
)";
}

TEST(OutOfReach, IsNamed) {
  const Folder folder;
  FaultTable table("Out of reach", folder.path());
  const auto expect = [&](const char* name, const std::string& text, int code, const char* says) {
    SCOPED_TRACE(name);
    folder.write("scene.toml", text);
    const ProgramResult outcome = run_taut({"simulate", "scene.toml"}, folder.path());
    EXPECT_EQ(outcome.code, code);
    EXPECT_NE(outcome.messages.find(says), std::string::npos) << outcome.messages;
    table.add(name, outcome);
  };
  const std::string near = "{ fixed = [0, -0.1, 0] }", free = "{ free = true }";
  expect("a single link between nearer ends", scene("60", "2", near, "", ""), 3,
         "scene.toml:6:1: connectors.rope: the ends are 0.1 m apart");
  expect("an end that is led away", scene("60", "21", near, "", ""), 7, kFull);
  expect("an end that is led away from a pin", scene("60", "21", free, kFolded, kPin), 7, kFull);
  expect("the same, between two frames", scene("1", "21", free, kFolded, kPin), 7, kFull);
  expect("the same, of a single link", scene("60", "3", free, kFolded, kPin), 7,
         "what holds both its ends leads them");
  expect("the same, at once straight", dead_centre("[-0.06, -0.05, 0]", "[0, 0, 1]"), 7,
         "at full length");
  expect("the same, slower", dead_centre("[0.05, 0, 0.06]", "[0, 1, 0]"), 7, "at full length");
  expect("the same, of a massless span", scene("60", "2", near, "model = \"span\"", ""), 7,
         "what holds both its ends leads them");
  EXPECT_TRUE(table.is_as_accepted());
}

}  // namespace
}  // namespace taut
