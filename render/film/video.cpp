#include "render/film/video.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <string_view>
#include <system_error>

#include "render/base/atomic_file.h"
#include "render/base/error.h"
#include "sim/motion/printable.h"

namespace taut::film {
namespace {

/// The last lines that a program wrote to its standard error.
std::string complaint_of(const render::ChildResult& result) {
  const std::size_t kept = std::min<std::size_t>(result.errors.size(), 1500);
  return fmt::format("status {}\n{}", result.status,
                     printable_lines(result.errors.substr(result.errors.size() - kept)));
}

render::ChildResult run(const std::vector<std::string>& arguments, const std::string& input,
                        std::chrono::milliseconds patience,
                        const std::filesystem::path& folder = {}) {
  try {
    return render::run_child(arguments, input, {.patience = patience}, folder);
  } catch (const std::system_error& error) {
    throw render::EncoderFailed(fmt::format("{} (is FFmpeg installed?)", error.what()));
  }
}

void require_success(const char* program, const render::ChildResult& result) {
  if (result.status != 0)
    throw render::EncoderFailed(fmt::format("{} failed: {}", program, complaint_of(result)));
}

/// Throws CannotWrite where the disk is full: FFmpeg may say so, and passes over it at its last
/// write.
void refuse_full_disk(const render::PartFile& part, const std::filesystem::path& name,
                      const std::string& errors) {
  int cause = part.why_full();
  for (const int full : {ENOSPC, EDQUOT, EFBIG}) {
    if (cause == 0 && errors.find(std::strerror(full)) != std::string::npos) cause = full;
  }
  if (cause == 0) return;
  throw render::CannotWrite(
      fmt::format("{}: cannot be written: {}", name.string(), std::strerror(cause)));
}

/// Whether a child would find it, which without a PATH looks where the C library does.
bool is_in_path(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/bin:/usr/bin");
  for (std::string folder; std::getline(folders, folder, ':');)
    if (access((std::filesystem::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

/// A path as FFmpeg's list of files wants it, in single quotes.
std::string quoted(const std::filesystem::path& file) {
  std::string text = "'file:";
  for (const char c : file.string()) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// The name of a file that FFmpeg cannot take for an option or a protocol.
std::string file_name(const std::filesystem::path& file) {
  return "file:" + std::filesystem::absolute(file).string();
}

}  // namespace

void require_ffmpeg(std::chrono::milliseconds patience) {
  require_success("ffmpeg", run({"ffmpeg", "-hide_banner", "-version"}, "", patience));
  if (!is_in_path("ffprobe"))  // of the same package: to find it is enough
    throw render::EncoderFailed("cannot start ffprobe: not found (is FFmpeg installed?)");
}

namespace {

using Words = std::vector<std::string>;

/// From 0 to 100 to a codec's scale, `worst` to `best`.
int on_scale(int quality, double worst, double best) {
  return static_cast<int>(std::lround(worst + (best - worst) * quality / 100));
}

// Without an explicit matrix FFmpeg converts by BT.601 and shifts the colours.
constexpr const char* kVideoRange = "scale=out_color_matrix=bt709:out_range=tv";

Words bt709() {
  return {"-colorspace", "bt709", "-color_primaries", "bt709",
          "-color_trc",  "bt709", "-color_range",     "tv"};
}

Words joined(Words first, const Words& then) {
  first.insert(first.end(), then.begin(), then.end());
  return first;
}

Words mp4(const Encoding& e, int) {
  return joined({"-vf", std::string(kVideoRange) + ",format=yuv420p", "-c:v", "libx264", "-preset",
                 "veryfast", "-crf", fmt::to_string(on_scale(e.quality, 51, 11))},
                joined(bt709(), {"-movflags", "+faststart", "-f", "mp4"}));
}

Words webm(const Encoding& e, int) {
  const char* pixels = e.transparent ? "yuva420p" : "yuv420p";
  return joined({"-vf", fmt::format("{},format={}", kVideoRange, pixels), "-c:v", "libvpx-vp9",
                 "-deadline", "good", "-cpu-used", "4", "-b:v", "0", "-auto-alt-ref", "0", "-crf",
                 fmt::to_string(on_scale(e.quality, 63, 20))},
                joined(bt709(), {"-f", "webm"}));
}

Words mov(const Encoding& e, int) {
  const char* pixels = e.transparent ? "yuva444p10le" : "yuv444p10le";
  return joined({"-vf", fmt::format("{},format={}", kVideoRange, pixels), "-c:v", "prores_ks",
                 "-profile:v", "4444", "-vendor", "apl0", "-qscale:v",
                 fmt::to_string(std::max(on_scale(e.quality, 32, 1), 1))},
                joined(bt709(), {"-f", "mov"}));
}

/// Times of a GIF are hundredths of a second, and players take one of them for ten.
constexpr int kGifMost = 50;

Words gif(const Encoding& e, int fps) {
  const int colors = on_scale(e.quality, 16, 256);
  const std::string slower =
      fps > kGifMost ? fmt::format("fps={},", fps / ((fps + kGifMost - 1) / kGifMost)) : "";
  return {
      "-filter_complex",
      fmt::format("{}split[a][b];[a]palettegen=max_colors={}[p];[b][p]paletteuse", slower, colors),
      "-loop",
      "0",
      "-f",
      "gif"};
}

Words webp(const Encoding& e, int) {
  return {"-c:v",     "libwebp_anim",
          "-pix_fmt", e.transparent ? "bgra" : "yuv420p",
          "-quality", fmt::to_string(e.quality),
          "-loop",    "0",
          "-f",       "webp"};
}

Words apng(const Encoding& e, int) {
  return {"-c:v",   "apng", "-pix_fmt", e.transparent ? "rgba" : "rgb24",
          "-plays", "0",    "-f",       "apng"};
}

struct Format {
  std::string_view ending;
  Words (*words)(const Encoding& encoding, int fps);
  bool opacity, even_sides;
  bool counted;  // ffprobe can tell how many frames it has
};

constexpr Format kFormats[] = {
    {".mp4", mp4, false, true, true},    {".webm", webm, true, true, true},
    {".mov", mov, true, false, true},    {".gif", gif, false, false, false},
    {".webp", webp, true, false, false}, {".apng", apng, true, false, true}};

const Format* format_of(std::string_view ending) {
  const auto found = std::ranges::find(kFormats, ending, &Format::ending);
  return found == std::end(kFormats) ? nullptr : &*found;
}

}  // namespace

std::span<const std::string_view> video_endings() {
  static const auto endings = [] {
    std::array<std::string_view, std::size(kFormats)> list;
    std::ranges::transform(kFormats, list.begin(), &Format::ending);
    return list;
  }();
  return endings;
}

bool keeps_opacity(std::string_view ending) {
  const Format* format = format_of(ending);
  return format && format->opacity;
}

bool needs_even_sides(std::string_view ending) {
  const Format* format = format_of(ending);
  return format && format->even_sides;
}

void encode_video(std::span<const std::filesystem::path> frames, int fps,
                  const std::filesystem::path& file, std::chrono::milliseconds patience,
                  int threads) {
  encode_video(frames, fps, file, Encoding{}, patience, threads);
}

void encode_video(std::span<const std::filesystem::path> frames, int fps,
                  const std::filesystem::path& file, const Encoding& encoding,
                  std::chrono::milliseconds patience, int threads) {
  const Format* format = format_of(file.extension().string());
  if (!format) format = &kFormats[0];
  // FFmpeg runs in the folder of the frames: its list cannot carry every name of a folder.
  const std::filesystem::path folder =
      frames.empty() ? "" : std::filesystem::absolute(frames.front()).parent_path();
  std::string list = "ffconcat version 1.0\n";
  for (const auto& frame : frames) {
    const auto name = std::filesystem::absolute(frame).lexically_relative(folder);
    list += fmt::format("file {}\n", quoted(name));
  }
  render::PartFile part(file);

  const std::string rate = fmt::to_string(fps);
  Words words = {"ffmpeg",    "-hide_banner", "-loglevel", "error", "-y", "-protocol_whitelist",
                 "file,pipe", "-f",           "concat",    "-safe", "0",  "-r",
                 rate,        "-i",           "pipe:0"};
  words = joined(words, format->words(encoding, fps));
  if (format->ending != ".gif") words = joined(words, {"-r", rate, "-fps_mode", "cfr"});
  words = joined(words, {"-threads", fmt::to_string(threads), "-map_metadata", "-1"});
  for (const auto& [key, value] : encoding.tags)
    words = joined(words, {"-metadata", fmt::format("{}={}", key, value)});
  words = joined(words, {"-fflags", "+bitexact", file_name(part.path())});
  const render::ChildResult made = run(words, list, patience, folder);
  refuse_full_disk(part, file, made.errors);
  require_success("ffmpeg", made);
  std::error_code missing;
  if (const auto size = std::filesystem::file_size(part.path(), missing); missing || size == 0)
    throw render::EncoderFailed(
        fmt::format("{}: ffmpeg ended well without making it", file.string()));
  if (format->counted) {
    const render::ChildResult probe =
        run({"ffprobe", "-v", "error", "-select_streams", "v:0", "-count_frames", "-show_entries",
             "stream=nb_read_frames", "-of", "default=nokey=1:noprint_wrappers=1",
             file_name(part.path())},
            "", patience);
    require_success("ffprobe", probe);
    if (probe.output != fmt::format("{}\n", frames.size()))
      throw render::EncoderFailed(fmt::format("{}: ffmpeg made {} frames instead of {}",
                                              file.string(), std::atoi(probe.output.c_str()),
                                              frames.size()));
  }
  part.commit();
}

}  // namespace taut::film
