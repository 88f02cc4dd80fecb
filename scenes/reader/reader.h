// The parts of a scene file, one function each. They run after check_format, so that they look only
// at what keys mean together: names, files, and numbers that must fit each other.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/format/document.h"
#include "scenes/reader/common.h"
#include "scenes/reader/joints.h"
#include "scenes/reader/motions.h"
#include "scenes/scene/scene.h"

namespace taut::scenes {

/// The scene that a document describes. Throws BadScene.
Scene read_scene(Document document, bool with_stage);

/// The method that a table names, with its settings; the default method for null.
MethodChoice read_method(const Document& document, const Value* table, int fps, double duration);

/// Fails at the key of a feature that the scene's method does not follow.
void refuse_unfollowed(const Document& document, const Scene& scene);

/// Fails where a connector that is curved at rest may leave the plane across that.
void check_curvatures(const Document& document, const World& world, const Timeline& timeline);

/// Whether the value of a body says where it always is.
bool is_driven(const Value& body);
/// Bodies with their masses; those that hang have no place yet.
std::vector<Body> read_bodies(const Document& document, Motions& motions);
/// Connectors with their shapes; places the bodies that hang.
void read_connectors(const Document& document, Motions& motions, World& world);
/// Nets, whose cords become connectors behind all others.
void read_nets(const Document& document, World& world);
/// How many connectors a net is.
std::size_t cord_count(const Value& net);
/// The mass (kg) that a connector of this length has by its mass or its material.
double mass_of(const Value& connector, double length);
/// Keys that a connector and the cords of a net have in common: surface, sections of the links,
/// drag of the air. Changes its masses where they follow the links.
void read_cord(const Document& document, const Value& value, Connector& connector);
/// The air of a scene.
Air read_air(const Document& document);
/// Obstacles, behind bodies and connectors. Moving ones that are shown come with a driven body, by
/// which they are seen.
void read_obstacles(const Document& document, Motions& motions, World& world);
/// A single obstacle.
Obstacle read_obstacle(const Document& document, const Value& value, Motions& motions,
                       const World& world);
/// Moves beads that would start inside of obstacles to their surfaces, of connectors that ask for
/// it and the way that they say; links keep their lengths.
void push_out_starts(const Document& document, World& world);
/// Whether pictures show it.
bool shows_obstacle(const Value& value);
/// Fails where a bead or body starts inside an obstacle; of a world that is finished.
void check_obstacles(const Document& document, const World& world);
/// Friction and restitution of an obstacle or of bodies that touch each other.
void read_friction(const Document& document, const Value& value, double& static_friction,
                   double& kinetic_friction, double& restitution);
/// Pairs of free bodies that touch each other.
void read_touching(const Document& document, World& world);
/// Whether these start apart; of a world that is finished.
void check_touching(const Document& document, const World& world);
/// Pins and cuts, of a world that is finished.
Timeline read_timeline(const Document& document, Motions& motions, const World& world,
                       double duration);

/// A plan made earlier, whether or not the scene is still the one that it was made for. Checks its
/// format, too. Throws BadScene.
Plan read_plan(const Document& document, const Value& table, int fps);

/// Reads the models too, and works out what the characters do.
void read_stage(const Document& document, Motions& motions, Scene& scene);
/// Reads the models of a scene without a stage, only to say what is wrong with them.
void check_models(const Document& document);

/// Particles a link apart along straight pieces through `corners`, from the first on. Fewer than
/// `particles` when the line is too short.
std::vector<Vec3> along_line(const std::vector<Vec3>& corners, std::size_t particles, double link);

/// As many places along all of it, equally far from each other on it.
std::vector<Vec3> evenly_along(const std::vector<Vec3>& corners, std::size_t particles);

/// A regular polygon across `axis` whose sides are the links of a connector; from `first` on, or
/// from anywhere.
std::vector<Vec3> polygon(const Vec3& axis, const Vec3& centre, const Connector& connector,
                          const std::optional<Vec3>& first);

/// How a rope lies on a round obstacle.
struct Winding {
  double turns = 0.5;            // about the obstacle's y axis, right-handed
  double before = 0, after = 0;  // m, of the straight pieces on either side
};

/// Corners of the line of beads of `radius` (m): straight up to a round obstacle, about it, and
/// straight on. Turns lie side by side, in the middle of the obstacle.
std::vector<Vec3> wound_line(const Obstacle& around, double radius, const Vec3& gravity,
                             const Winding& winding);

/// What a scene's choreography asks for, of its world and timeline. Throws BadScene.
Choreographed read_choreography(const Document& document, const Value& table,
                                const Motions& motions, const Scene& scene);

}  // namespace taut::scenes
