// The stage: everything that pictures need beside the simulated state. Plain data.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/model/model.h"
#include "sim/motion/types.h"

namespace taut::scenes {

/// Where the camera is at `time`: it moves smoothly from each key to the next.
struct CameraKey {
  double time = 0;
  Vec3 position = Vec3(0, 1.4, 3.5);
  Vec3 target = Vec3(0, 1.1, 0);
  double field_of_view = 0.6;    // vertical, rad
  double relative_aperture = 0;  // the lens's opening in focal lengths, 1/f-number; 0: a pinhole
  std::optional<double> focus = {};  // m along the view, where it is sharp; default: at the target
};

struct CameraView {
  Vec3 position, target;
  double field_of_view;          // vertical, rad
  double relative_aperture = 0;  // 0: all is sharp
  double focus = 1;              // m along the view
};

struct Light {
  Vec3 direction = Vec3(-0.75, -1.1, -0.18);  // the way the light travels
  Vec3 color = Vec3(6.8, 5.3, 3.8);           // linear radiance of the key light
  Vec3 sky = Vec3(0.49, 0.61, 0.82);          // ambient from above, linear
  Vec3 ground = Vec3(0.22, 0.184, 0.15);      // ambient from below, linear
  bool scenery_casts = false;  // the key light comes in only where the scenery is open
};

/// How a connector is drawn along its particles.
struct ConnectorLook {
  enum class Kind { chain, rope, cord };
  Kind kind = Kind::rope;
  double diameter = 0.008;  // m, of the rope or cord, or of a link's outer width
  Vec3 color = Vec3(0.6, 0.5, 0.35);
  Vec3 weight_color = Vec3(0.05, 0.055, 0.065);  // of balls for point masses at its ends: iron
};

/// A line of text on the picture between two times. Text behind a tab is in one column in all
/// captions of a list.
struct Caption {
  double from = 0, until = 0;  // s
  std::string text;
  std::string list;  // empty: of none
};

/// A part of the scene as the clip shows it, seen by a camera of its own.
struct Shot {
  double from = 0, until = 0;  // s of the scene
  double rate = 1;             // seconds of the scene to one of the clip
  std::vector<CameraKey> camera;
};

/// Lines of text on a ground of their own, before or after the shots.
struct Card {
  double duration = 0;  // s of the clip; 0: there is none
  std::string heading;
  std::string text;  // lines below it; "{method}" stands for the method's name
};

struct Stage {
  std::vector<CameraKey> camera;  // of the scene as a whole
  std::vector<Shot> shots;        // in the order of the clip; at least one
  Card title, end;
  double shutter = 0;          // the share of a frame's time for which it is open; 0: an instant
  int exposures = 32;          // states that a frame shows meanwhile at most, a power of two
  double exposures_apart = 2;  // px, most that a point comes from one to the next
  Light light;
  Vec3 background = Vec3(0.35, 0.38, 0.42);               // linear
  std::vector<std::shared_ptr<const Model>> scenery;      // in world space
  std::vector<std::shared_ptr<const Model>> body_models;  // one per body; null: not drawn
  std::vector<ConnectorLook> connector_looks;             // one per connector
  std::vector<std::shared_ptr<const Model>> characters;   // skinned
  std::vector<Caption> captions;
};

/// What the files of its models hold that is not drawn, a line each.
std::vector<std::string> left_out(const Stage& stage);

/// The camera at `time` (s); before its first and after its last key it stands still.
CameraView camera_at(const std::vector<CameraKey>& keys, double time);

}  // namespace taut::scenes
