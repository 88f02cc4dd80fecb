#include "render/film/film.h"

#include "render/film/caption.h"
#include "render/film/frame_folder.h"
#include "render/film/matte.h"
#include "render/film/trails.h"

namespace taut::film {

Film::Film(const gl::Context& context, const scenes::Scene& scene, int width, int height,
           int samples, const draw::Shading& shading)
    : context_(context),
      scene_(scene),
      passes_(samples, context.max_samples()),
      canvas_(context, width, height, passes_.each),
      renderer_(context, *scene.stage, divided(scene.world, scene.timeline), shading) {}

draw::FrameState instant_of(const scenes::Scene& scene, const Snapshot& state) {
  draw::FrameState instant{state, {}, scenes::camera_at(scene.stage->camera, state.time)};
  for (const auto& performance : scene.performances)
    instant.bones.push_back(performance->bones_at(state.time));
  return instant;
}

std::vector<draw::FrameState> shutter_of(const scenes::Scene& scene, const scenes::ClipFrame& frame,
                                         const scenes::ClipSimulation::Shutter& open) {
  std::vector<draw::FrameState> instants;
  for (const Snapshot& state : open.states) {
    instants.push_back(instant_of(scene, state));
    instants.back().camera = scenes::camera_at(frame.shot->camera, frame.time);
  }
  instants[instants.size() / 2].trails = open.trails;
  return instants;
}

picture::Picture Film::draw(const draw::FrameState& instant) {
  picture::Picture picture = draw_stage({&instant, 1}).picture;
  draw_captions(picture, font_, scene_.stage->captions, {.time = instant.state.time});
  return picture;
}

Film::Frame Film::draw(const scenes::ClipFrame& frame, std::span<const draw::FrameState> shutter) {
  if (!transparent_) return draw_opaque(frame, shutter);
  const auto draw_on = [&](double grey) {
    renderer_.set_background(Vec3::Constant(grey));
    stage_drawn_ = 0;
    return draw_opaque(frame, shutter);
  };
  Frame black = draw_on(0);
  black.picture = matte(black.picture, draw_on(1).picture);
  return black;
}

Film::Frame Film::draw_opaque(const scenes::ClipFrame& frame,
                              std::span<const draw::FrameState> shutter) {
  if (!frame.card) {
    Frame drawn = draw_stage(shutter);
    const scenes::Shot& shot = *frame.shot;
    draw_captions(drawn.picture, font_, scene_.stage->captions,
                  {frame.time, shot.from, shot.until, shot.rate});
    lap("captions");
    return drawn;
  }
  // Under a card the picture stands still.
  const std::uint64_t wanted = fingerprint(shutter);
  if (wanted != stage_drawn_) stage_picture_ = draw_stage(shutter);
  stage_drawn_ = wanted;
  Frame drawn = *stage_picture_;
  draw_card(drawn.picture, font_, bold_, *frame.card, scene_.method.name, frame.card_shown);
  lap("captions");
  return drawn;
}

Film::Frame Film::draw_stage(std::span<const draw::FrameState> shutter) {
  const draw::View view{{0, 0, canvas_.width(), canvas_.height()},
                        shutter[shutter.size() / 2].camera};
  std::vector<picture::Picture> pictures;
  int exposures = 0;
  for (int i = 0; i < passes_.count; ++i) {
    renderer_.set_shift(passes_.shift(i));
    renderer_.begin(canvas_, {&view, 1});
    exposures = renderer_.expose(canvas_, view.viewport, shutter);
    canvas_.resolve();
    lap("resolve and tone map");
    pictures.push_back(canvas_.read());
    lap("read back");
  }
  Frame frame{mean(pictures), exposures};
  draw_trails(frame.picture, scene_.stage->trails, shutter[shutter.size() / 2]);
  return frame;
}

void Film::set_profile(gl::Profile* profile) {
  profile_ = profile;
  renderer_.set_profile(profile);
}

void Film::lap(const char* stage) const {
  if (!profile_) return;
  context_.gl().Finish();
  profile_->lap(stage);
}

}  // namespace taut::film
