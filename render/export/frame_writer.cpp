#include "render/export/frame_writer.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "scenes/scene/clip.h"
#include "sim/run/method.h"
#include "sim/run/simulation.h"

namespace taut::exporting {

void LinearKeys::add(Snapshot state, bool is_frame,
                     const std::function<void(const Snapshot&)>& key) {
  pending_.push_back(std::move(state));
  if (!is_frame) return;
  if (pending_.size() == 1) return key(pending_.front());
  divide(0, pending_.size() - 1, key);
  pending_.erase(pending_.begin(), pending_.end() - 1);
}

double LinearKeys::off(const Snapshot& from, const Snapshot& to, const Snapshot& state) const {
  const double u = (state.time - from.time) / (to.time - from.time);
  double most = 0;
  const auto point = [&](const Vec3& a, const Vec3& b, const Vec3& at) {
    most = std::max(most, ((1 - u) * a + u * b - at).norm());
  };
  for (std::size_t c = 0; c < state.connectors.size(); ++c)
    for (std::size_t i = 0; i < state.connectors[c].size(); ++i)
      point(from.connectors[c][i], to.connectors[c][i], state.connectors[c][i]);
  for (std::size_t b = 0; b < state.bodies.size(); ++b) {
    point(from.bodies[b].position, to.bodies[b].position, state.bodies[b].position);
    const Quat turn = from.bodies[b].rotation.slerp(u, to.bodies[b].rotation);
    most = std::max(most, turn.angularDistance(state.bodies[b].rotation) * radii_[b]);
  }
  return most;
}

void LinearKeys::divide(std::size_t from, std::size_t to,
                        const std::function<void(const Snapshot&)>& key) {
  double largest = 0;
  std::size_t worst = from;
  for (std::size_t i = from + 1; i < to; ++i)
    if (const double distance = off(pending_[from], pending_[to], pending_[i]);
        distance > largest) {
      largest = distance;
      worst = i;
    }
  if (largest > kLimit) {
    divide(from, worst, key);
    return divide(worst, to, key);
  }
  error_ = std::max(error_, largest);
  key(pending_[to]);
}

namespace {

bool same(const std::vector<scenes::CameraKey>& a, const std::vector<scenes::CameraKey>& b) {
  return std::ranges::equal(a, b, [](const scenes::CameraKey& x, const scenes::CameraKey& y) {
    return x.time == y.time && x.position == y.position && x.target == y.target &&
           x.field_of_view == y.field_of_view && x.relative_aperture == y.relative_aperture &&
           x.focus == y.focus && x.orbit == y.orbit;
  });
}

}  // namespace

std::vector<std::shared_ptr<const scenes::Model>> body_models(const scenes::Scene& scene) {
  std::vector<std::shared_ptr<const scenes::Model>> models;
  if (scene.stage) models = scene.stage->body_models;
  models.resize(scene.world.bodies.size());
  return models;
}

std::vector<double> bounding_radii(const scenes::Scene& scene) {
  std::vector<double> radii;
  for (const auto& model : body_models(scene)) {
    double& farthest = radii.emplace_back(0);
    if (!model) continue;
    for (const scenes::Mesh& mesh : model->meshes)
      for (const scenes::Vertex& v : mesh.vertices)
        farthest = std::max(farthest, Vec3(v.position[0], v.position[1], v.position[2]).norm());
  }
  return radii;
}

scenes::ConnectorLook look_of(const scenes::Scene& scene, std::size_t connector) {
  if (!scene.stage || connector >= scene.stage->connector_looks.size()) return {};
  return scene.stage->connector_looks[connector];
}

std::vector<NamedCamera> cameras(const scenes::Scene& scene) {
  const scenes::Stage& stage = *scene.stage;
  std::vector<NamedCamera> result{{"camera", stage.camera, 0}};
  for (std::size_t i = 0; i < stage.shots.size(); ++i) {
    const scenes::Shot& shot = stage.shots[i];
    if (!same(shot.camera, stage.camera))
      result.push_back({"camera of shot " + std::to_string(i + 1), shot.camera, shot.from});
  }
  return result;
}

Quat looking(const Vec3& direction) {
  const Vec3 back = -direction.normalized();
  const Vec3 up = std::abs(back.y()) < 0.9999 ? Vec3::UnitY() : Vec3::UnitX();
  const Vec3 right = up.cross(back).normalized();
  Mat3 axes;
  axes << right, back.cross(right), back;
  return Quat(axes);
}

int parts_of_frame(const scenes::Scene& scene) {
  const bool equal = step_of(with_defaults(scene.method)) > 0;
  return equal ? 64 : 16;
}

namespace {

/// Times between frame `frame` and the next at which a method of equal steps stops by itself.
std::vector<double> times_between(const scenes::Scene& scene, int frame, int parts) {
  std::vector<double> times;
  const double first = double(frame) / scene.fps, last = double(frame + 1) / scene.fps;
  for (int i = 1; i < parts; ++i) {
    const double time = scenes::own_time(scene, (frame + double(i) / parts) / scene.fps);
    if (time > (times.empty() ? first : times.back()) && time < last) times.push_back(time);
  }
  return times;
}

}  // namespace

void play(const scenes::Scene& scene, FrameWriter& writer, const std::function<void(int)>& tick) {
  const int frames = scene.frames(), parts = writer.states_per_frame();
  if (parts == 0) {
    for (int frame = 0; frame < frames; ++frame) {
      writer.add({true, {double(frame) / scene.fps, {}, {}}, {}});
      tick(frame + 1);
    }
    return writer.finish();
  }
  Simulation simulation = start(scene);
  const ShownVelocities velocities(scene.world, scene.timeline);
  std::optional<Between> between;
  if (parts > 1) between.emplace(start(scene));
  for (int frame = 0; frame < frames; ++frame) {
    World before;
    if (between) before = simulation.world();
    simulation.advance_to(double(frame) / scene.fps);
    const Snapshot state = simulation.state();
    if (between && frame > 0)
      for (Snapshot& shown : between->states(before, times_between(scene, frame - 1, parts), state))
        writer.add({false, std::move(shown), {}});
    writer.add({true, state, velocities.of(simulation)});
    tick(frame + 1);
  }
  writer.finish();
}

}  // namespace taut::exporting
