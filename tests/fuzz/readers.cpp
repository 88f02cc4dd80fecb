#include "tests/fuzz/readers.h"

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "render/chart/table.h"
#include "render/clip/clip_job.h"
#include "render/clip/compare_methods.h"
#include "render/film/frame_folder.h"
#include "render/golden/golden.h"
#include "render/golden/golden_trajectory.h"
#include "render/picture/picture.h"
#include "render/program/command.h"
#include "render/program/part.h"
#include "scenes/files/error.h"
#include "scenes/format/document.h"
#include "scenes/load/golden_suite.h"
#include "scenes/load/plan_file.h"
#include "scenes/model/formats.h"
#include "scenes/model/import.h"
#include "scenes/reader/reader.h"
#include "scenes/scene/scene.h"
#include "sim/motion/hash.h"
#include "sim/run/simulation.h"

namespace taut {
namespace {

namespace fs = std::filesystem;

/// A folder of this process for what is read from files alone; in memory, where the system has
/// that.
const fs::path& folder() {
  static const struct Own {
    fs::path path = (fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                    ("taut_fuzz_" + std::to_string(getpid()));
    Own() { fs::create_directories(path); }
    ~Own() { fs::remove_all(path); }
  } own;
  return own.path;
}

fs::path written(const char* name, std::string_view bytes) {
  fs::path file = folder() / name;
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

/// What must hold of all that is read.
void require(bool holds) {
  if (!holds) std::abort();
}

void read_scene(std::string_view bytes) {
  try {
    scenes::read_scene(scenes::parse_document("fuzz.toml", bytes), false);
  } catch (const scenes::BadScene&) {
  }
}

void read_stage(std::string_view bytes) {
  try {
    scenes::read_scene(scenes::parse_document("fuzz.toml", bytes), true);
  } catch (const scenes::BadScene&) {
  }
}

/// The first line is a value of --set.
void read_set(std::string_view bytes) {
  const std::size_t key = bytes.find('='), end = std::min(bytes.find('\n'), bytes.size());
  if (key >= end) return;
  try {
    scenes::Document document = scenes::parse_document("fuzz.toml", bytes.substr(end));
    scenes::change(document, bytes.substr(0, key),
                   std::string(bytes.substr(key + 1, end - key - 1)));
    scenes::read_scene(std::move(document), false);
  } catch (const scenes::BadScene&) {
  }
}

/// A fault of the importer's is seen where it happens.
void read_model(const char* name, std::string_view bytes) {
  try {
    scenes::NamedFiles none;
    scenes::import_model(name, std::string(bytes), none);
  } catch (const scenes::BadAsset&) {
  }
}

void read_materials(std::string_view bytes) {
  try {
    scenes::NamedFiles none;
    const fs::path file = "fuzz.obj";
    scenes::ObjMaterials(file, none).add("fuzz.mtl", bytes);
  } catch (const scenes::BadAsset&) {
  }
}

/// Of few pixels: a picture that says it is large would take all the time.
void read_image(std::string_view bytes) {
  try {
    constexpr std::size_t kPixels = 1u << 14;
    require(scenes::decode_image(bytes, kPixels).pixels.size() <= 4 * kPixels);
  } catch (const std::runtime_error&) {
  }
}

template <typename Read>
void with_meant_errors(const Read& read) {
  try {
    read();
  } catch (const scenes::BadAsset&) {
  }
}

void read_suite(std::string_view bytes) {
  const fs::path file = fs::path(TAUT_SOURCE_DIR) / "tests/golden/fuzz/golden.toml";
  try {
    scenes::golden_suite_from(scenes::parse_document(file, bytes));
  } catch (const scenes::BadScene&) {
  }
}

/// The plan goes into the text, comes out as it went in, and the rest of the text stays.
void write_plan(std::string_view bytes) {
  scenes::Plan plan;
  plan.tolerance = "1mm";
  plan.method = {"direct", {{"tolerance", 1e-4}}};
  plan.particles = {{"rope", 7}};
  try {
    const std::string once = scenes::with_plan(bytes, plan);
    require(scenes::with_plan(once, plan) == once);
    scenes::parse_document("fuzz.toml", once);
  } catch (const scenes::BadScene&) {
  }
}

/// A list of frames, a picture's size or a tolerance.
void read_words(std::string_view bytes) {
  const std::string text(bytes);
  try {
    constexpr int kTotal = 1000;
    const auto frames = program::frame_list(text, kTotal);
    require(std::ranges::is_sorted(frames) && frames.front() >= 0 && frames.back() < kTotal);
  } catch (const program::Misuse&) {
  }
  try {
    const auto [width, height] = program::picture_size(text);
    require(width > 0 && height > 0);
  } catch (const program::Misuse&) {
  }
  const auto length = scenes::read_length(text);
  require(!length || length->number > 0);
}

/// The stamp is that of the inputs.
void read_journal(std::string_view bytes) {
  with_meant_errors([&] {
    constexpr std::uint64_t kStamp = 0x0123456789abcdef;
    const program::Journal journal({written("journal", bytes)}, kStamp);
    require(journal.kept() == 0 || bytes.starts_with("taut study 0123456789abcdef\n"));
  });
}

void read_frames(std::string_view bytes) {
  written("journal", bytes);
  require(film::FrameFolder::whole_frames(folder(), {4, 4}).empty());
}

void read_record(std::string_view bytes) {
  clips::frames_made(std::string(bytes));
}

void read_times(std::string_view bytes) {
  try {
    clips::cpu_times(written("compare.json", bytes));
  } catch (const program::Misuse&) {
  }
}

void read_table(std::string_view bytes) {
  try {
    const chart::Table table = chart::from_csv(std::string(bytes));
    chart::to_text(table, 80);
    chart::to_html(table);
  } catch (const std::invalid_argument&) {
  }
}

constexpr const char* kSavedScene = R"(duration = 0.4
cuts = [{ connector = "rope", at = 0.25, t = 0.2 }]
pins = [{ connector = "cord", at = 0.5, from = 0.05, until = 0.3 }]
[bodies.ball]
mass = 1.0
shape = { sphere = { diameter = 0.1 } }
hangs = [0, -1, 0]
[connectors.rope]
length = 0.5
mass = 0.1
particles = 6
from = { fixed = [0, 0, 0] }
to = { body = "ball", point = [0, 0.05, 0] }
[connectors.cord]
length = 1.0
mass = 0.1
particles = 5
from = { fixed = [1, 0, 0] }
to = { point_mass = 0.2 }
start = { direction = [1, 0, 0] }
)";

Simulation saved_scene() {
  scenes::Scene scene = scenes::read_scene(scenes::parse_document("fuzz.toml", kSavedScene), false);
  return {scene.world, make_method("impulse", {{"step", 0.005}}), scene.timeline};
}

/// Of the bytes but their sum, which is made anew. A method can step what is loaded.
void read_state(std::string_view bytes) {
  std::uint64_t sum = 0;
  bytes = bytes.substr(0, bytes.size() - std::min(bytes.size(), sizeof sum));
  sum = Hash().bytes(bytes.data(), bytes.size()).value();
  std::string whole(bytes);
  whole.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  static Simulation simulation = saved_scene();
  try {
    simulation.load(whole);
    World world = simulation.world();
    make_method("impulse", {{"step", 0.005}})->advance(world, world.time + 0.01);
  } catch (const BadState&) {
  } catch (const Diverged&) {
  }
}

constexpr Reader kReaders[] = {
    {"Scene", read_scene},
    {"Stage", read_stage},
    {"Set", read_set},
    {"Glb", [](std::string_view bytes) { read_model("fuzz.glb", bytes); }},
    {"Gltf", [](std::string_view bytes) { read_model("fuzz.gltf", bytes); }},
    {"Obj", [](std::string_view bytes) { read_model("fuzz.obj", bytes); }},
    {"Bvh", [](std::string_view bytes) { read_model("fuzz.bvh", bytes); }},
    {"Materials", read_materials},
    {"Image", read_image},
    {"PathCsv",
     [](std::string_view bytes) {
       with_meant_errors([&] { scenes::path_from_csv(std::string(bytes), "fuzz.csv"); });
     }},
    {"GoldenRecord",
     [](std::string_view bytes) {
       with_meant_errors([&] { golden::golden_from(std::string(bytes), "f"); });
     }},
    {"GoldenTrajectory",
     [](std::string_view bytes) {
       with_meant_errors([&] { golden::trajectory_from(std::string(bytes), "f"); });
     }},
    {"GoldenSuite", read_suite},
    {"Plan", write_plan},
    {"Png",
     [](std::string_view bytes) {
       with_meant_errors([&] {
         picture::decode_png({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
       });
     }},
    {"Words", read_words},
    {"Journal", read_journal},
    {"Frames", read_frames},
    {"Record", read_record},
    {"Times", read_times},
    {"State", read_state},
    {"Table", read_table}};

}  // namespace

std::vector<std::string> saved_states() {
  std::vector<std::string> states;
  Simulation simulation = saved_scene();
  for (const double time : {0.0, 0.1, 0.25, 0.35}) {
    simulation.advance_to(time);
    states.push_back(simulation.save());
  }
  return states;
}

std::span<const Reader> readers() {
  return kReaders;
}

const Reader* find_reader(std::string_view name) {
  const auto* found = std::ranges::find(kReaders, name, &Reader::name);
  return found == std::end(kReaders) ? nullptr : found;
}

}  // namespace taut
