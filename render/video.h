// Videos from frames, through the FFmpeg program.
#pragma once

#include <chrono>
#include <filesystem>
#include <span>

#include "render/child.h"

namespace taut {

/// Throws EncoderFailed unless ffmpeg and ffprobe can be run: called before the work of a night.
void require_ffmpeg();

/// Makes an H.264 video (yuv420p, bt709, constant frame rate, faststart) of PNG frames that share
/// one even size, and confirms by ffprobe that it has as many frames as were given. `file` appears
/// only when it is whole. `threads` is fixed, as other numbers give other bits. An encoder that
/// does nothing for `patience` is given up. Throws EncoderFailed.
void encode_video(std::span<const std::filesystem::path> frames, int fps,
                  const std::filesystem::path& file, std::chrono::milliseconds patience = kPatience,
                  int threads = 2);

}  // namespace taut
