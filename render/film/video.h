// Videos from frames, through the FFmpeg program.
#pragma once

#include <chrono>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/base/child.h"

namespace taut::film {

/// Throws EncoderFailed unless ffmpeg and ffprobe can be run: called before the work of a night. An
/// FFmpeg that does nothing for `patience` is given up.
void require_ffmpeg(std::chrono::milliseconds patience = render::kPatience);

/// How frames become a video.
struct Encoding {
  int quality = 85;          // 0 to 100; formats without loss take no notice
  bool transparent = false;  // the frames have opacity, and the format keeps it
  std::vector<std::pair<std::string, std::string>> tags = {};  // what the file says of itself
};

/// The endings that encode_video() knows, as in ".mp4".
std::span<const std::string_view> video_endings();
/// True for endings of formats that keep opacity.
bool keeps_opacity(std::string_view ending);
/// True for endings of formats whose pictures need even sides.
bool needs_even_sides(std::string_view ending);

/// Makes a video by the ending of `file`: .mp4 is described below, .webm VP9, .mov ProRes 4444,
/// .gif, .webp and .apng are animated pictures that go on for ever (a .gif of at most 50 frames a
/// second). Throws EncoderFailed, and CannotWrite where the disk is full.
void encode_video(std::span<const std::filesystem::path> frames, int fps,
                  const std::filesystem::path& file, const Encoding& encoding,
                  std::chrono::milliseconds patience = render::kPatience, int threads = 2);

/// Makes an H.264 video (yuv420p, bt709, constant frame rate, faststart) of PNG frames that share
/// one even size, and confirms by ffprobe that it has as many frames as were given. `file` appears
/// only when it is whole. `threads` is fixed, as other numbers give other bits. An encoder that
/// does nothing for `patience` is given up. Throws EncoderFailed, and CannotWrite where the disk is
/// full.
void encode_video(std::span<const std::filesystem::path> frames, int fps,
                  const std::filesystem::path& file,
                  std::chrono::milliseconds patience = render::kPatience, int threads = 2);

}  // namespace taut::film
