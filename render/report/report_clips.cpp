#include "render/report/report_clips.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/clip/clip_job.h"
#include "render/interrupt.h"
#include "render/options/reproduce.h"
#include "render/program/progress.h"
#include "sim/run/method.h"

namespace taut::cli {
namespace {

constexpr int kQualities[] = {70, 45, 20, 0};  // the first whose clip is small enough

/// Of a clip: width in px, frames per second, and seconds.
struct ClipForm {
  int width = 320, fps = 15;
  double duration = 6;
};

RenderOptions small_clip(const StudyOptions& options, const ClipForm& form) {
  RenderOptions clip;
  clip.inputs.scenes = {options.scene};
  clip.scene = options.scene;
  clip.fps = form.fps;
  clip.samples = 4;
  clip.no_estimate = true;
  clip.method.set = options.inputs.set;
  return clip;
}

/// As many pixels high as the scene's picture asks for, both sides even; and the frames from the
/// first that no card covers.
void choose_frames(RenderOptions& clip, const ClipForm& form, const Common& common) {
  RenderOptions whole = clip;
  whole.no_video = true;
  const ClipJob job(whole, common);
  const double aspect = double(job.scene.height) / job.scene.width;
  clip.size =
      fmt::format("{}x{}", form.width, 2 * std::max(1l, std::lround(form.width * aspect / 2)));
  const auto open = std::ranges::find(job.clip, nullptr, &ClipFrame::card);
  const auto first = open == job.clip.end() ? 0 : open - job.clip.begin();
  const auto last = std::min<std::ptrdiff_t>(first + std::lround(form.fps * form.duration),
                                             std::ssize(job.clip)) -
                    1;
  clip.frames = fmt::format("{}-{}", first, last);
}

std::string command_of(const RenderOptions& clip) {
  std::string words = quoted(clip.scene);
  for (const std::string& set : clip.method.set) words += " --set " + quoted(set);
  return fmt::format(
      "taut render {} --method {} --size {} --fps {} --samples {} --frames {} "
      "--no-estimate --quality {} --out {} -o {}",
      words, clip.method.method, clip.size, clip.fps, clip.samples, *clip.frames,
      clip.output.quality, quoted(clip.out), quoted(clip.output.file));
}

/// Makes it smaller and smaller until it has at most so many bytes.
ReportClip made(RenderOptions clip, std::size_t most, const Common& common) {
  ReportClip result{clip.method.method, "", {}, ""};
  try {
    for (const int quality : kQualities) {
      clip.output.quality = quality;
      result.command = command_of(clip);
      draw_clip(ClipJob(clip, common), common);
      if (std::filesystem::file_size(clip.output.file) > most) continue;
      result.file = clip.output.file;
      return result;
    }
    result.words = "larger than this page has room for";
  } catch (const Diverged& error) {
    result.words = error.what();
  } catch (const Misuse& error) {
    result.words = error.what();
  }
  return result;
}

}  // namespace

std::vector<ReportClip> report_clips(const StudyOptions& options,
                                     const std::vector<Contender>& contenders,
                                     const std::filesystem::path& folder, std::size_t most,
                                     const Common& common) {
  const ClipForm form = options.quick ? ClipForm{240, 12, 3} : ClipForm{};
  const Common quiet{true, false, common.threads};
  RenderOptions clip = small_clip(options, form);
  choose_frames(clip, form, quiet);
  std::vector<ReportClip> clips;
  Progress progress("rendering", "clips", contenders.size(), common.quiet);
  std::size_t done = 0;
  for (const Contender& contender : contenders) {
    stop_if_interrupted();
    progress.update(++done);
    if (!contender.candidate.settings.empty() || !contender.method->missing.empty()) continue;
    clip.method.method = contender.label;
    clip.out = (folder / "clips" / contender.label).string();
    clip.output.file = clip.out + ".webm";
    clips.push_back(made(clip, most, quiet));
  }
  return clips;
}

}  // namespace taut::cli
