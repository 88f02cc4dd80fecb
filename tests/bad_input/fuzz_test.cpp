// The fuzzers' corpus again, and mutations of it: nothing but the errors that are meant.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <random>
#include <vector>

#include "render/golden/golden.h"
#include "render/golden/golden_trajectory.h"
#include "render/picture/picture.h"
#include "scenes/load/golden_suite.h"
#include "scenes/load/plan_file.h"
#include "sim/evaluation/run.h"
#include "tests/fuzz/readers.h"
#include "tests/support/folder.h"
#include "tests/unit/scenes/model_files.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> files_in(const fs::path& folder, std::string_view extension = "") {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && (extension.empty() || entry.path().extension() == extension))
      files.push_back(entry.path());
  std::ranges::sort(files);
  std::vector<std::string> contents;
  for (const fs::path& file : files) contents.push_back(read_file(file));
  return contents;
}

/// A few bytes changed, a piece cut out, doubled, or put in from another input.
std::string mutated(std::string bytes, const std::vector<std::string>& others,
                    std::mt19937& chance) {
  const auto below = [&](std::size_t n) { return n ? chance() % n : 0; };
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    const std::size_t at = below(bytes.size()),
                      length = below(std::min<std::size_t>(bytes.size() - at + 1, 40));
    switch (below(5)) {
      case 0:
        if (!bytes.empty()) bytes[at] = static_cast<char>(chance());
        break;
      case 1:
        bytes.erase(at, length);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 3: {
        const std::string& other = others[below(others.size())];
        bytes.insert(at, other.substr(below(other.size()), below(60)));
        break;
      }
      case 4: {
        constexpr const char* kNumbers[] = {
            "0", "-1", "nan", "inf", "1e308", "-1e-308", "4294967296", "9223372036854775807"};
        bytes.replace(at, length, kNumbers[below(std::size(kNumbers))]);
        break;
      }
    }
  }
  return bytes;
}

/// All scenes; those with characters, whose hands take a hundred times as long, less often.
std::vector<std::string> scenes() {
  constexpr int kOthers = 100;
  std::vector<std::string> inputs;
  for (const std::vector<std::string>& files :
       {files_in(TAUT_SOURCE_DIR "/scenes", ".toml"),
        files_in(TAUT_SOURCE_DIR "/tests/fuzz/corpus/scene")})
    for (const std::string& input : files) {
      const bool dear =
          input.find("[characters") != input.npos || input.find("\nextends") != input.npos;
      inputs.insert(inputs.end(), dear ? 1 : kOthers, input);
    }
  return inputs;
}

/// Those that name no models, each of which is read by a process of its own.
std::vector<std::string> stages() {
  std::vector<std::string> inputs;
  for (const std::string& input : files_in(TAUT_SOURCE_DIR "/scenes", ".toml")) {
    const bool names = input.find("mesh") != input.npos || input.find("\nextends") != input.npos;
    if (!names && input.find("[stage") != input.npos) inputs.push_back(input);
  }
  return inputs;
}

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  unsigned value = 0, bits = 0;
  for (const char c : bytes) {
    value = value << 8 | static_cast<unsigned char>(c);
    for (bits += 8; bits >= 6; bits -= 6) text += kDigits[value >> (bits - 6) & 63];
  }
  if (bits > 0) text += kDigits[value << (6 - bits) & 63];
  while (text.size() % 4 != 0) text += '=';
  return text;
}

/// And the corpus of models, also of another format.
std::vector<std::string> with_corpus(std::vector<std::string> inputs) {
  for (const std::string& input : files_in(TAUT_SOURCE_DIR "/tests/fuzz/corpus/model"))
    inputs.push_back(input);
  return inputs;
}

std::vector<std::string> glbs() {
  return with_corpus({skinned().bytes(), triangle().bytes(), animated().bytes()});
}

std::vector<std::string> gltfs() {
  std::vector<std::string> inputs;
  for (Gltf g : {skinned(), triangle(), animated()}) {
    g.json["buffers"][0] = {{"uri", "data:application/octet-stream;base64," + base64(g.binary)},
                            {"byteLength", g.binary.size()}};
    inputs.push_back(g.json.dump());
  }
  return with_corpus(inputs);
}

std::vector<std::string> bvhs() {
  return with_corpus(
      {"HIERARCHY\nROOT Hips\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition "
       "Zposition Zrotation Xrotation Yrotation\nJOINT Head\n{\nOFFSET 0 1 0\n"
       "CHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n}\n"
       "MOTION\nFrames: 2\nFrame Time: 0.1\n0 1 2 10 20 30 40 50 60\n"
       "0 1 2 10 20 30 40 50 60\n"});
}

std::vector<std::string> objs() {
  return with_corpus({"v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\n",
                      "o a\ng b\nv 0 0 0 1 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nusemtl m\ns 1\n"
                      "f 1/1 2/1 4/1 3/1\nf -1 -2 -3\n"});
}

std::vector<std::string> paths() {
  return {"t,x,y,z\n0,0,0.6,0\n0.05,0.01,0.6,0\n0.1,0.01,0.62,0\n",
          "t,x,y,z,qw,qx,qy,qz\r\n-1,0,1e-3,0,1,0,0,0\r\n0.5, 1, 2, 3, 0.5, 0.5, -0.5, 0.5\r\n"};
}

Snapshot state() {
  return {0.5, {{Vec3(0, 1, 0), Vec3(0.1, -0.25, 1e-7)}}, {{Vec3(1, 2, 3), Quat(0, 1, 0, 0)}}};
}

std::vector<std::string> goldens() {
  return {golden::golden_text({"driver", state(), {{{Vec3(1, 2, 3), Quat(0, 1, 0, 0)}}}})};
}

std::vector<std::string> trajectories() {
  return {golden::trajectory_text({{{"fps", "60"}}, {state(), state()}})};
}

/// Suites that name a shipped scene.
std::vector<std::string> suites() {
  return {R"(schema_version = 1
size = [320, 180]
samples = 4
[frames.first]
scene = "scenes/bench_swing.toml"
time = 0.1
within = 1e-3
[trajectories.swing]
scene = "scenes/bench_swing.toml"
until = 0.2
method = { name = "direct", tolerance = 1e-4 }
)",
          "trajectories.a = { scene = \"scenes/rope_swing.toml\", until = 0.5 }\n"};
}

/// Shipped scenes with plans.
std::vector<std::string> planned() {
  std::vector<std::string> inputs;
  for (const std::string& input : files_in(TAUT_SOURCE_DIR "/scenes", ".toml"))
    if (input.find("\n[plan]") != input.npos) inputs.push_back(input);
  return inputs;
}

std::vector<std::string> pictures() {
  std::vector<std::string> inputs;
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 2}, {32, 18}}) {
    const auto bytes = picture::encode_png(picture::Picture(width, height));
    inputs.emplace_back(bytes.begin(), bytes.end());
  }
  return inputs;
}

std::vector<std::string> sets() {
  std::vector<std::string> inputs;
  for (const std::string& scene : files_in(TAUT_SOURCE_DIR "/tests/fuzz/corpus/scene"))
    for (const char* set : {"duration=2", "method.tolerance=1e-4", "connectors.rope.particles=7",
                            "connectors.rope={length=1}", "gravity=[0, -1, 0]"})
      inputs.push_back(std::string(set) + '\n' + scene);
  return inputs;
}

std::vector<std::string> materials() {
  return {"newmtl a\nKd 0.5 0.4 1\nPr 0.3\nPm 1\nd 1\n\nnewmtl b c\nmap_Kd -s 1 1 1 a b.png\n",
          "newmtl a\r\nKd spectral x\r\nmap_Kd pictures\\red.png\r\nillum 2\r\nNs 96.0\r\n"};
}

/// And a small JPEG picture.
std::vector<std::string> images() {
  std::vector<std::string> inputs = pictures();
  for (const std::string& input : files_in(TAUT_SOURCE_DIR "/tests/fuzz/corpus/image"))
    inputs.push_back(input);
  return inputs;
}

std::vector<std::string> words() {
  return {"1-5,7", "0", "9-2", "320x180", "1x1", "0.5mm", "1px"};
}

std::vector<std::string> journals() {
  return {"taut study 0123456789abcdef\nrope direct 1e-3\t0.1\t1e-9\tnan\t\nkey\t\n"};
}

std::vector<std::string> frames() {
  return {"000001 0123456789abcdef fedcba9876543210\n000002 0000000000000001 0000000000000002\n"};
}

std::vector<std::string> records() {
  return {R"({"renderer": "llvmpipe", "frames_drawn": 3, "mean_exposures": 4.5,
              "seconds_per_frame": {"rendering": 0.01}})"};
}

std::vector<std::string> times() {
  return {R"({"methods": [{"method": "direct", "cpu_us_per_frame": 12.5},
              {"method": "xpbd", "cpu_us_per_frame": null}]})"};
}

std::vector<std::string> tables() {
  return {"method,error (m),time\ndirect,1e-3,\"5, about\"\nxpbd,\"a \"\"b\"\"\",-\n"};
}

/// The inputs of a reader, from which others are made.
const std::map<std::string_view, std::vector<std::string> (*)()> kInputs = {
    {"Scene", scenes},       {"Stage", stages},         {"Set", sets},
    {"Glb", glbs},           {"Gltf", gltfs},           {"Obj", objs},
    {"Bvh", bvhs},           {"Materials", materials},  {"Image", images},
    {"PathCsv", paths},      {"GoldenRecord", goldens}, {"GoldenTrajectory", trajectories},
    {"GoldenSuite", suites}, {"Plan", planned},         {"Png", pictures},
    {"Words", words},        {"Journal", journals},     {"Frames", frames},
    {"Record", records},     {"Times", times},          {"Table", tables},
    {"State", saved_states}};

#ifdef TAUT_SANITIZED
constexpr double kPatience = 50;  // s of CPU time for one input
#else
constexpr double kPatience = 5;
#endif
constexpr double kMemory = 1024.0 * 1024.0;  // kB

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss);
}

class Fuzz : public testing::TestWithParam<Reader> {
 protected:
  /// The inputs themselves, and so many mutations of them.
  void run(long mutations, unsigned seed) {
    const std::vector<std::string> inputs = kInputs.at(GetParam().name)();
    ASSERT_FALSE(inputs.empty());
    const double start = thread_seconds();
    for (const std::string& input : inputs) read(input);
    std::mt19937 chance(seed);
    for (long i = 0; i < mutations && !HasFatalFailure(); ++i)
      read(mutated(inputs[chance() % inputs.size()], inputs, chance));
#ifndef TAUT_SANITIZED
    EXPECT_LT(peak_memory(), kMemory);
#endif
    rate_ = static_cast<double>(mutations) / (thread_seconds() - start);
  }

  double rate_ = 0;  // inputs per second of CPU time

 private:
  void read(const std::string& input) {
    const double start = thread_seconds();
    GetParam().read(input);
    ASSERT_LT(thread_seconds() - start, kPatience) << input;
  }
};
using LongFuzz = Fuzz;

TEST_P(Fuzz, OnlyMeantErrors) {
  run(2'000, 1);
}

/// TAUT_INPUTS and TAUT_SEED in the environment choose others.
TEST_P(LongFuzz, OnlyMeantErrors) {
  const auto chosen = [](const char* name, long fallback) {
    const char* text = std::getenv(name);
    return text ? std::atol(text) : fallback;
  };
  const long inputs = chosen("TAUT_INPUTS", 1'000'000);
  run(inputs, static_cast<unsigned>(chosen("TAUT_SEED", 2)));
  std::cout << GetParam().name << ": " << inputs << " inputs, " << std::lround(rate_)
            << " a second, peak " << std::lround(peak_memory() / 1000) << " MB\n";
}

std::string name_of(const testing::TestParamInfo<Reader>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Readers, Fuzz, testing::ValuesIn(readers()), name_of);
INSTANTIATE_TEST_SUITE_P(Long, LongFuzz, testing::ValuesIn(readers()), name_of);

}  // namespace
}  // namespace taut
