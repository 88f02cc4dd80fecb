// Scenes of very many things: read in seconds, as the time they take grows no faster than they do.
#include <fmt/format.h>
#include <sys/resource.h>

#include "tests/support/folder.h"
#include "tests/support/program.h"

namespace taut {
namespace {

constexpr const char* kRope = R"(duration = 0.01
fps = 1000
[method]
name = "impulse"
step = 0.0001
[connectors.rope]
length = 1.0
mass = 0.1
particles = 11
from = { fixed = [0, 1, 0] }
to = { free = true }
)";

/// Lines made by fmt of a number each, and of the middle of so many equal parts of 1.
std::string lines(int count, const std::function<std::string(int, double)>& line) {
  std::string text;
  for (int i = 0; i < count; ++i) text += line(i, (i + 0.5) / count);
  return text;
}

/// Runs taut with so much time of a processor (s), and 4 GB.
ProgramResult run_within(rlim_t seconds, const std::vector<std::string>& arguments,
                         const Folder& folder) {
  return run_taut(arguments, folder.path(), [seconds] {
#ifndef TAUT_SANITIZED  // whose shadow memory is larger, and whose runs are slower
    const rlimit time{seconds, seconds}, memory{rlim_t{4} << 30, rlim_t{4} << 30};
    setrlimit(RLIMIT_CPU, &time);
    setrlimit(RLIMIT_AS, &memory);
#endif
  });
}

std::string pins(int count, bool held) {
  return "pins = [\n" +
         lines(count,
               [&](int, double at) {
                 const std::string point = held ? fmt::format(",point=[0,{:.12f},0]", 1 - at) : "";
                 return fmt::format("{{connector=\"rope\",at={:.12f},from=0.005,until=0.007{}}},\n",
                                    at, point);
               }) +
         "]\n";
}

std::string cuts(int count) {
  return "cuts = [\n" +
         lines(count,
               [](int, double at) {
                 return fmt::format("{{connector=\"rope\",at={:.12f},t=0.005}},\n", at);
               }) +
         "]\n";
}

/// So many pins, cuts, keys, shots or bodies are read in seconds.
void expect_everything_is_read(int many) {
  const std::string rope = kRope;
  const std::pair<const char*, std::string> scenes[] = {
      {"pins", pins(many, false) + rope},
      {"pins at points", pins(many, true) + rope},
      {"cuts", cuts(many) + rope},
      {"keys", rope + "[paths.hand]\nkeys = [\n" +
                   lines(many,
                         [](int i, double) {
                           return fmt::format(
                               "{{t={}e-4,position=[0,{},0],"
                               "ease=true}},\n",
                               i, i % 7);
                         }) +
                   "]\n"},
      {"camera", rope + "[stage]\ncamera = [\n" +
                     lines(many,
                           [](int i, double) {
                             return fmt::format("{{t={}e-5,position=[0,{},9],target=[0,0,0]}},\n",
                                                i, i % 7);
                           }) +
                     "]\n"},
      {"shots",
       rope + "[stage]\n" +
           lines(many, [](int, double) { return "[[stage.shots]]\nfrom=0\nuntil=0.01\n"; })},
      {"bodies", rope + lines(many,
                              [](int i, double) {
                                return fmt::format(
                                    "[bodies.b{}]\nmass=1\nshape={{sphere={{diameter=0.1}}}}\n"
                                    "position=[{},0,0]\n",
                                    i, i);
                              })},
  };
  const Folder folder;
  for (const auto& [what, text] : scenes) {
    SCOPED_TRACE(what);
    folder.write("scene.toml", text);
    const ProgramResult outcome = run_within(20, {"check", "scene.toml", "--json"}, folder);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
  }
}

TEST(Numbers, TwentyThousandOfEverythingAreReadInSeconds) {
  expect_everything_is_read(20'000);
}

#ifndef TAUT_SANITIZED  // minutes for each, with that of threads
TEST(LongNumbers, AHundredThousandOfEverythingAreReadInSeconds) {
  expect_everything_is_read(100'000);
}
#endif

// Two of each cut, of which the first hundred are told.
TEST(Numbers, AHundredThousandMistakesAreCountedInSeconds) {
  const Folder folder;
  folder.write("scene.toml", kRope + lines(100'000, [](int, double at) {
                               return fmt::format("[[cuts]]\nconnector=\"rope\"\nat={}\ntime=0.5\n",
                                                  at);
                             }));
  const ProgramResult outcome = run_within(20, {"check", "scene.toml"}, folder);
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.messages.find("scene.toml: and 199900 more\n"), std::string::npos)
      << outcome.messages.substr(0, 999);
}

TEST(Numbers, BodiesThatHangFromEachOtherInAnyOrder) {
  // Each from the next of the file, so that the last is the first that has a place.
  constexpr int kMany = 20'000;
  const Folder folder;
  folder.write("scene.toml",
               "duration = 1\n" +
                   lines(kMany,
                         [](int i, double) {
                           return fmt::format(
                               "[bodies.b{0}]\nmass=1\nshape={{sphere={{diameter=0."
                               "1}}}}\nhangs=[0,-1,0]\n[connectors.c{0}]\nlength=1\n"
                               "mass=0\nmodel=\"span\"\nparticles=2\n"
                               "from={{body=\"b{1}\"}}\n"
                               "to={{body=\"b{0}\",point=[0,0.05,0]}}\n",
                               i, i + 1);
                         }) +
                   fmt::format("[bodies.b{}]\nmass=1\nshape={{sphere={{diameter=0.1}}}}\n"
                               "position=[0,0,0]\n",
                               kMany));
  const ProgramResult outcome = run_within(20, {"check", "scene.toml", "--json"}, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
}

/// One on each link of a rope.
void expect_cuts_and_pins_happen(int many) {
  const Folder folder;
  for (const std::string& text : {cuts(many), pins(many, false)}) {
    std::string rope = kRope;
    rope.replace(rope.find("particles = 11"), 14, fmt::format("particles = {}", many + 1));
    rope.replace(rope.find("impulse"), 7, "xpbd");
    folder.write("scene.toml", text + rope);
    const ProgramResult outcome =
        run_within(60, {"simulate", "scene.toml", "--no-estimate", "--quiet"}, folder);
    EXPECT_EQ(outcome.code, 0) << outcome.messages;
  }
}

TEST(Numbers, TwentyThousandCutsAndPinsHappen) {
  expect_cuts_and_pins_happen(19'999);
}

TEST(LongNumbers, AHundredThousandCutsAndPinsHappen) {
  expect_cuts_and_pins_happen(99'999);  // of the longest rope
}

TEST(Numbers, CutsBesideThousandsOfJointsHappen) {
  // Ropes in a row, each from the end of the one before, and all cut at once: where each of the
  // cuts looks at all joints they take minutes.
  constexpr int kMany = 20'000;
  const auto end = [](int i) {
    return i == 0 ? std::string("free = true")
                  : fmt::format("connector = \"r{}\", at = 1.0", i - 1);
  };
  const Folder folder;
  folder.write("scene.toml",
               "duration = 0.2\nfps = 10\ncuts = [\n" +
                   lines(kMany,
                         [](int i, double) {
                           return fmt::format("{{connector=\"r{}\",at=0.3,t=0.05}},\n", i);
                         }) +
                   "]\n[method]\nname = \"xpbd\"\nstep = 0.05\n" + lines(kMany, [&](int i, double) {
                     return fmt::format(
                         "[connectors.r{0}]\nlength=1\nmass=1\nparticles=5\nfrom={{{1}}}\n"
                         "to={{free=true}}\nstart={{points=[[{0},0,0],[{2},0,0]]}}\n",
                         i, end(i), i + 1);
                   }));
  const ProgramResult outcome =
      run_within(60, {"simulate", "scene.toml", "--no-estimate", "--quiet"}, folder);
  EXPECT_EQ(outcome.code, 0) << outcome.messages;
}

}  // namespace
}  // namespace taut
