#include "render/film.h"

#include "render/caption.h"

namespace taut {

Film::Film(const Context& context, const Scene& scene, int width, int height, int samples)
    : scene_(scene),
      canvas_(context, width, height, samples),
      renderer_(context, *scene.stage, scene.world) {}

Instant Film::instant(const Snapshot& state) const {
  Instant instant{state, {}, camera_at(*scene_.stage, state.time)};
  for (const auto& performance : scene_.performances)
    instant.bones.push_back(performance->bones_at(state.time));
  return instant;
}

Picture Film::draw(const Instant& instant) {
  renderer_.clear(canvas_);
  renderer_.draw(canvas_, {0, 0, canvas_.width(), canvas_.height()}, instant);
  Picture picture = canvas_.finish();
  draw_captions(picture, font_, scene_.stage->captions, instant.state.time);
  return picture;
}

}  // namespace taut
