// The stage: everything that pictures need beside the simulated state. Plain data.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "scenes/model/model.h"
#include "sim/motion/types.h"
#include "sim/world/obstacle.h"

namespace taut::scenes {

/// Where the camera is at `time`: it moves smoothly from each key to the next.
struct CameraKey {
  double time = 0;
  Vec3 position = Vec3(0, 1.4, 3.5);
  Vec3 target = Vec3(0, 1.1, 0);
  double field_of_view = 0.6;    // vertical, rad
  double relative_aperture = 0;  // the lens's opening in focal lengths, 1/f-number; 0: a pinhole
  std::optional<double> focus = {};  // m along the view, where it is sharp; default: at the target
  /// Azimuth (rad, from +z towards +x), elevation (rad) and distance (m) of the position, seen from
  /// the target. Between two keys that have it the camera goes round the target.
  std::optional<Vec3> orbit = {};
  /// The body or connector that the target is relative to, and with an orbit the position, too;
  /// until complete_stage() has found where that goes. Empty: none.
  std::string follow = {};
};

/// From the target to a camera on that orbit (azimuth, elevation, distance).
Vec3 on_orbit(const Vec3& orbit);

struct CameraView {
  Vec3 position, target;
  double field_of_view;          // vertical, rad
  double relative_aperture = 0;  // 0: all is sharp
  double focus = 1;              // m along the view
  bool moves = false;            // it is on its way from one key to another
};

struct Light {
  Vec3 direction = Vec3(-0.75, -1.1, -0.18);  // the way the light travels
  Vec3 color = Vec3(2.60, 2.25, 1.88);        // linear radiance of the key light
  Vec3 sky = Vec3(0.78, 0.80, 0.84);          // ambient from above, linear
  Vec3 ground = Vec3(0.46, 0.43, 0.39);       // ambient from below, linear
  Vec3 rim = Vec3::Zero();     // linear radiance at the edges of what moves, as from behind it
  bool scenery_casts = false;  // the key light comes in only where the scenery is open
};

/// How a connector is drawn along its particles.
struct ConnectorLook {
  enum class Kind { chain, rope, cord };
  Kind kind = Kind::rope;
  double diameter = 0.008;  // m, of the rope or cord, or of a link's outer width
  Vec3 color = Vec3(0.6, 0.5, 0.35);
  Vec3 weight_color = Vec3(0.05, 0.055, 0.065);  // of balls at its ends: iron
  double knob = 0;  // m, diameter of balls at ends that paths carry; 0: none
};

/// A line of text on the picture between two times. Text behind a tab is in one column in all
/// captions of a list.
struct Caption {
  double from = 0, until = 0;  // s
  std::string text;
  std::string list;  // empty: of none
};

/// The way that a point of a body or connector took of late, drawn as a ribbon.
struct Trail {
  std::size_t index = 0;  // of the body or connector
  bool connector = false;
  Vec3 point = Vec3::Zero();                                         // in the body's frame, m
  std::size_t particle = 0;                                          // of the connector
  double lasts = 0.5;                                                // s of the scene
  double from = 0, until = std::numeric_limits<double>::infinity();  // s, when it is seen
  double width = 0.012;  // where the point is, in heights of the picture
  Vec3 color = Vec3(0.95, 0.30, 0.04);
};

/// The places of a point that leaves a trail, the last one its present one.
struct TrailPoints {
  std::vector<double> ages;  // s, falling to 0
  std::vector<Vec3> places;  // m
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
  std::vector<Trail> trails;
};

/// What the files of its models hold that is not drawn, a line each.
std::vector<std::string> left_out(const Stage& stage);

/// The camera at `time` (s); before its first and after its last key it stands still.
CameraView camera_at(const std::vector<CameraKey>& keys, double time);

// A camera's view of a point.

/// Where a camera sees a point: -1 to 1 from left to right and from the lower to the upper edge of
/// a picture of that aspect, width over height; none behind the camera.
std::optional<Eigen::Vector2d> on_picture(const CameraView& camera, double aspect,
                                          const Vec3& point);

// Models of plain solids, for bodies that name no mesh.

// Centred on the origin; sizes in m; `color` linear.
Model cylinder_model(double length, double diameter, const Vec3& color);  // axis along y
Model sphere_model(double diameter, const Vec3& color);
Model box_model(const Vec3& size, const Vec3& color);

/// The vertex, as floats, at the end of the mesh; its index.
std::uint32_t add_vertex(Mesh& mesh, const Vec3& position, const Vec3& normal);
/// A four-sided face; a, b, c, d run counter-clockwise seen from outside.
void add_quad(Mesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);

// Models of obstacles.

/// A model of the shape at `place`; of a plane the square of the edge `size` (m) around its origin.
Model obstacle_model(const Shape& shape, double size, const Pose& place, const Vec3& color);

}  // namespace taut::scenes
