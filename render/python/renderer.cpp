#include "render/python/renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "scenes/load/default_stage.h"
#include "scenes/scene/clip.h"

namespace taut::python {

Renderer::Renderer(scenes::Scene scene, const std::vector<scenes::SceneChange>& changes,
                   const PictureOptions& options, const std::function<void()>& tick)
    : scene_(std::move(scene)), transparent_(options.transparent) {
  if (options.width > 0) scene_.width = options.width;
  if (options.height > 0) scene_.height = options.height;
  scenes::complete_stage(scene_, changes, tick);
  shown_ = divided(scene_.world, scene_.timeline);
  thread_ = DrawingThread::of(options.backend);
  thread_->run([&](const gl::Context& context) {
    film_ =
        std::make_unique<film::Film>(context, scene_, scene_.width, scene_.height, options.samples);
    film_->set_transparent(transparent_);
  });
}

Renderer::~Renderer() {
  if (thread_) thread_->run([&](const gl::Context&) { film_.reset(); });
}

picture::Picture Renderer::made(const std::function<picture::Picture(film::Film&)>& draw) {
  picture::Picture picture;
  thread_->run([&](const gl::Context&) { picture = draw(*film_); });
  if (!transparent_) {  // the fourth byte is nobody's
    for (std::size_t i = 3; i < picture.pixels.size(); i += 4) picture.pixels[i] = 255;
  }
  return picture;
}

picture::Picture Renderer::frame(double time, const std::function<void()>& tick) {
  const std::vector<scenes::ClipFrame> frames = scenes::clip_frames(scene_);
  const double end = static_cast<double>(frames.size()) / scene_.fps;
  if (!(time >= 0 && time <= end)) {
    throw std::invalid_argument(
        fmt::format("time {} s: the clip lasts from 0 to {:g} s", time, end));
  }
  const int frame = std::min(static_cast<int>(std::lround(time * scene_.fps)),
                             static_cast<int>(frames.size()) - 1);
  const auto open = scenes::record(scene_, frames, {frame}, tick);
  const scenes::ClipFrame& wanted = frames[static_cast<std::size_t>(frame)];
  return made(
      [&](film::Film& film) { return film.draw(wanted, film.shutter(wanted, open[0])).picture; });
}

picture::Picture Renderer::draw(const Snapshot& state) {
  const auto same = [](const Connector& connector, const std::vector<Vec3>& particles) {
    return connector.particles() == particles.size();
  };
  if (state.bodies.size() != shown_.bodies.size() ||
      !std::ranges::equal(shown_.connectors, state.connectors, same)) {
    throw std::invalid_argument("the simulation has other particles or bodies than the scene");
  }
  scenes::ClipFrame frame;
  const scenes::Shot shot{0, std::max(state.time, scene_.duration) + 1, 1, scene_.stage->camera};
  frame.shot = &shot;
  frame.time = state.time;
  return made([&](film::Film& film) {
    return film.draw(frame, film.shutter(frame, {0, {state}})).picture;
  });
}

}  // namespace taut::python
