// A scene's clip as pictures: its stage drawn at any of its states, with captions and cards; and
// pictures made of several.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "render/draw/stage_renderer.h"
#include "render/gl/canvas.h"
#include "render/gl/gpu.h"
#include "render/picture/picture.h"
#include "render/picture/text.h"
#include "scenes/scene/clip.h"

namespace taut::film {

/// The pictures whose mean has `samples` per pixel where a driver has at most `limit`.
struct Passes {
  Passes(int samples, int limit)
      : count((samples + limit - 1) / limit), each((samples + count - 1) / count) {}
  int count, each;  // pictures, and the samples of each
  /// What picture `i` is moved by, px: so that its samples lie between those of the others.
  Eigen::Vector2f shift(int i) const {
    const float x = (float(i) - float(count - 1) / 2) / float(count * each);
    return {x, -x};
  }
};

/// The mean of the light of pictures of one size.
picture::Picture mean(std::span<const picture::Picture> pictures);

/// Everything that moves, in this state, by the scene's camera: characters pose by its time.
draw::FrameState instant_of(const scenes::Scene& scene, const Snapshot& state);
/// The states that a frame of the clip shows, as it shows them.
std::vector<draw::FrameState> shutter_of(const scenes::Scene& scene, const scenes::ClipFrame& frame,
                                         const scenes::ClipSimulation::Shutter& open);

/// A frame depends on its own instants alone, never on the frames drawn before.
class Film {
 public:
  /// `scene` has a stage, and must outlive this. Throws NoContext where the driver allows no such
  /// size or number of samples.
  Film(const gl::Context& context, const scenes::Scene& scene, int width, int height, int samples,
       const draw::Shading& shading = {});

  draw::FrameState instant(const Snapshot& state) const { return instant_of(scene_, state); }
  picture::Picture draw(const draw::FrameState& instant);

  struct Frame {
    picture::Picture picture;
    int exposures;  // instants that it shows
  };
  std::vector<draw::FrameState> shutter(const scenes::ClipFrame& frame,
                                        const scenes::ClipSimulation::Shutter& open) const {
    return shutter_of(scene_, frame, open);
  }
  Frame draw(const scenes::ClipFrame& frame, std::span<const draw::FrameState> shutter);

  /// From now on frames have opacity, none where the stage's background would be; their colours are
  /// not multiplied by it. Each takes the time of two.
  void set_transparent(bool on) { transparent_ = on; }

  /// Where to note the stages' times, each waited for; null: nowhere.
  void set_profile(gl::Profile* profile);

 private:
  Frame draw_opaque(const scenes::ClipFrame& frame, std::span<const draw::FrameState> shutter);
  Frame draw_stage(std::span<const draw::FrameState> shutter);
  void lap(const char* stage) const;

  const gl::Context& context_;
  const scenes::Scene& scene_;
  Passes passes_;
  gl::Canvas canvas_;
  draw::StageRenderer renderer_;
  picture::Font font_{picture::Font::Weight::regular, picture::Font::Family::lato},
      bold_{picture::Font::Weight::bold, picture::Font::Family::lato};
  std::uint64_t stage_drawn_ = 0;  // fingerprint of the picture below; 0: none
  std::optional<Frame> stage_picture_;
  bool transparent_ = false;
  gl::Profile* profile_ = nullptr;
};

/// The picture with opacity that gives `on_black` over black and `on_white` over white. Its fourth
/// bytes are opacity; its colours are not premultiplied.
picture::Picture matte(const picture::Picture& on_black, const picture::Picture& on_white);

/// Pictures of one size in a grid with `columns` columns.
picture::Picture contact_sheet(std::span<const picture::Picture> pictures, int columns);

}  // namespace taut::film
