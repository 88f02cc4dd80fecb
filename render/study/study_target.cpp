#include "render/study/study_target.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <limits>
#include <vector>

#include "render/base/interrupt.h"
#include "render/draw/shading/lighting.h"
#include "render/program/command.h"
#include "render/program/output.h"
#include "sim/motion/stop.h"

namespace taut::studies {
namespace {

constexpr double kMostTruth = 600;  // s of CPU time, of each solution

void cut_at_horizon(Target& target) {
  std::erase_if(target.problem.times, [&](double time) { return time > target.reference.horizon; });
  target.reference.frames.resize(target.problem.times.size());
}

void check_predictable(const scenes::Scene& scene, const Target& target) {
  if (target.problem.times.size() >= 2) return;
  throw program::Misuse(fmt::format("{}: nothing is predictable: the horizon of the truth is {} s",
                                    scene.file.string(), target.reference.horizon));
}

}  // namespace

truth::Reference solved_truth(const scenes::Scene& scene, std::span<const double> times,
                              const truth::TruthOptions& options) {
  // Two solvers, the first of them three times: no more than so many frames.
  program::Progress progress("solving the truth", "frames", 4 * times.size(), true);
  std::uint64_t done = 0;
  truth::TruthOptions capped = options;
  capped.cpu_cap = std::min(options.cpu_cap, kMostTruth);
  const double start = thread_seconds();
  truth::Reference truth = truth::solve_truth(scene.world, times, capped, scene.timeline, [&] {
    render::stop_if_interrupted();
    progress.update(++done);
  });
  if (truth.frames.size() < times.size() && thread_seconds() - start > capped.cpu_cap) {
    program::note("{}: the truth is left out after {:.4g} s: more takes over {} s of CPU time\n",
                  scene.file.string(), truth.horizon, capped.cpu_cap);
  }
  return truth;
}

Target target_of(const scenes::Scene& scene, double duration, const truth::TruthOptions& options) {
  Target target{{scene.world, study::frame_times(duration, scene.fps), scene.timeline}, {}};
  target.reference = solved_truth(scene, target.problem.times, options);
  cut_at_horizon(target);
  return target;
}

Target predictable_target(const scenes::Scene& scene, const truth::TruthOptions& options) {
  Target target = target_of(scene, scene.duration, options);
  check_predictable(scene, target);
  return target;
}

Target stepped_target(const scenes::Scene& scene, double step, double scored_error) {
  Target target{{scene.world, study::frame_times(scene.duration, scene.fps), scene.timeline}, {}};
  const std::vector<double>& times = target.problem.times;
  program::Progress progress("solving the reference", "frames", 2 * times.size(), true);
  std::uint64_t done = 0;
  target.reference =
      truth::stepped_reference(scene.world, times, step, scored_error, scene.timeline, [&] {
        render::stop_if_interrupted();
        progress.update(++done);
      });
  cut_at_horizon(target);
  check_predictable(scene, target);
  return target;
}

std::optional<truth::Reference> quick_reference(const study::Problem& problem, double scored_error,
                                                double cpu_cap) {
  try {
    truth::Reference reference =
        truth::solve_truth(problem.world, problem.times, truth::quick_truth(scored_error, cpu_cap),
                           problem.timeline, render::stop_if_interrupted);
    if (reference.horizon > 0) return reference;
  } catch (const Diverged&) {
    // None.
  } catch (const BadIntervention&) {
    // None either.
  }
  return std::nullopt;
}

namespace {

/// Projects to the picture as each of the scene's cameras has it that shows the time: those of its
/// shots, or where none does the scene's own. Keeps the cameras of the last time.
class Projector {
 public:
  explicit Projector(const scenes::Scene& scene)
      : half_(scene.width / 2.0, scene.height / 2.0), camera_(scene.stage->camera) {
    for (const scenes::Shot& shot : scene.stage->shots) shots_.push_back(shot);
  }

  /// The largest distance (px) on any picture; infinite where one point is behind a camera.
  double distance(const Vec3& a, const Vec3& b, double time) {
    if (time != time_) look(time);
    double largest = 0;
    for (const Eigen::Matrix4d& camera : cameras_) {
      const Eigen::Vector4d p = camera * a.homogeneous(), q = camera * b.homogeneous();
      if (!(p.w() > 0 && q.w() > 0)) return std::numeric_limits<double>::infinity();
      const Eigen::Vector2d apart = p.head<2>() / p.w() - q.head<2>() / q.w();
      largest = std::max(largest, half_.cwiseProduct(apart).norm());
    }
    return largest;
  }

 private:
  void look(double time) {
    time_ = time;
    cameras_.clear();
    const auto add = [&](const std::vector<scenes::CameraKey>& keys) {
      cameras_.push_back(
          draw::camera_projection(scenes::camera_at(keys, time), half_.x() / half_.y())
              .cast<double>());
    };
    for (const scenes::Shot& shot : shots_) {
      if (shot.from <= time && time <= shot.until) add(shot.camera);
    }
    if (cameras_.empty()) add(camera_);
  }

  Eigen::Vector2d half_;  // px
  std::vector<scenes::CameraKey> camera_;
  std::vector<scenes::Shot> shots_;
  double time_ = std::numeric_limits<double>::quiet_NaN();  // s
  std::vector<Eigen::Matrix4d> cameras_;
};

}  // namespace

std::optional<study::Metric> pixels_of(const scenes::Scene& scene) {
  if (!scene.stage || scene.stage->camera.empty()) return std::nullopt;
  return study::Metric{
      "on the picture", "px",
      [projector = Projector(scene)](const Vec3& at, const Vec3& truth, double time) mutable {
        return projector.distance(at, truth, time);
      }};
}

}  // namespace taut::studies
