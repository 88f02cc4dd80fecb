// Chains whose first end goes round or is shaken.
#include "sim/motion/rotation.h"
#include "tests/bench/promise/parts.h"

namespace taut::promise {
namespace {

constexpr double kEnd = 1.5;  // s, after that of every scene

/// Strokes to one side and the other, the first of them half as far.
Path shaken(const Vec3& stroke, double frequency) {
  std::vector<PathKey> keys(1);
  keys[0].ease = true;
  for (int k = 1; keys.back().time < kEnd; ++k) {
    PathKey key;
    key.time = k / (2 * frequency);
    key.position = (k == 1 ? 0.5 : k % 2 == 1 ? 1 : -1) * stroke;
    keys.push_back(key);
  }
  return Path(std::move(keys));
}

Path round(Dice& dice, double radius, bool in_plane, double frequency) {
  const Vec3 axis = dice.direction();
  Circle circle;
  circle.start = Vec3::Zero();
  if (!in_plane) circle.axis = axis;
  circle.centre = radius * circle.axis.unitOrthogonal();
  circle.frequency = frequency;
  circle.ramp = dice.between(0.2, 0.6);
  return Path::round(circle);
}

/// A stick that goes on where the chain ends.
Body stick(const Vec3& top, const Vec3& along, double mass, double length, double thickness,
           double held) {
  Body body;
  body.name = "stick";
  body.mass_properties = solid_cylinder(mass, length, thickness * length);
  body.rotation = rotation_between(-Vec3::UnitY(), along);
  body.position = top + held * length * along;
  return body;
}

}  // namespace

World driven(Dice& dice, const Sizes& sizes) {
  const bool in_plane = dice.pick(2) == 0, circle = dice.pick(2) == 0, body = dice.pick(2) == 0;
  const Vec3 along = in_plane ? from_down(dice.radians(0, 60), 0) : tilted(dice, 60);
  const double amplitude = dice.scale(0.02, 0.3) * sizes.length, frequency = dice.between(0.5, 2.5);
  Vec3 stroke = amplitude * dice.direction();
  if (in_plane) stroke.z() = 0;
  World world;
  world.connectors = {
      shaped("chain", sizes.length, sizes.mass, Vec3::Zero(), straight(sizes.links, along))};
  Connector& chain = world.connectors[0];
  Attachment hand;
  hand.kind = Attachment::Kind::path;
  hand.path = std::make_shared<const Path>(circle ? round(dice, amplitude, in_plane, frequency)
                                                  : shaken(stroke, frequency));
  chain.holds = {{0, hand}};
  if (body) {
    const double length = dice.scale(0.1, 1) * sizes.length, thickness = dice.between(0.05, 0.3);
    const double held = dice.between(0.2, 0.5);  // of the stick's length, above its centre
    world.bodies = {stick(chain.position.back(), along, sizes.load, length, thickness, held)};
    chain.holds.push_back({sizes.links, on_body(0, Vec3(0, held * length, 0))});
  } else {
    chain.particle_mass.back() += sizes.load;
  }
  return world;
}

}  // namespace taut::promise
