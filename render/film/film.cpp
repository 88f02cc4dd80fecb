#include "render/film/film.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <vector>

#include "render/draw/view.h"
#include "render/film/caption.h"
#include "render/film/frame_folder.h"
#include "render/picture/picture.h"
#include "render/picture/text.h"
#include "scenes/scene/stage.h"

namespace taut::film {
namespace {

// Ribbons that show which way points came.

constexpr double kOpacity = 0.85;  // where the point is
constexpr double kOldest = 0.15;   // of its width, at the trail's end
constexpr int kSteps = 4;          // pieces of a curve from one place to the next

std::uint8_t srgb(double linear) {
  const double x = std::clamp(linear, 0.0, 1.0);
  const double value = x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return std::uint8_t(std::lround(255 * value));
}

/// Through place i and the one after it (Catmull and Rom 1974), at the share `u` of the way.
Vec3 on_curve(const std::vector<Vec3>& places, std::size_t i, double u) {
  const Vec3 &b = places[i], &c = places[i + 1];
  const Vec3 a = i > 0 ? places[i - 1] : Vec3(2 * b - c),
             d = i + 2 < places.size() ? places[i + 2] : Vec3(2 * c - b);
  return b + u / 2 * (c - a + u * (2 * a - 5 * b + 4 * c - d + u * (3 * (b - c) + d - a)));
}

/// Draws the instant's trails over its picture, narrower and fainter where they are older.
void draw_trails(picture::Picture& picture, std::span<const scenes::Trail> trails,
                 const draw::FrameState& instant) {
  const double width = picture.width, height = picture.height;
  for (std::size_t i = 0; i < std::min(trails.size(), instant.trails.size()); ++i) {
    const scenes::Trail& trail = trails[i];
    const auto& [ages, places] = instant.trails[i];
    std::vector<picture::RibbonPoint> points;
    const auto add = [&](double age, const Vec3& place) {
      constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
      const auto at = scenes::on_picture(instant.camera, width / height, place);
      const double young = std::clamp(1 - age / trail.lasts, 0.0, 1.0);
      points.push_back(
          {at ? (1 + at->x()) / 2 * width : kNowhere, at ? (1 - at->y()) / 2 * height : kNowhere,
           trail.width * height * (kOldest + (1 - kOldest) * young), kOpacity * young});
    };
    for (std::size_t k = 0; k + 1 < places.size(); ++k)
      for (int step = 0; step < kSteps; ++step) {
        const double u = double(step) / kSteps;
        add(std::lerp(ages[k], ages[k + 1], u), on_curve(places, k, u));
      }
    if (!places.empty()) add(ages.back(), places.back());
    picture::ribbon(picture, points,
                    {srgb(trail.color.x()), srgb(trail.color.y()), srgb(trail.color.z())});
  }
}

}  // namespace

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

namespace {

double linear(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

double encoded(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

std::uint8_t byte(double share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

/// Samples of a pixel are averaged as light, so shares of the background are shares of light.
const std::array<double, 256>& light_of_bytes() {
  static const auto table = [] {
    std::array<double, 256> list{};
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = linear(static_cast<double>(i) / 255);
    return list;
  }();
  return table;
}

}  // namespace

picture::Picture matte(const picture::Picture& on_black, const picture::Picture& on_white) {
  const auto& light = light_of_bytes();
  constexpr double kNothing = 3.0 / 255;  // of opacity: within the pictures' rounding
  picture::Picture result(on_black.width, on_black.height);
  for (std::size_t i = 0; i < result.pixels.size(); i += 4) {
    double through = 0;  // the share of the background that is seen
    for (std::size_t k = 0; k < 3; ++k)
      through += (light[on_white.pixels[i + k]] - light[on_black.pixels[i + k]]) / 3;
    const double opacity = 1 - std::clamp(through, 0.0, 1.0);
    const bool nothing = opacity<kNothing, solid = opacity> 1 - kNothing;
    for (std::size_t k = 0; k < 3; ++k) {
      result.pixels[i + k] = nothing ? std::uint8_t(0)
                             : solid ? on_black.pixels[i + k]
                                     : byte(encoded(light[on_black.pixels[i + k]] / opacity));
    }
    result.pixels[i + 3] = nothing ? std::uint8_t(0) : solid ? std::uint8_t(255) : byte(opacity);
  }
  return result;
}

picture::Picture mean(std::span<const picture::Picture> pictures) {
  if (pictures.size() == 1) return pictures[0];
  const auto& light = light_of_bytes();
  picture::Picture result(pictures[0].width, pictures[0].height);
  for (std::size_t i = 0; i < result.pixels.size(); ++i) {
    if (i % 4 == 3) continue;
    double sum = 0;
    for (const picture::Picture& one : pictures) sum += light[one.pixels[i]];
    result.pixels[i] = byte(encoded(sum / double(pictures.size())));
  }
  return result;
}

picture::Picture contact_sheet(std::span<const picture::Picture> pictures, int columns) {
  const int width = pictures[0].width, height = pictures[0].height;
  const int rows = (int(pictures.size()) + columns - 1) / columns;
  picture::Picture sheet(width * columns, height * rows);
  for (int i = 0; i < int(pictures.size()); ++i)
    picture::paste(pictures[std::size_t(i)], sheet, i % columns * width, i / columns * height);
  return sheet;
}

}  // namespace taut::film
