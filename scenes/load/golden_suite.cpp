#include "scenes/load/golden_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "scenes/format/format.h"
#include "scenes/load/load_scene.h"
#include "scenes/reader/reader.h"
#include "sim/run/error_estimate.h"
#include "sim/run/method.h"

namespace taut::scenes {

namespace {

using Type = KeyFormat::Type;

// Rounding moves a swing by less than this from one processor to another; slack motion by more.
constexpr double kLeastTolerance = 1e-6;  // m

/// How far (m) two right runs of a method may be from each other: each is off by its tolerance at
/// most, if the method has one in metres.
double distance_between_runs(const MethodChoice& choice) {
  const MethodInfo* method = find_method(choice.name);
  if (!method->companion || !method->missing.empty()) return kLeastTolerance;
  const Settings settings = with_defaults(*method, choice.settings);
  return std::max(kLeastTolerance, 2 * method->companion(*method, settings).asked);
}

/// A table that names a scene, a time by the key `time`, a method and a distance.
TableFormat kept_format(std::string_view scene, std::string_view time, std::string_view when) {
  return {
      {{.name = "scene", .type = Type::file, .meaning = scene, .required = true},
       {.name = time, .meaning = when, .unit = "s", .minimum = 0, .required = true},
       {.name = "method", .type = Type::method, .meaning = "The method; default: the scene's own."},
       {.name = "within",
        .meaning = "Largest distance of today's simulation from a kept state; default: twice the "
                   "method's tolerance, or 1e-6 without one.",
        .unit = "m",
        .minimum = 0,
        .above = true}}};
}

const TableFormat& suite_format() {
  static const TableFormat frame = kept_format(
      "A scene with a stage.", "time", "Time of the picture, rounded to the nearest frame.");
  static const TableFormat trajectory =
      kept_format("A scene.", "until", "End of the trajectory, rounded to the nearest frame.");
  static const TableFormat format{
      {{.name = "schema_version",
        .meaning = "Version of this format.",
        .minimum = 1,
        .maximum = 1,
        .whole = true},
       {.name = "size",
        .type = Type::numbers,
        .meaning = "Width and height of the pictures.",
        .unit = "pixels",
        .minimum = 1,
        .maximum = 16384,
        .whole = true,
        .least = 2,
        .most = 2},
       {.name = "samples",
        .meaning = "Samples per pixel.",
        .minimum = 1,
        .maximum = 64,
        .whole = true},
       {.name = "frames", .type = Type::named, .meaning = "The pictures by name.", .table = &frame},
       {.name = "trajectories",
        .type = Type::named,
        .meaning = "The trajectories by name.",
        .table = &trajectory}}};
  return format;
}

/// The common part of a frame and a trajectory; `key` holds the time.
struct Kept {
  std::filesystem::path scene;
  int frame = 0;
  MethodChoice method;
  double within = 0;
};

/// Scenes by their files, each read once, however much of it is kept.
using Scenes = std::map<std::filesystem::path, Scene>;

Kept read_kept(const Document& document, const Value& value, std::string_view key, Scenes& scenes) {
  Kept kept;
  kept.scene = find_file(document, *value.find("scene"));
  if (!scenes.contains(kept.scene)) scenes.emplace(kept.scene, load_scene(kept.scene, false));
  const Scene& scene = scenes.at(kept.scene);
  const Value& time = *value.find(key);
  kept.frame = static_cast<int>(std::lround(time.number * scene.fps));
  if (kept.frame >= scene.frames())
    document.mismatch(time, fmt::format("a time before the scene's end, {} s", scene.duration));
  const Value* method = value.find("method");
  kept.method = method ? read_method(document, method, scene.fps, scene.duration) : scene.method;
  kept.within = number_or(value, "within", distance_between_runs(kept.method));
  return kept;
}

}  // namespace

GoldenSuite load_golden_suite(const std::filesystem::path& folder,
                              const std::vector<std::string>& only) {
  return golden_suite_from(read_document(folder / "golden.toml"), only);
}

GoldenSuite golden_suite_from(const Document& document, const std::vector<std::string>& only) {
  check_format(document, suite_format());
  GoldenSuite suite;
  suite.folder = document.file.parent_path();
  if (const Value* size = document.root.find("size")) {
    suite.width = static_cast<int>(size->children[0].number);
    suite.height = static_cast<int>(size->children[1].number);
  }
  suite.samples = static_cast<int>(number_or(document.root, "samples", suite.samples));
  const Value* frames = document.root.find("frames");
  const Value* trajectories = document.root.find("trajectories");
  if (!frames && !trajectories)
    document.fail(document.root, "expected one of: frames, trajectories");
  const auto is_wanted = [&](const Value& value) {
    return only.empty() || std::ranges::find(only, value.name) != only.end();
  };
  Scenes scenes;
  if (frames) {
    for (const Value& value : frames->children) {
      if (!is_wanted(value)) continue;
      Kept kept = read_kept(document, value, "time", scenes);
      suite.frames.push_back({value.name, std::move(kept.scene), kept.frame, std::move(kept.method),
                              kept.within,
                              fmt::format("{}:{}", document.file.string(), value.key_place.line)});
    }
  }
  if (trajectories) {
    for (const Value& value : trajectories->children) {
      if (!is_wanted(value)) continue;
      Kept kept = read_kept(document, value, "until", scenes);
      suite.trajectories.push_back(
          {value.name, std::move(kept.scene), kept.frame, std::move(kept.method), kept.within});
    }
  }
  return suite;
}

}  // namespace taut::scenes
