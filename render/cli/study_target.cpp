#include "render/cli/study_target.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "render/cli/command.h"
#include "render/lighting.h"

namespace taut::cli {

Target target_of(const Scene& scene, double duration, const TruthOptions& options) {
  Target target{{scene.world, frame_times(duration, scene.fps), scene.timeline}, {}};
  Truth truth = solve_truth(scene.world, target.problem.times, options, scene.timeline);
  target.reference = {std::move(truth.frames), truth.horizon, truth.self_error};
  std::erase_if(target.problem.times, [&](double time) { return time > truth.horizon; });
  target.reference.frames.resize(target.problem.times.size());
  return target;
}

Target predictable_target(const Scene& scene, const TruthOptions& options) {
  Target target = target_of(scene, scene.duration, options);
  if (target.problem.times.size() < 2) {
    throw Misuse(fmt::format("{}: nothing is predictable: the horizon of the truth is {} s",
                             scene.file.string(), target.reference.horizon));
  }
  return target;
}

std::optional<Reference> quick_reference(const Problem& problem, double scored_error,
                                         double cpu_cap) {
  Run first = run(problem, {"truth", {{"local_error", 1e-9}}}, cpu_cap);
  const Run second = run(problem, {"multibody", {{"accuracy", 1e-5}}}, cpu_cap);
  const Distance metres = [](const Vec3& at, const Vec3& truth, double) {
    return (at - truth).norm();
  };
  Reference reference;
  const std::size_t both = std::min(first.frames.size(), second.frames.size());
  for (std::size_t k = 1; k < both; ++k) {
    const double apart = frame_error(second.frames[k], first.frames[k], metres);
    if (apart > scored_error / 100) break;
    reference.horizon = first.frames[k].time;
    reference.self_error = std::max(reference.self_error, apart);
  }
  if (!(reference.horizon > 0)) return std::nullopt;
  reference.frames = std::move(first.frames);
  return reference;
}

std::optional<Metric> pixels_of(const Scene& scene) {
  if (!scene.stage || scene.stage->camera.empty()) return std::nullopt;
  const Eigen::Vector2d half(scene.width / 2.0, scene.height / 2.0);
  const auto project = [stage = *scene.stage, half](const Vec3& point,
                                                    double time) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector4f at =
        camera_projection(camera_at(stage.camera, time), half.x() / half.y()) *
        point.cast<float>().homogeneous();
    if (!(at.w() > 0)) return std::nullopt;
    return half.cwiseProduct(at.head<2>().cast<double>() / at.w());
  };
  return Metric{"on the picture", "px", [project](const Vec3& at, const Vec3& truth, double time) {
                  const auto a = project(at, time), b = project(truth, time);
                  return a && b ? (*a - *b).norm() : std::numeric_limits<double>::infinity();
                }};
}

}  // namespace taut::cli
