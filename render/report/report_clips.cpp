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

/// As many pixels high as the scene's picture asks for, both sides even; and the frames from the
/// first that no card covers.
void choose_frames(clips::RenderOptions& clip, const ClipForm& form,
                   const program::Common& common) {
  clips::RenderOptions whole = clip;
  whole.no_video = true;
  const clips::ClipJob job(whole, common);
  const double aspect = double(job.scene.height) / job.scene.width;
  clip.size =
      fmt::format("{}x{}", form.width, 2 * std::max(1l, std::lround(form.width * aspect / 2)));
  const auto open = std::ranges::find(job.clip, nullptr, &scenes::ClipFrame::card);
  const auto first = open == job.clip.end() ? 0 : open - job.clip.begin();
  const auto last = std::min<std::ptrdiff_t>(first + std::lround(form.fps * form.duration),
                                             std::ssize(job.clip)) -
                    1;
  clip.frames = fmt::format("{}-{}", first, last);
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
  choose_frames(clip, form, quiet);
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

}  // namespace taut::report
