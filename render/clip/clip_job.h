// A clip that `taut render` makes: its frames, their drawing and merging, single pictures of it,
// the costs of drawing.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "render/chart/table.h"
#include "render/draw/stage_renderer.h"
#include "render/draw/view.h"
#include "render/film/film.h"
#include "render/film/frame_folder.h"
#include "render/film/video.h"
#include "render/gl/context.h"
#include "render/gl/gpu.h"
#include "render/options/method_options.h"
#include "render/options/scene_options.h"
#include "render/picture/picture.h"
#include "render/program/command.h"
#include "render/program/part.h"
#include "render/study/scoring.h"
#include "scenes/scene/clip.h"

namespace taut::clips {

// The output of a clip: kind of file, quality, opacity, and the metadata in the file.

struct OutputOptions {
  std::string file;  // empty: an .mp4 in the clip's folder
  std::string preset;
  int quality = 85;
  bool transparent = false, watch = false, preview = false;

  /// True for a single picture.
  bool is_picture() const;
};

void add_output_options(program::Command& command, OutputOptions& options);

/// Throws Misuse if files of that ending cannot be written or cannot be transparent, or if several
/// scenes would share a file.
void check_outputs(const OutputOptions& options, bool several, bool frames_alone);

/// The size (px, even) and the samples of a preset or a preview.
struct Preset {
  int width, height, samples;
};
Preset preset_of(const OutputOptions& options, int width, int height, int samples);

/// The metadata of a run's pictures: program, scene, method.
class Provenance {
 public:
  Provenance(const scenes::Scene& scene, const std::string& file);

  /// For a picture at `time` of the scene (s).
  picture::PngExtras picture(double time, bool opacity) const;
  std::vector<std::pair<std::string, std::string>> video() const;
  /// All of it in one text.
  std::string text() const;

 private:
  std::string title_, scene_, method_;
};

// The costs of the stages of drawing a frame, as a table and as JSON.

/// The stages' medians, the share of the frames that went through each (scenery is drawn anew only
/// where the camera moved), and what they add up to in a mean frame.
chart::Table stage_table(const gl::Profile& profile, const gl::Profile& unlit,
                         const draw::StageFloor& floor, std::size_t drawn);
nlohmann::ordered_json stage_json(const gl::Profile& profile, const gl::Profile& unlit,
                                  const draw::StageFloor& floor);

// Single pictures of a clip: a contact sheet, a poster.

struct Stills {
  bool contact_sheet = false;
  std::optional<double> every;   // s of the clip between a sheet's pictures; else captions' middles
  std::optional<double> poster;  // s of the clip
  std::string poster_file;       // empty: poster.png
  bool transparent = false;      // the poster

  bool any() const { return contact_sheet || every || poster; }
};

/// Writes them into the folder `out`, the poster under its name where it has one, and returns their
/// names, one a line. Throws Misuse where the clip has nothing of the kind, and CannotWrite.
std::string make_stills(const Stills& stills, const scenes::Scene& scene, film::Film& film,
                        const std::filesystem::path& out, const Provenance& provenance);

inline constexpr const char* kParts = "frames";  // the name of a clip's parts
inline constexpr const char* kRecord =
    "clip.json";  // the report, in the clip's or the part's folder

struct RenderOptions {
  options::SceneOptions inputs;
  std::string scene;  // of the inputs, the one that is rendered now
  std::string out, size, backend = "auto";
  std::optional<std::string> frames;
  int fps = 0, samples = 0;  // 0: the preset's, or 4
  double patience = 60;      // s
  double max_memory = 0;
  bool certificate = false, resume = false, anew = false, no_video = false, profile = false;
  bool no_estimate = false;
  Stills stills;
  OutputOptions output;
  options::MethodOptions method;
  program::PartOptions part;
};

struct ClipJob {
  /// Throws Misuse, BadScene, and CannotWrite where the disk has no room for the frames.
  ClipJob(const RenderOptions& asked, const program::Common& common);
  ClipJob(const ClipJob&) = delete;
  ClipJob& operator=(const ClipJob&) = delete;

  film::FrameFolder::Size size() const { return {scene.width, scene.height}; }
  Provenance provenance() const { return {scene, options.scene}; }
  /// Of everything that all frames are made from, by the renderer of that description.
  std::uint64_t fingerprint(const std::string& renderer) const;

  RenderOptions options;  // with the samples and stills that they come to
  gl::Backend backend = gl::Backend::automatic;
  scenes::Scene scene;
  std::string proof;                    // of a plan
  bool video = true;                    // or frames alone
  std::vector<scenes::ClipFrame> clip;  // of the scene
  std::vector<int> frames;              // to make: the part's
  std::filesystem::path out;            // the clip's folder
  std::filesystem::path frame_path;     // the frames': the part's
};

/// Of a frame, from the fingerprint of all.
std::uint64_t frame_inputs(std::uint64_t job, const scenes::ClipFrame& frame,
                           const std::vector<draw::FrameState>& shutter);

/// The states that the frames show, one after another, and what simulating them took.
class ClipStates {
 public:
  /// `job` and `estimate` must outlive it.
  ClipStates(const ClipJob& job, studies::SelfEstimate& estimate);

  bool done() const { return simulation_.done(); }
  /// Unless done: the next frame's, by its index in the job's frames.
  scenes::ClipSimulation::Shutter next();
  /// s, so far.
  double time() const { return time_; }

 private:
  double estimate_time_ = 0;  // s
  scenes::ClipSimulation simulation_;
  double time_ = 0;
};

/// How the frames came about.
struct FramesMade {
  std::string renderer;
  std::size_t drawn = 0, drawn_again = 0;  // drawn_again: where others were in the way
  double exposures = 0;                    // of all that were drawn
  double simulating = 0;                   // s
  double drawing = 0;                      // s

  double mean_exposures() const { return drawn ? exposures / double(drawn) : 0; }
};

/// The same as the clip.json of a part tells it; nothing where it is cut short or tells it
/// otherwise.
std::optional<FramesMade> frames_made(const std::string& record);

/// The contents of clip.json, those on a video and a profile aside.
nlohmann::ordered_json clip_report(const ClipJob& job, const FramesMade& made);

/// Makes the video where there is to be one, and writes clip.json. Unless quiet, says what is
/// proved of the clip and how far it is to be trusted.
void finish_clip(const ClipJob& job, nlohmann::ordered_json& report,
                 const studies::SelfEstimate& estimate, const program::Common& common);
/// The report with --json, and else where the video or the frames are.
std::string result_text(const nlohmann::ordered_json& report, const program::Common& common);

/// The report, and with --profile what the stages take, as text.
struct DrawnClip {
  nlohmann::ordered_json report;
  std::string profile;
};
/// Draws the frames that are not there yet, and makes the video where there is to be one.
DrawnClip draw_clip(const ClipJob& job, const program::Common& common);

/// Puts the frames of all parts into the clip's folder and makes its video; draws none. Throws
/// Misuse where frames are missing.
int merge_clip(const ClipJob& job, const program::Common& common);

}  // namespace taut::clips
