#include "render/options/needs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "render/base/error.h"
#include "render/film/render_workers.h"
#include "render/options/method_options.h"
#include "render/program/output.h"
#include "scenes/format/document.h"
#include "sim/run/islands.h"
#include "sim/run/simulation.h"
#include "sim/topology/components.h"

namespace taut::options {
namespace {

namespace fs = std::filesystem;

constexpr double kProgram = 2e7;      // bytes: libraries, the scene file as it was read
constexpr double kPart = 3e4;         // bytes
constexpr double kIsland = 1.5e4;     // bytes: its own world and method
constexpr double kStep = 1e-8;        // s, of a particle's step by the method of the least work
constexpr double kRoom = 700;         // bytes, for a particle: that of the error's estimate, too
constexpr double kPathKey = 500;      // bytes, of a key and the section behind it
constexpr double kColumn = 19;        // bytes of a number in a CSV, mostly
constexpr double kPixel = 4;          // bytes
constexpr double kPixelOnDisk = 0.5;  // bytes: of the frame as PNG, and of the video
constexpr double kDriver = 1e8;       // bytes: its libraries, and the models as they were read
constexpr double kContext = 8e7;      // bytes: shaders, shadow maps, models as they are drawn
constexpr double kVertex = 120;       // bytes: places, normals, triangles and what of them moves
constexpr double kAlike = 30;         // bytes, of one on a connector shaped as the one before
constexpr double kKeeping = 5e5;      // vertices; where more move, no backdrop is kept
constexpr double kPixelTime = 2e-7;   // s, of a picture by a software rasteriser
constexpr double kSkinTime = 4e-6;    // s, of a triangle of a character, which bends
constexpr double kFrame = 500;        // bytes: what is known of a frame beside its states
constexpr double kLong = 60;          // s

/// In two digits: no more is known of it.
std::string bytes_text(double bytes) {
  if (bytes >= 100) {
    const double digit = std::pow(10, std::floor(std::log10(bytes)) - 1);
    bytes = std::round(bytes / digit) * digit;
  }
  static constexpr const char* kUnits[] = {"B", "kB", "MB", "GB", "TB", "PB", "EB"};
  std::size_t unit = 0;
  for (; bytes >= 999.5 && unit + 1 < std::size(kUnits); ++unit) bytes /= 1000;
  return fmt::format("{:.3g} {}", bytes, kUnits[unit]);
}

double memory_needed(const scenes::Scene& scene) {
  double sum = memory_of(*find_method(scene.method.name), scene.world, with_defaults(scene.method));
  sum += kProgram;
  // The memory of each part that pins and cuts leave, and of the room made for all beforehand.
  const auto divisions = double(scene.timeline.pins.size() + scene.timeline.cuts.size());
  double particles = divisions;
  for (const Connector& connector : scene.world.connectors) {
    particles += double(connector.particles());
  }
  const std::vector<std::size_t> islands = island_numbers(scene.world, scene.timeline);
  if (!islands.empty()) sum += kIsland * double(std::ranges::max(islands));
  sum += kPart * divisions + kRoom * std::min(divisions * particles, kMostRoom);
  sum += 2.0 * double(scene.timeline.pins.size() * (sizeof(TimedPin) + sizeof(Hold)) +
                      scene.timeline.cuts.size() * (sizeof(TimedCut) + sizeof(Connector)));
  const auto add_path = [&](const Path* path) {
    if (path) sum += kPathKey * double(path->keys().size());
  };
  for (const Body& body : scene.world.bodies) add_path(body.path.get());
  for (const Connector& connector : scene.world.connectors) {
    for (const Hold& hold : connector.holds) add_path(hold.to.path.get());
  }
  return sum;
}

/// Numbers that a state shows.
double numbers_shown(const scenes::Scene& scene) {
  double numbers = 1 + 7.0 * double(scene.world.bodies.size());
  for (const Connector& connector : scene.world.connectors) {
    numbers += 3.0 * double(connector.particles());
  }
  return numbers;
}

/// All connectors as they are drawn.
struct Drawn {
  double vertices = 0;
  double memory = 0;  // bytes
};

Drawn drawn(const scenes::Scene& scene) {
  constexpr double kRing = 10, kRings = 120, kWeights = 1100, kLink = 128;
  Drawn sum;
  const Connector* before = nullptr;
  for (std::size_t i = 0; i < scene.world.connectors.size(); ++i) {
    const Connector& connector = scene.world.connectors[i];
    const auto& looks = scene.stage->connector_looks;
    const scenes::ConnectorLook look = i < looks.size() ? looks[i] : scenes::ConnectorLook();
    const double vertices =
        look.kind == scenes::ConnectorLook::Kind::chain
            ? kLink * (connector.length / look.diameter + 4)
            : kRing * std::max(kRings, double(connector.particles())) + kWeights;
    const bool alike = before && before->length == connector.length &&
                       before->particles() == connector.particles();
    sum.vertices += vertices;
    sum.memory += (alike ? kAlike : kVertex) * vertices;
    before = &connector;
  }
  return sum;
}

/// Whether a camera blurs what is out of focus.
bool has_lens(const scenes::Stage& stage) {
  const auto blurs = [](const scenes::CameraKey& key) { return key.relative_aperture > 0; };
  return std::ranges::any_of(stage.camera, blurs) ||
         std::ranges::any_of(stage.shots, [&](const scenes::Shot& shot) {
           return std::ranges::any_of(shot.camera, blurs);
         });
}

/// The machine's memory for this process, bytes.
double machine_memory() {
  double memory = double(sysconf(_SC_PHYS_PAGES)) * double(sysconf(_SC_PAGESIZE));
  for (const char* file :
       {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"}) {
    double limit = 0;
    if (std::ifstream(file) >> limit && limit > 0) memory = std::min(memory, limit);
  }
  return memory;
}

/// The room that is left where a file is to be made, in a folder that may be made, too.
double free_disk(fs::path folder) {
  std::error_code error;
  folder = fs::weakly_canonical(folder, error);
  while (!fs::exists(folder, error) && folder.has_relative_path()) folder = folder.parent_path();
  const fs::space_info space = fs::space(folder, error);
  return error ? INFINITY : double(space.available);
}

/// The setting that would save the method's memory; empty: none.
std::string cheaper(const scenes::Scene& scene) {
  const Settings settings = with_defaults(scene.method);
  const auto solver = settings.find("solver");
  return solver != settings.end() && solver->second == Setting(std::string("dense"))
             ? "solver = \"tridiagonal\", "
             : "";
}

}  // namespace

double steps_per_frame(const scenes::Scene& scene) {
  const double step = step_of(with_defaults(scene.method));
  return step > 0 ? double(step_count(1.0 / scene.fps, step)) : 0;
}

double clip_length(const scenes::Scene& scene) {
  const scenes::Stage& stage = *scene.stage;
  const auto frames = [&](double seconds) { return std::ceil(seconds * scene.fps * (1 - 1e-9)); };
  double sum = frames(stage.title.duration) + frames(stage.end.duration);
  for (const scenes::Shot& shot : stage.shots) sum += frames((shot.until - shot.from) / shot.rate);
  return sum;
}

Needs simulation_needs(const scenes::Scene& scene) {
  const double frames = std::ceil(scene.duration * scene.fps);
  const double row = kColumn * numbers_shown(scene);
  const double steps = frames * std::max(steps_per_frame(scene), 1.0);
  double particles = 4.0 * double(scene.world.bodies.size());
  for (const Connector& connector : scene.world.connectors) {
    particles += double(connector.particles());
  }
  return {memory_needed(scene) + 2 * row, frames * row, kStep * steps * particles};
}

Needs clip_needs(const scenes::Scene& scene, double frames, int samples, int threads) {
  const scenes::Stage& stage = *scene.stage;
  Needs needs = simulation_needs(scene);
  const double pixels = double(scene.width) * scene.height;
  // The states of a shutter are there twice for each thread that draws.
  const double states = stage.shutter > 0 ? stage.exposures : 1;
  needs.memory += 4 * states * sizeof(double) * numbers_shown(scene);
  needs.memory += kDriver + clip_length(scene) * (kFrame + sizeof(double) * states) +
                  frames * kFrame + 4 * kPixel * pixels;  // pictures on their way to the disk
  // Colour and depth of each sample as they are drawn, behind what moves, and before exposures.
  const Drawn connectors = drawn(scene);
  const double canvases = connectors.vertices < kKeeping ? 3 : 2;
  double canvas = (canvases * 8.0 * samples + 4 * kPixel) * pixels;
  if (!stage.scenery.empty()) canvas += 8 * pixels;           // its light
  if (has_lens(stage)) canvas += (8 * 4.0 / 3 + 2) * pixels;  // with mipmaps, and half as wide
  needs.memory += film::frames_at_once(threads) * (kContext + canvas + connectors.memory);
  needs.disk = frames * pixels * kPixelOnDisk;
  double skin = 0;  // triangles
  for (const auto& character : stage.characters)
    for (const scenes::Mesh& mesh : character->meshes) skin += double(mesh.indices.size()) / 3;
  needs.time += frames * (pixels * kPixelTime + skin * kSkinTime);
  return needs;
}

std::string time_text(double seconds) {
  constexpr double kMinute = 60, kHour = 3600, kDay = 86400, kYear = 365.25 * kDay;
  if (seconds < kMinute) return fmt::format("{:.2g} s", std::max(seconds, 1e-3));
  if (seconds < kHour) return fmt::format("{:.0f} min", seconds / kMinute);
  if (seconds < kDay) return fmt::format("{:.3g} h", seconds / kHour);
  if (seconds < kYear) return fmt::format("{:.3g} days", seconds / kDay);
  return fmt::format("{:.3g} years", seconds / kYear);
}

std::string space_text(const Needs& needs) {
  return fmt::format("about {} of memory, {} of disk", bytes_text(needs.memory),
                     bytes_text(needs.disk));
}

void add_memory_option(program::Command& command, double& most) {
  command.add_size("--max-memory", most,
                   "Memory limit, as in 8GB; default: three quarters of the machine's memory");
}

void refuse_beyond(const Needs& needs, const scenes::Scene& scene, double most,
                   const fs::path& folder, const std::string& fewer, bool quiet) {
  const double allowed = most > 0 ? most : 0.75 * machine_memory();
  if (needs.memory > allowed) {
    scenes::fail_at(
        scene.file, {},
        fmt::format(
            "would take about {} of memory by {}, expected at most {} (--max-memory); {}fewer "
            "particles or bodies, another method{} take less",
            bytes_text(needs.memory), scene.method.name, bytes_text(allowed), cheaper(scene),
            fewer));
  }
  if (!folder.empty()) {
    if (const double room = free_disk(folder); needs.disk > room) {
      throw render::CannotWrite(fmt::format(
          "{}: the output would take about {}, the disk has {} left; a shorter scene, fewer frames "
          "per second{} take less",
          folder.string(), bytes_text(needs.disk), bytes_text(room), fewer));
    }
  }
  if (!quiet && needs.time > kLong) {
    program::note("this will take {} or more\n", time_text(needs.time));
  }
}

}  // namespace taut::options
