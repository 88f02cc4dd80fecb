#include "tests/faults/subject.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "render/program/output.h"
#include "tests/cli/swing_scene.h"

namespace taut::faults {
namespace {

constexpr const char* kGoldens = R"(size = [32, 18]
[frames.start]
scene = "swing.toml"
time = 0.02
[trajectories.swing]
scene = "swing.toml"
until = 0.04
)";

/// A rope of 4 particles from what `hold` says.
std::string rope(const std::string& hold) {
  return R"(duration = 0.1
fps = 20
[paths.hand]
file = "hand.csv"
[connectors.rope]
length = 0.2
mass = 0.05
particles = 4
from = )" +
         hold + R"(
to = { point_mass = 0.2 }
start = { direction = [1, 0, 0] }
)";
}

/// The stick of a swing, as a model that a child process reads.
constexpr const char* kStick =
    "v 0 -0.15 0\nv 0.014 -0.15 0\nv 0 0.15 0\nv 0 0 0.014\nf 1 2 3\nf 1 3 4\n";

std::string with_mesh(std::string scene) {
  const std::string body = "[bodies.free]\n";
  return scene.insert(scene.find(body) + body.size(), "mesh = \"stick.obj\"\n");
}

constexpr const char* kHand = "t,x,y,z\n0,0,0.6,0\n0.05,0.01,0.6,0\n0.1,0.01,0.62,0\n";

}  // namespace

const std::vector<Subject>& subjects() {
  static const std::string scene = swing_scene(0.06);  // 3 frames
  static const std::vector<Subject> all = {
      {"simulate",
       {"simulate", "rope.toml", "--csv", "run/rope.csv"},
       {{"rope.toml", rope("{ path = \"hand\" }")}, {"hand.csv", kHand}},
       {},
       0,
       false,
       300,
       10},
      {"export",
       {"export", "swing.toml", "-o", "swing.glb"},
       {{"swing.toml", with_mesh(scene)}, {"stick.obj", kStick}, {"swing.glb", "old"}},
       {},
       program::kBadScene,
       true,
       100,
       20},
      {"render",
       {"render", "swing.toml", "--out", "clip", "--size", "32x18", "--threads", "2", "--quiet"},
       {{"swing.toml", scene},
        {"clip/swing.mp4", "old"},
        {"clip/clip.json", "old"},
        {"clip/frames/000007.png", "old"}},
       {"clip/frames/journal", "clip/frames/lock"},
       program::kEncoder,
       false,
       30,
       40},
      {"plan",
       {"plan", "swing.toml", "--tolerance", "20mm", "--write", "--quiet"},
       {{"swing.toml", scene}},
       {},
       0,
       false,
       30,
       10},
      {"golden",
       {"golden", "accept", "kept"},
       {{"CMakePresets.json", "{}"}, {"swing.toml", scene}, {"kept/golden.toml", kGoldens}},
       {},
       0,
       false,
       60,
       10},
      {"chart",
       {"chart", "rope.toml", "--quick", "--methods", "impulse", "--budget", "0.2", "--out",
        "study", "--quiet"},
       {{"rope.toml", rope("{ fixed = [0, 0.6, 0] }")}, {"hand.csv", kHand}},
       {"study/chart.unfinished"},
       program::kCannotWrite,
       false,
       30,
       20}};
  return all;
}

std::string lasting(const std::string& name, const std::string& bytes) {
  const std::filesystem::path file = name;
  if (file.filename() == "clip.json" && bytes.starts_with('{')) {
    auto record = nlohmann::ordered_json::parse(bytes);
    // How many frames an earlier run had left to draw is not of the clip.
    for (const char* key : {"seconds_per_frame", "frames_drawn", "mean_exposures"})
      record.erase(key);
    return record.dump();
  }
  // A chart shows times: only its wholeness can be told.
  if (file.extension() == ".svg") return bytes.ends_with("</svg>\n\n") ? "whole" : "cut short";
  if (file.extension() == ".html") return bytes.ends_with("</html>\n") ? "whole" : "cut short";
  if (file.stem().string().starts_with("chart")) {
    if (file.extension() == ".png")
      return bytes.substr(std::max<std::size_t>(bytes.size(), 8) - 8, 4) == "IEND" ? "whole"
                                                                                   : "cut short";
    if (file.extension() == ".csv") return bytes.ends_with('\n') ? "whole" : "cut short";
  }
  return bytes;
}

}  // namespace taut::faults
