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

std::vector<Instant> Film::shutter(std::span<const Snapshot> states) const {
  std::vector<Instant> instants;
  for (const Snapshot& state : states) instants.push_back(instant(state));
  return instants;
}

Film::Frame Film::draw(std::span<const Instant> shutter) {
  const Instant& own = shutter[shutter.size() / 2];
  const View view{{0, 0, canvas_.width(), canvas_.height()}, own.camera};
  renderer_.begin(canvas_, {&view, 1});
  const int exposures = renderer_.expose(canvas_, view.viewport, shutter);
  canvas_.resolve();
  lap("resolve and tone map");
  Frame frame{canvas_.read(), exposures};
  lap("read back");
  draw_captions(frame.picture, font_, scene_.stage->captions, own.state.time);
  lap("captions");
  return frame;
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
