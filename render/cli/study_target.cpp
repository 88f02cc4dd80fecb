#include "render/cli/study_target.h"

#include <Eigen/Dense>
#include <limits>
#include <vector>

#include "render/lighting.h"

namespace taut::cli {

Target target_of(const Scene& scene, double duration, const TruthOptions& options) {
  Target target{{scene.world, frame_times(duration, scene.fps)}, {}};
  Truth truth = solve_truth(scene.world, target.problem.times, options);
  target.reference = {std::move(truth.frames), truth.horizon, truth.self_error};
  std::erase_if(target.problem.times, [&](double time) { return time > truth.horizon; });
  target.reference.frames.resize(target.problem.times.size());
  return target;
}

std::optional<Metric> pixels_of(const Scene& scene) {
  if (!scene.stage || scene.stage->camera.empty()) return std::nullopt;
  const Eigen::Vector2d half(scene.width / 2.0, scene.height / 2.0);
  const auto project = [stage = *scene.stage, half](const Vec3& point,
                                                    double time) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector4f at = camera_projection(camera_at(stage, time), half.x() / half.y()) *
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
