#include "render/report/report_clips.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/base/interrupt.h"
#include "render/clip/clip_job.h"
#include "render/options/reproduce.h"
#include "render/program/progress.h"
#include "sim/run/method.h"

namespace taut::report {
namespace {

constexpr int kQualities[] = {70, 45, 20, 0};  // the first whose clip is small enough

/// Of a clip: width in px, frames per second, and seconds.
struct ClipForm {
  int width = 320, fps = 15;
  double duration = 6;
};

clips::RenderOptions small_clip(const options::StudyOptions& options, const ClipForm& form) {
  clips::RenderOptions clip;
  clip.inputs.scenes = {options.scene};
  clip.scene = options.scene;
  clip.fps = form.fps;
  clip.samples = 4;
  clip.no_estimate = true;
  clip.method.set = options.inputs.set;
  return clip;
}

/// Frames of a clip, the last included.
struct FrameRange {
  std::ptrdiff_t first = 0, last = 0;
};

/// As many pixels high as the scene's picture asks for, both sides even. Returns the frames from
/// the first that no card covers.
FrameRange choose_size(clips::RenderOptions& clip, int width, const program::Common& common) {
  clips::RenderOptions whole = clip;
  whole.no_video = true;
  const clips::ClipJob job(whole, common);
  const double aspect = double(job.scene.height) / job.scene.width;
  clip.size = fmt::format("{}x{}", width, 2 * std::max(1l, std::lround(width * aspect / 2)));
  const auto open = std::ranges::find(job.clip, nullptr, &scenes::ClipFrame::card);
  return {open == job.clip.end() ? 0 : open - job.clip.begin(), std::ssize(job.clip) - 1};
}

std::string command_of(const clips::RenderOptions& clip) {
  std::string words = options::quoted(clip.scene);
  for (const std::string& set : clip.method.set) words += " --set " + options::quoted(set);
  return fmt::format(
      "taut render {} --method {} --size {} --fps {} --samples {} --frames {} "
      "--no-estimate --quality {} --out {} -o {}",
      words, clip.method.method, clip.size, clip.fps, clip.samples, *clip.frames,
      clip.output.quality, options::quoted(clip.out), options::quoted(clip.output.file));
}

/// Makes it smaller and smaller until it has at most so many bytes.
ReportClip made(clips::RenderOptions clip, std::size_t most, const program::Common& common) {
  ReportClip result{clip.method.method, "", {}, ""};
  try {
    for (const int quality : kQualities) {
      clip.output.quality = quality;
      result.command = command_of(clip);
      clips::draw_clip(clips::ClipJob(clip, common), common);
      if (std::filesystem::file_size(clip.output.file) > most) continue;
      result.file = clip.output.file;
      return result;
    }
    result.words = "larger than this page has room for";
  } catch (const Diverged& error) {
    result.words = error.what();
  } catch (const program::Misuse& error) {
    result.words = error.what();
  }
  return result;
}

}  // namespace

std::vector<ReportClip> report_clips(const options::StudyOptions& options,
                                     const std::vector<options::Contender>& contenders,
                                     const std::filesystem::path& folder, std::size_t most,
                                     const program::Common& common) {
  const ClipForm form = options.quick ? ClipForm{240, 12, 3} : ClipForm{};
  const program::Common quiet{true, false, common.threads};
  clips::RenderOptions clip = small_clip(options, form);
  const FrameRange open = choose_size(clip, form.width, quiet);
  const auto most_frames = std::lround(form.fps * form.duration);
  clip.frames = fmt::format("{}-{}", open.first, std::min(open.first + most_frames - 1, open.last));
  std::vector<ReportClip> clips;
  program::Progress progress("rendering", "clips", contenders.size(), common.quiet);
  std::size_t done = 0;
  for (const options::Contender& contender : contenders) {
    render::stop_if_interrupted();
    progress.update(++done);
    if (!contender.candidate.settings.empty() || !contender.method->missing.empty()) continue;
    clip.method.method = contender.label;
    clip.out = (folder / "clips" / contender.label).string();
    clip.output.file = clip.out + ".webm";
    clips.push_back(made(clip, most, quiet));
  }
  return clips;
}

std::filesystem::path report_picture(const options::StudyOptions& options,
                                     const std::filesystem::path& folder,
                                     const program::Common& common) {
  const program::Common quiet{true, false, common.threads};
  const ClipForm form{options.quick ? 480 : 960, 0};
  clips::RenderOptions clip = small_clip(options, form);
  const FrameRange open = choose_size(clip, form.width, quiet);
  clip.frames = std::to_string((open.first + open.last) / 2);
  clip.out = (folder / "picture").string();
  clip.output.file = clip.out + ".webp";
  try {
    clips::draw_clip(clips::ClipJob(clip, quiet), quiet);
  } catch (const Diverged&) {
    return {};
  }
  return clip.output.file;
}

}  // namespace taut::report
