#include "render/report/report_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "render/base/interrupt.h"
#include "render/base/version.h"
#include "render/chart/html_page.h"
#include "render/clip/clip_job.h"
#include "render/options/method_options.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "render/study/scoring.h"
#include "scenes/files/files.h"
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

std::vector<ErrorAt> errors_over_time(const study::Run& run, const truth::Reference& reference,
                                      double length) {
  const study::Metric metric = study::share_of_length(length);
  std::vector<ErrorAt> errors;
  const std::size_t both = std::min(run.frames.size(), reference.frames.size());
  for (std::size_t k = 0; k < both; ++k) {
    errors.push_back({reference.frames[k].time,
                      study::frame_error(run.frames[k], reference.frames[k], metric.distance)});
  }
  return errors;
}

nlohmann::ordered_json run_score(const scenes::Scene& scene, double share) {
  if (scene.world.connectors.empty()) {
    throw program::Misuse(fmt::format("{}: has no connector to score", scene.file.string()));
  }
  if (!scene.timeline.cuts.empty()) {
    throw program::Misuse(
        fmt::format("{}: has cuts, which --score does not follow", scene.file.string()));
  }
  const double length = studies::scored_length(scene);
  const studies::Target target = studies::scored_target(scene, share);
  const study::Run run =
      study::run(target.problem, scene.method, std::numeric_limits<double>::infinity());
  const truth::Reference& truth = target.reference;
  const bool diverged = run.end == study::Run::End::diverged;
  nlohmann::ordered_json json = {
      {"scene", scene.file.string()},
      {"method", scene.method.name},
      {"settings", options::settings_json(with_defaults(scene.method))},
      {"horizon_s", truth.horizon},
      {"self_error", truth.self_error / length},
      {"rms_error",
       program::number_or_null(study::rms_error(run.frames, truth.frames, truth.horizon,
                                                study::share_of_length(length).distance))},
      {"cpu_ms_per_simulated_s", 1e3 * run.cpu / target.problem.duration()},
      {"diverged_at_s", diverged ? program::Json(run.failed_at) : program::Json(nullptr)},
      {"errors", nlohmann::ordered_json::array()}};
  for (const ErrorAt& at : errors_over_time(run, truth, length)) {
    json["errors"].push_back({{"t_s", at.time}, {"error", program::number_or_null(at.error)}});
  }
  return json;
}

namespace {

constexpr std::size_t kMostPoints = 60;  // of a method's errors over time

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

/// The methods whose largest error over time is the least and the most, in a sentence.
std::string errors_finding(const std::vector<ReportErrors>& all) {
  struct Largest {
    std::string label;
    double error = 0;
  };
  std::vector<Largest> reached;
  for (const ReportErrors& one : all) {
    Largest largest{one.contender.label, 0};
    for (const ErrorAt& at : one.errors) largest.error = std::max(largest.error, at.error);
    if (std::isfinite(largest.error) && !one.errors.empty()) reached.push_back(largest);
  }
  if (reached.empty()) return "No method ran at its own settings";
  const auto [best, worst] = std::ranges::minmax(reached, {}, &Largest::error);
  std::string line =
      fmt::format("At its own settings {} stays within {} of the length of the truth", best.label,
                  options::percent(best.error));
  if (worst.error > best.error) {
    line += fmt::format(", {} is off by up to {}", worst.label, options::percent(worst.error));
  }
  return line;
}

chart::Chart errors_chart(const SceneReport& report) {
  const studies::AccuracyStudy& study = report.accuracy;
  chart::Chart chart;
  chart.title = errors_finding(report.errors);
  chart.subtitle = fmt::format(
      "{}: RMS over the particles of each frame, while the truth is "
      "predictable ({} s). Left out: errors above the length or below the truth's own.",
      study.title, options::rounded(study.horizon));
  chart::Panel panel;
  panel.x = {"time (s)", false};
  panel.y = {"RMS position error (share of the length)", true};
  panel.y.minimum = study.self_error;
  for (const ReportErrors& one : report.errors) {
    chart::Series series{one.contender.label, one.contender.style, true, true, false, {}};
    const std::string command =
        options::score_command({study.scene, study.set}, one.contender.candidate, study.share);
    const std::size_t every = 1 + one.errors.size() / kMostPoints;
    for (std::size_t k = 0; k < one.errors.size(); k += every) {
      const ErrorAt& at = one.errors[k];
      series.points.push_back({at.time, at.error <= 1 ? at.error : chart::kAuto, chart::kAuto,
                               chart::kAuto, chart::kAuto, chart::kAuto, command});
    }
    panel.series.push_back(std::move(series));
  }
  chart.panels = {std::move(panel)};
  return chart;
}

std::string clips_section(const std::vector<ReportClip>& clips) {
  std::string body =
      "<div class=\"clips\"><div class=\"bar\"><button type=\"button\" class=\"all\">play or pause "
      "all</button><button type=\"button\" class=\"all\">all from the start</button></div>"
      "<div class=\"grid\">\n";
  for (const ReportClip& clip : clips) {
    const std::string what =
        clip.file.empty()
            ? fmt::format("<p class=\"note\">{}</p>", chart::escape_html(clip.words))
            : fmt::format(
                  "<video controls loop muted playsinline preload=\"auto\" "
                  "aria-label=\"{}\" src=\"data:video/webm;base64,{}\"></video>",
                  chart::escape_html(clip.method), base64(scenes::read_bytes(clip.file)));
    body += fmt::format("<figure>{}<figcaption>{}</figcaption>{}</figure>\n", what,
                        chart::escape_html(clip.method), chart::html_command(clip.command));
  }
  return body + "</div></div>\n";
}

std::string section(const std::string& id, const char* heading, const std::string& body) {
  return fmt::format("<section><h2 id=\"{}\">{}</h2>\n{}</section>\n", id, heading, body);
}

/// The scene's picture and what its measurements come to.
std::string beginning(const SceneReport& report) {
  std::string text;
  if (!report.picture.empty()) {
    text = fmt::format(
        "<figure class=\"picture\"><img alt=\"{}\" src=\"data:image/webp;base64,{}\"></figure>\n",
        chart::escape_html(report.accuracy.title), base64(scenes::read_bytes(report.picture)));
  }
  text +=
      fmt::format("<p><b>{}.</b>", chart::escape_html(studies::accuracy_finding(report.accuracy)));
  if (!report.stability.maps.empty()) {
    text += fmt::format(" In the maps of stability {}.",
                        chart::escape_html(studies::stability_finding(report.stability)));
  }
  return text + "</p>\n";
}

/// As in 2026-11-30.
std::string today() {
  const std::chrono::year_month_day day{
      std::chrono::floor<std::chrono::days>(std::chrono::system_clock::now())};
  return fmt::format("{:04}-{:02}-{:02}", int(day.year()), unsigned(day.month()),
                     unsigned(day.day()));
}

}  // namespace

std::string report_page(const std::vector<SceneReport>& scenes) {
  std::string body;
  if (scenes.size() == 1) body += beginning(scenes.front());
  body += fmt::format(
      "<p class=\"note\">{}, taut {}. {}.</p>\n"
      "<p>Points of charts, cells of maps and clips say the command that makes them: choose one, "
      "and copy it. Series hide by their names; a rectangle drawn into a chart enlarges it.</p>\n",
      today(), render::version(), chart::escape_html(options::machine()));
  std::string titles;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const SceneReport& report = scenes[i];
    const studies::AccuracyStudy& study = report.accuracy;
    const auto id = [&](const char* name) { return fmt::format("{}-{}", name, i + 1); };
    titles += (titles.empty() ? "" : ", ") + study.title;
    if (scenes.size() > 1) {
      body += fmt::format("<h1>{}</h1>\n{}", chart::escape_html(study.title), beginning(report));
    }
    body += fmt::format("<p>Scene: {}</p>\n<nav>", chart::escape_html(study.scene));
    for (const auto& [name, words] : {std::pair{"accuracy", "Speed against accuracy"},
                                      {"errors", "Errors over time"},
                                      {"clips", "Clips"},
                                      {"stability", "Stability"}}) {
      body += fmt::format("<a href=\"#{}\">{}</a>", id(name), words);
    }
    body += "</nav>\n";
    body += section(id("accuracy"), "Speed against accuracy", studies::accuracy_section(study));
    body += section(id("errors"), "Errors over time", chart::html_chart(errors_chart(report)));
    body += section(id("clips"), "Clips", clips_section(report.clips));
    body += section(id("stability"), "Stability",
                    report.stability.maps.empty()
                        ? "<p>The scene has pins, which maps do not follow.</p>\n"
                        : studies::stability_section(report.stability));
  }
  return chart::html_page(titles + ": report", body);
}

}  // namespace taut::report
