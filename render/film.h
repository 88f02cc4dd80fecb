// A scene's clip as pictures: its stage drawn at any of its states, with captions.
#pragma once

#include "render/canvas.h"
#include "render/profile.h"
#include "render/stage_renderer.h"
#include "render/text.h"
#include "scenes/scene.h"

namespace taut {

/// A frame depends on its instant alone, never on the frames drawn before.
class Film {
 public:
  /// `scene` has a stage, and must outlive this. Throws NoContext where the driver allows no such
  /// size or number of samples.
  Film(const Context& context, const Scene& scene, int width, int height, int samples,
       const Shadows& shadows = {});

  /// Everything that moves, in this state: characters pose by its time.
  Instant instant(const Snapshot& state) const;
  Picture draw(const Instant& instant) { return draw({&instant, 1}).picture; }

  /// The same of each of several states.
  std::vector<Instant> shutter(std::span<const Snapshot> states) const;

  struct Frame {
    Picture picture;
    int exposures;  // instants that it shows
  };
  /// The frame while a shutter is open: instants evenly apart, its own in the middle.
  Frame draw(std::span<const Instant> shutter);

  /// Where to note the stages' times, each waited for; null: nowhere.
  void set_profile(Profile* profile);

 private:
  void lap(const char* stage) const;

  const Context& context_;
  const Scene& scene_;
  Canvas canvas_;
  StageRenderer renderer_;
  Font font_;
  Profile* profile_ = nullptr;
};

}  // namespace taut
