#include "render/clip/goldens.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "render/base/atomic_file.h"
#include "render/base/interrupt.h"
#include "render/film/film.h"
#include "render/program/command.h"
#include "scenes/files/error.h"
#include "scenes/load/default_stage.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::clips {
namespace {

namespace fs = std::filesystem;

Snapshot simulate(const scenes::Scene& scene, const scenes::GoldenFrame& frame) {
  Simulation simulation = scenes::start(scene, frame.method);
  for (int k = 1; k <= frame.frame; ++k) {
    render::stop_if_interrupted();
    simulation.advance_to(double(k) / scene.fps);
  }
  return simulation.state();
}

/// The largest distance (m) between like particles and poses; infinite if they are not of one
/// scene.
double distance(const draw::FrameState& a, const draw::FrameState& b) {
  double largest = golden::distance(a.state, b.state);
  if (a.bones.size() != b.bones.size()) return INFINITY;
  for (std::size_t c = 0; c < a.bones.size(); ++c) {
    if (a.bones[c].size() != b.bones[c].size()) return INFINITY;
    for (std::size_t i = 0; i < a.bones[c].size(); ++i)
      largest = std::max(largest, golden::distance(a.bones[c][i], b.bones[c][i]));
  }
  return largest;
}

}  // namespace

/// A scene that is ready to be drawn.
struct Goldens::Set {
  scenes::Scene scene;
  film::Film film;
  Set(const gl::Context& context, const scenes::GoldenSuite& suite,
      const scenes::GoldenFrame& frame)
      : scene(staged(frame)), film(context, scene, suite.width, suite.height, suite.samples) {}

  static scenes::Scene staged(const scenes::GoldenFrame& frame) {
    scenes::Scene scene = scenes::load_scene(frame.scene, true);
    scenes::settle_breaks(scene, frame.method);
    scenes::complete_stage(scene, {}, render::stop_if_interrupted);
    return scene;
  }
};

Goldens::Goldens(const fs::path& folder, const std::vector<std::string>& only, gl::Backend backend,
                 int threads)
    : suite_(scenes::load_golden_suite(folder, only)) {
  check_names(only);
  if (suite_.frames.empty()) return;
  context_.emplace(backend, threads);
  driver_ = golden::driver_of(context_->description());
}

Goldens::~Goldens() = default;

FrameResult Goldens::check(const scenes::GoldenFrame& frame) {
  FrameResult result;
  if (!is_kept(frame)) {
    result.failure = "nothing is kept of it yet; look at it, and accept it";
    return result;
  }
  golden::GoldenRecord record = golden::read_golden(file(frame, ".json"));
  Set& set = set_of(frame);
  const draw::FrameState today = set.film.instant(simulate(set.scene, frame));
  draw::FrameState kept = today;
  if (frame.frame > 0) {  // else it is the scene's own start
    kept.state = record.state;
    kept.bones = record.bones;
  }
  result.distance = distance(today, kept);
  if (std::isinf(result.distance)) {
    result.failure =
        "the scene has other particles, bodies or bones than the kept state; look at it, and "
        "accept it";
    return result;
  }
  picture::Picture golden = picture::read_png(file(frame, ".png"));
  if (golden.width != suite_.width || golden.height != suite_.height) {
    result.failure =
        fmt::format("is of {}x{} pixels and the suite of {}x{}; look at it, and accept it",
                    golden.width, golden.height, suite_.width, suite_.height);
    return result;
  }
  result.golden = std::move(golden);
  result.actual = set.film.draw(kept);
  result.comparison = golden::compare(*result.actual, driver_, *result.golden, record);
  const golden::PictureDifference& d = result.comparison.difference;
  if (!result.comparison.same)
    result.failure = fmt::format(
        "{:.3g}% of its pixels differ by more than 2, at most by {}, means by {:.2g}; "
        "{:.3g}% have nothing like them next to them (compared by: {})",
        100 * d.above_2, d.largest, d.mean_shift, 100 * d.near_above_8,
        golden::name_of(result.comparison.tier));
  if (!(result.distance <= frame.within))
    result.failure +=
        fmt::format("{}the simulation ends {:.3g} m from the kept state, {:.3g} m allowed",
                    result.failure.empty() ? "" : "; ", result.distance, frame.within);
  return result;
}

golden::TrajectoryComparison Goldens::check(const scenes::GoldenTrajectory& trajectory) {
  if (!fs::exists(file(trajectory))) return {.failure = "nothing is kept of it yet; accept it"};
  return golden::compare(golden::record_of(trajectory), golden::read_trajectory(file(trajectory)),
                         trajectory.within);
}

std::string Goldens::accept(const scenes::GoldenFrame& frame, bool simulate_anew) {
  Set& set = set_of(frame);
  golden::GoldenRecord record;
  std::optional<picture::Picture> before;
  if (is_kept(frame)) {
    record = golden::read_golden(file(frame, ".json"));
    before = picture::read_png(file(frame, ".png"));
  }
  draw::FrameState shown = set.film.instant(simulate(set.scene, frame));
  bool moved = false;
  if (frame.frame > 0) {
    draw::FrameState as_kept = shown;
    as_kept.state = record.state;
    as_kept.bones = record.bones;
    moved = !(distance(shown, as_kept) <= frame.within);
    if (!moved && !simulate_anew) shown = std::move(as_kept);
    record.state = shown.state;
    record.bones = shown.bones;
  }
  const picture::Picture picture = set.film.draw(shown);
  const bool same =
      before && !moved && before->width == picture.width && before->pixels == picture.pixels;
  // Its files stay as they are: written again, numbers may differ in their last digit.
  if (same && !simulate_anew && record.driver == driver_) return "as before";
  record.driver = driver_;
  write_picture(file(frame, ".png"), picture);
  write_text(file(frame, ".json"), golden::golden_text(record));
  return !before ? "new" : same ? "as before" : "changed";
}

std::string Goldens::accept(const scenes::GoldenTrajectory& trajectory, bool simulate_anew) {
  golden::TrajectoryRecord today = golden::record_of(trajectory);
  const bool kept = fs::exists(file(trajectory));
  bool moved = true;
  if (kept) {
    golden::TrajectoryRecord before = golden::read_trajectory(file(trajectory));
    moved = !golden::compare(today, before, trajectory.within).failure.empty();
    if (!moved && !simulate_anew) {
      if (before.made_from == today.made_from) return "as before";
      today.states = std::move(before.states);
    }
  }
  write_text(file(trajectory), golden::trajectory_text(today));
  return !kept ? "new" : moved ? "changed" : "as before";
}

void Goldens::check_names(const std::vector<std::string>& names) const {
  const auto named = [](const auto& all, const std::string& name) {
    return std::ranges::any_of(all, [&](const auto& one) { return one.name == name; });
  };
  for (const std::string& name : names)
    if (!named(suite_.frames, name) && !named(suite_.trajectories, name))
      throw program::Misuse(
          fmt::format("--only {}: {} names nothing so", name, suite_.folder.string()));
}

bool Goldens::is_kept(const scenes::GoldenFrame& frame) const {
  return fs::exists(file(frame, ".json")) && fs::exists(file(frame, ".png"));
}

fs::path Goldens::file(const scenes::GoldenFrame& frame, const char* extension) const {
  return suite_.folder / (frame.name + extension);
}

fs::path Goldens::file(const scenes::GoldenTrajectory& trajectory) const {
  return suite_.folder / (trajectory.name + ".trajectory.json");
}

/// The scene of a frame; frames that follow each other share it.
Goldens::Set& Goldens::set_of(const scenes::GoldenFrame& frame) {
  if (!set_ || set_->scene.file != frame.scene) {
    set_.reset();
    set_ = std::make_unique<Set>(*context_, suite_, frame);
  }
  return *set_;
}

void write_picture(const fs::path& name, const picture::Picture& picture) {
  const auto bytes = picture::encode_png(picture);
  write_text(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

void write_text(const fs::path& name, std::string_view text) {
  render::AtomicFile file(name);
  file.write(text);
  file.commit();
}

}  // namespace taut::clips
