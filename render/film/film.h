// A scene's clip as pictures: its stage drawn at any of its states, with captions and cards.
#pragma once

#include <optional>

#include "render/draw/stage_renderer.h"
#include "render/gl/canvas.h"
#include "render/gl/profile.h"
#include "render/picture/text.h"
#include "scenes/scene/clip.h"

namespace taut {

/// Everything that moves, in this state, by the scene's camera: characters pose by its time.
FrameState instant_of(const Scene& scene, const Snapshot& state);
/// The states that a frame of the clip shows, as it shows them.
std::vector<FrameState> shutter_of(const Scene& scene, const ClipFrame& frame,
                                   std::span<const Snapshot> states);

/// A frame depends on its own instants alone, never on the frames drawn before.
class Film {
 public:
  /// `scene` has a stage, and must outlive this. Throws NoContext where the driver allows no such
  /// size or number of samples.
  Film(const Context& context, const Scene& scene, int width, int height, int samples,
       const Shading& shading = {});

  FrameState instant(const Snapshot& state) const { return instant_of(scene_, state); }
  Picture draw(const FrameState& instant);

  struct Frame {
    Picture picture;
    int exposures;  // instants that it shows
  };
  std::vector<FrameState> shutter(const ClipFrame& frame, std::span<const Snapshot> states) const {
    return shutter_of(scene_, frame, states);
  }
  Frame draw(const ClipFrame& frame, std::span<const FrameState> shutter);

  /// From now on frames have opacity, none where the stage's background would be; their colours are
  /// not multiplied by it. Each takes the time of two.
  void set_transparent(bool on) { transparent_ = on; }

  /// Where to note the stages' times, each waited for; null: nowhere.
  void set_profile(Profile* profile);

 private:
  Frame draw_opaque(const ClipFrame& frame, std::span<const FrameState> shutter);
  Frame draw_stage(std::span<const FrameState> shutter);
  void lap(const char* stage) const;

  const Context& context_;
  const Scene& scene_;
  Canvas canvas_;
  StageRenderer renderer_;
  Font font_{Font::Weight::regular, Font::Family::lato},
      bold_{Font::Weight::bold, Font::Family::lato};
  std::uint64_t stage_drawn_ = 0;  // fingerprint of the picture below; 0: none
  std::optional<Frame> stage_picture_;
  bool transparent_ = false;
  Profile* profile_ = nullptr;
};

}  // namespace taut
