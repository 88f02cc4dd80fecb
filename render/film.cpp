#include "render/film.h"

#include "render/caption.h"

namespace taut {

Film::Film(const Context& context, const Scene& scene, int width, int height, int samples,
           const Shadows& shadows)
    : context_(context),
      scene_(scene),
      canvas_(context, width, height, samples),
      renderer_(context, *scene.stage, divided(scene.world, scene.timeline), shadows) {}

Instant Film::instant(const Snapshot& state) const {
  Instant instant{state, {}, camera_at(*scene_.stage, state.time)};
  for (const auto& performance : scene_.performances)
    instant.bones.push_back(performance->bones_at(state.time));
  return instant;
}

Picture Film::draw(const Instant& instant) {
  const View view{{0, 0, canvas_.width(), canvas_.height()}, instant.camera};
  renderer_.begin(canvas_, {&view, 1});
  renderer_.draw(canvas_, view.viewport, instant);
  canvas_.resolve();
  lap("resolve and tone map");
  Picture picture = canvas_.read();
  lap("read back");
  draw_captions(picture, font_, scene_.stage->captions, instant.state.time);
  lap("captions");
  return picture;
}

void Film::set_profile(Profile* profile) {
  profile_ = profile;
  renderer_.set_profile(profile);
}

void Film::lap(const char* stage) const {
  if (!profile_) return;
  context_.gl().Finish();
  profile_->lap(stage);
}

}  // namespace taut
