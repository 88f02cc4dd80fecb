#include "tests/bench/promise/draw.h"

#include <algorithm>

#include "tests/bench/promise/parts.h"

namespace taut::promise {
namespace {

/// Half of all planes are that of x and y.
double azimuth(Dice& dice) {
  const bool turned = dice.pick(2) == 1;
  return turned ? dice.radians(0, 360) : 0;
}

World let_go(Dice& dice, const Sizes& sizes, double lowest, double highest) {
  const double tilt = dice.radians(lowest, highest);
  World world;
  world.connectors = {shaped("chain", sizes.length, sizes.mass, Vec3::Zero(),
                             straight(sizes.links, from_down(tilt, azimuth(dice))))};
  world.connectors[0].particle_mass.back() += sizes.load;
  world.connectors[0].holds = {{0, fixed_at(Vec3::Zero())}};
  return world;
}

World thrown(Dice& dice, const Sizes& sizes) {
  const double tilt = dice.radians(10, 150), round = dice.radians(0, 360);
  const Vec3 along = from_down(tilt, round);
  const bool curved = dice.pick(2) == 1;
  const double turn = dice.radians(20, 200), twist = dice.radians(0, 360);
  const double rate = std::sqrt(kGravity / sizes.length);
  const Vec3 any = dice.within(rate);
  const Vec3 spin = dice.between(0.2, 2) * rate * Vec3::UnitY() + any;
  World world;
  world.connectors = {
      shaped("chain", sizes.length, sizes.mass, Vec3::Zero(),
             curved ? bent(sizes.links, along, turn, twist) : straight(sizes.links, along))};
  Connector& chain = world.connectors[0];
  chain.particle_mass.back() += sizes.load;
  chain.holds = {{0, fixed_at(Vec3::Zero())}};
  move(chain, 0, Vec3::Zero(), Vec3::Zero(), spin);
  return world;
}

World flying(Dice& dice, const Sizes& sizes) {
  const Vec3 along = dice.direction();
  const bool curved = dice.pick(3) > 0;
  const double turn = dice.radians(30, 300), twist = dice.radians(0, 360);
  const auto pieces = static_cast<std::size_t>(dice.between(2, 8));
  const double angle = dice.radians(10, 70), rate = std::sqrt(kGravity / sizes.length);
  const Vec3 velocity = dice.within(rate * sizes.length), spin = dice.within(2 * rate);
  World world;
  world.connectors = {shaped(
      "chain", sizes.length, sizes.mass, Vec3::Zero(),
      curved ? bent(sizes.links, along, turn, twist) : zigzag(sizes.links, pieces, along, angle))};
  world.connectors[0].particle_mass.back() += sizes.load;
  move(world.connectors[0], 0, Vec3::Zero(), velocity, spin);
  return world;
}

World of_kind(std::string_view kind, Dice& dice, const Sizes& sizes) {
  if (kind == "plane") return let_go(dice, sizes, 0, 180);
  if (kind == "upright") return let_go(dice, sizes, 170, 179);
  if (kind == "space") return thrown(dice, sizes);
  if (kind == "driven") return driven(dice, sizes);
  if (kind == "pinned") return pinned(dice, sizes);
  if (kind == "bodies") return bodies(dice, sizes);
  return flying(dice, sizes);
}

/// With fewer particles nothing of such a chain could move by itself.
double fewest(std::string_view kind) {
  return kind == "pinned" ? 4 : kind == "bodies" ? 3 : 2;
}

}  // namespace

Drawn draw(unsigned seed) {
  Dice dice(seed);
  Drawn drawn;
  drawn.seed = seed;
  drawn.kind = seed % kKinds.size();
  const std::string_view kind = kKinds[drawn.kind];
  drawn.particles = static_cast<std::size_t>(dice.scale(fewest(kind), 201));
  drawn.length = dice.scale(0.1, 10);
  const double mass = dice.scale(0.01, 1);
  drawn.ratio = dice.scale(1e-3, 1e3);
  drawn.world = of_kind(kind, dice, {drawn.particles - 1, drawn.length, mass, drawn.ratio * mass});
  finish(drawn.world);
  return drawn;
}

}  // namespace taut::promise
