// The nunchaku's routines as their scene files ship them, recorded once for all of their tests.
#pragma once

#include <string>
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
  double step = 0;    // s, between instances

  /// Simulates a scene of the folder `scenes` to its end, with these settings in place of its own.
  static Routine play(const std::string& file, bool with_stage, const Settings& settings = {});
  /// The demonstration, scenes/nunchaku.toml; played once.
  static const Routine& shipped();
  /// The phases of the paper's Figure 7, scenes/nunchaku_paper.toml; played once.
  static const Routine& paper();

  /// The first caption whose text begins so. Throws std::out_of_range where there is none.
  const scenes::Caption& caption(std::string_view beginning) const;
  /// The steps whose time is in [from, until].
  std::vector<Instance> between(double from, double until) const;
  /// The moment at which the hand has come to rest within a caption (s).
  double rest(const scenes::Caption& caption) const;
};

}  // namespace taut
