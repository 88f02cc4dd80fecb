#include "render/video.h"

#include <fmt/format.h>

#include <cstdlib>
#include <system_error>

#include "render/error.h"
#include "render/part_file.h"

namespace taut {
namespace {

/// The last lines that a program wrote to its standard error.
std::string complaint_of(const ChildResult& result) {
  const std::size_t kept = std::min<std::size_t>(result.errors.size(), 1500);
  return fmt::format("status {}\n{}", result.status,
                     result.errors.substr(result.errors.size() - kept));
}

ChildResult run(const std::vector<std::string>& arguments, const std::string& input,
                std::chrono::milliseconds patience = kPatience) {
  ChildResult result;
  try {
    result = run_child(arguments, input, patience);
  } catch (const std::system_error& error) {
    throw EncoderFailed(fmt::format("{} (is FFmpeg installed?)", error.what()));
  }
  if (result.status != 0)
    throw EncoderFailed(fmt::format("{} failed: {}", arguments[0], complaint_of(result)));
  return result;
}

/// A path as FFmpeg's list of files wants it, in single quotes.
std::string quoted(const std::filesystem::path& file) {
  std::string text = "'file:";
  for (const char c : std::filesystem::absolute(file).string())
    text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

void require_ffmpeg() {
  run({"ffmpeg", "-hide_banner", "-version"}, "");
  run({"ffprobe", "-hide_banner", "-version"}, "");
}

void encode_video(std::span<const std::filesystem::path> frames, int fps,
                  const std::filesystem::path& file, std::chrono::milliseconds patience,
                  int threads) {
  std::string list = "ffconcat version 1.0\n";
  for (const auto& frame : frames) list += fmt::format("file {}\n", quoted(frame));
  PartFile part(file);

  // Without an explicit matrix FFmpeg converts by BT.601 and shifts the colours.
  run({"ffmpeg",
       "-hide_banner",
       "-loglevel",
       "error",
       "-y",
       "-protocol_whitelist",
       "file,pipe",
       "-f",
       "concat",
       "-safe",
       "0",
       "-r",
       fmt::to_string(fps),
       "-i",
       "pipe:0",
       "-vf",
       "scale=out_color_matrix=bt709:out_range=tv,format=yuv420p",
       "-r",
       fmt::to_string(fps),
       "-fps_mode",
       "cfr",
       "-c:v",
       "libx264",
       "-preset",
       "veryfast",
       "-crf",
       "17",
       "-threads",
       fmt::to_string(threads),
       "-colorspace",
       "bt709",
       "-color_primaries",
       "bt709",
       "-color_trc",
       "bt709",
       "-color_range",
       "tv",
       "-movflags",
       "+faststart",
       "-map_metadata",
       "-1",
       "-fflags",
       "+bitexact",
       "-f",
       "mp4",
       part.path().string()},
      list, patience);

  std::error_code missing;
  if (const auto size = std::filesystem::file_size(part.path(), missing); missing || size == 0)
    throw EncoderFailed(fmt::format("{}: ffmpeg ended well without making it", file.string()));
  const ChildResult probe = run(
      {"ffprobe", "-v", "error", "-select_streams", "v:0", "-count_frames", "-show_entries",
       "stream=nb_read_frames", "-of", "default=nokey=1:noprint_wrappers=1", part.path().string()},
      "", patience);
  if (probe.output != fmt::format("{}\n", frames.size()))
    throw EncoderFailed(fmt::format("{}: ffmpeg made {} frames instead of {}", file.string(),
                                    std::atoi(probe.output.c_str()), frames.size()));
  part.commit();
}

}  // namespace taut
