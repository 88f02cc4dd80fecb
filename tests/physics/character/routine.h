// The nunchaku's routine as its scene file ships it, recorded once for all of its tests.
#pragma once

#include <string_view>
#include <vector>

#include "scenes/scene/scene.h"
#include "sim/run/method.h"

namespace taut {

/// The free stick and the hand at the end of one step.
struct Instance {
  double time;              // s
  FrameMotion hand;         // of the path
  Vec3 grip;                // the held stick's point in the hand, m
  Vec3 from, top, tip;      // the chain's end on the held stick; the free stick's ends, m
  Vec3 position, velocity;  // of the free stick's centre of mass

  double span() const { return (top - from).norm(); }
};

struct Routine {
  scenes::Scene scene;
  std::vector<Instance> steps;
  std::vector<Event> events;
  double mass = 0;    // kg, of the free stick and the chain's end that it carries
  double length = 0;  // m, of the chain
  double step = 0;    // s

  /// Simulates scenes/nunchaku.toml to its end in `split` times as many steps as it says.
  static Routine play(bool with_stage, int split, double passes);
  /// The scene's own steps, with its stage; played once.
  static const Routine& shipped();

  /// The first caption whose text begins so. Throws std::out_of_range where there is none.
  const scenes::Caption& caption(std::string_view beginning) const;
  /// The steps whose time is in [from, until].
  std::vector<Instance> between(double from, double until) const;
  /// The moment at which the hand has come to rest within a caption (s).
  double rest(const scenes::Caption& caption) const;
};

}  // namespace taut
