// The form of a clip's output: kind of file, quality, opacity, and the file's own description.
#pragma once

#include <filesystem>
#include <string>

#include "render/film/video.h"
#include "render/picture/picture.h"
#include "render/program/command.h"
#include "scenes/scene/clip.h"

namespace taut::options {

struct OutputOptions {
  std::string file;  // empty: an .mp4 in the clip's folder
  std::string preset;
  int quality = 85;
  bool transparent = false, watch = false, preview = false;

  /// True for a single picture.
  bool is_picture() const;
};

void add_output_options(program::Command& command, OutputOptions& options);

/// Throws Misuse where the file's ending is none that can be written or cannot be transparent, or
/// several scenes would share a file.
void check_outputs(const OutputOptions& options, bool several, bool frames_alone);

/// The size (px, even) and the samples that a preset or a preview stands for, of a scene's picture.
struct Preset {
  int width, height, samples;
};
Preset preset_of(const OutputOptions& options, int width, int height, int samples);

/// Everything that a run's pictures have in common: program, scene, method.
class Provenance {
 public:
  Provenance(const scenes::Scene& scene, const std::string& file);

  /// Of a picture at that time of the scene (s).
  picture::PngExtras picture(double time, bool opacity) const;
  std::vector<std::pair<std::string, std::string>> video() const;
  /// All of it in one text.
  std::string text() const;

 private:
  std::string title_, scene_, method_;
};

}  // namespace taut::options
