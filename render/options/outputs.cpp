#include "render/options/outputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "render/base/version.h"
#include "render/options/method_options.h"
#include "render/program/command.h"

namespace taut::options {
namespace {

constexpr std::string_view kPicture = ".png";

std::string ending_of(const std::string& file) {
  return std::filesystem::path(file).extension().string();
}

/// The nearest even number of pixels, of a side that follows another.
int even(double side) {
  return std::max(2, 2 * static_cast<int>(std::lround(side / 2)));
}

}  // namespace

bool OutputOptions::is_picture() const {
  return ending_of(file) == kPicture;
}

void add_output_options(program::Command& command, OutputOptions& options) {
  command
      .add_option("-o,--output", options.file,
                  "Output file: .mp4, .webm, .mov (ProRes 4444), .gif, .webp or .apng; .png is one "
                  "picture, of the clip's middle or of --poster")
      .type_name("FILE");
  command.add_option("--quality", options.quality, "Quality of the video, 0 to 100; default 85")
      .range(0, 100);
  command.add_flag(
      "--transparent", options.transparent,
      "Transparent instead of background and scenery: frames, .png, .webm, .mov, .webp, .apng");
  command
      .add_option("--preset", options.preset,
                  "draft: 640 pixels wide, 1 sample per pixel; final: the scene's size, 8 samples, "
                  "in several passes if the driver has fewer; 4k: 3840 wide")
      .one_of({"draft", "final", "4k"});
  command.add_flag("--preview", options.preview,
                   "Quick look: 480 pixels wide, 1 sharp sample per pixel, at most 24 frames a "
                   "second, no estimate, in a folder of its own, preview");
  command.add_flag(
      "--watch", options.watch,
      "Draw a poster whenever the scene or a file that it names is saved, until Ctrl-C");
}

void check_outputs(const OutputOptions& options, bool several, bool frames_alone) {
  const std::string ending = ending_of(options.file);
  if (!options.file.empty() && several) {
    throw program::Misuse(
        fmt::format("-o {}: one file for several scenes, expected --out FOLDER", options.file));
  }
  const auto known = film::video_endings();
  if (!options.file.empty() && ending != kPicture &&
      std::ranges::find(known, ending) == known.end()) {
    throw program::Misuse(fmt::format("-o {}: expected a name that ends with {} or {}",
                                      options.file, fmt::join(known, ", "), kPicture));
  }
  const bool opacity =
      options.file.empty() ? frames_alone : ending == kPicture || film::keeps_opacity(ending);
  if (options.transparent && !opacity) {
    throw program::Misuse(fmt::format(
        "--transparent: {} keeps no opacity; expected -o with .png, .webm, .mov, .webp or .apng, "
        "or --no-video",
        options.file.empty() ? "an .mp4" : options.file));
  }
}

Preset preset_of(const OutputOptions& options, int width, int height, int samples) {
  const double aspect = static_cast<double>(height) / width;
  if (options.preview) return {480, even(480 * aspect), 1};
  const std::string& name = options.preset;
  if (name == "draft") return {640, even(640 * aspect), 1};
  if (name == "final") return {width, height, 8};
  if (name == "4k") return {3840, even(3840 * aspect), samples};
  return {width, height, samples};
}

Provenance::Provenance(const scenes::Scene& scene, const std::string& file)
    : title_(scene.title),
      scene_(file),
      method_(
          fmt::format("{} ({})", scene.method.name, settings_text(with_defaults(scene.method)))) {}

picture::PngExtras Provenance::picture(double time, bool opacity) const {
  return {opacity,
          {{"Title", title_},
           {"Software", fmt::format("taut {}", render::version())},
           {"Source", scene_},
           {"taut:time", fmt::format("{:.6g} s", time)},
           {"taut:method", method_}}};
}

std::vector<std::pair<std::string, std::string>> Provenance::video() const {
  return {{"title", title_}, {"comment", text()}};
}

std::string Provenance::text() const {
  return fmt::format("taut {}, scene {}, method {}", render::version(), scene_, method_);
}

}  // namespace taut::options
