// Slack chains between holds.
#include "tests/bench/promise/parts.h"

namespace taut::promise {
namespace {

/// Hangs from the origin to `share` of its length away.
std::vector<Vec3> hung(Dice& dice, double length, std::size_t links, double share) {
  const double rise = dice.radians(-45, 45), round = dice.radians(0, 360);
  const Connector even = straight_connector("", length, 1, links + 1, Vec3::Zero(), Vec3::UnitX());
  const Vec3 away(std::cos(rise) * std::cos(round), std::sin(rise),
                  std::cos(rise) * std::sin(round));
  return hanging_points(even, Vec3::Zero(), share * length * away, -kGravity * Vec3::UnitY());
}

/// Pulls the particles from the first to `last` aside, about the line from the one to the other,
/// and throws them about it.
void swing(Connector& chain, std::size_t last, double angle, double rate) {
  const Vec3 axis = (chain.position[last] - chain.position[0]).normalized();
  const Eigen::AngleAxisd turn(angle, axis);
  for (std::size_t i = 1; i < last; ++i) {
    chain.position[i] = turn * chain.position[i];
    chain.velocity[i] = rate * axis.cross(chain.position[i]);
  }
}

}  // namespace

World pinned(Dice& dice, const Sizes& sizes) {
  const int form = dice.pick(3);  // hanging, zigzag, held in the middle
  const double share = dice.between(0.3, 0.95), angle = dice.radians(20, 120);
  const bool thrown = dice.pick(2) == 1;
  const double speed = dice.between(-2, 2);
  const double rate = thrown ? speed * std::sqrt(kGravity / sizes.length) : 0;
  const auto pieces = static_cast<std::size_t>(dice.between(2, 8));
  World world;
  world.connectors = {shaped("chain", sizes.length, sizes.mass, Vec3::Zero(),
                             form == 1
                                 ? zigzag(sizes.links, pieces, dice.direction(), std::acos(share))
                                 : straight(sizes.links, tilted(dice, 150)))};
  Connector& chain = world.connectors[0];
  std::size_t last = sizes.links;
  if (form == 2) {
    last = static_cast<std::size_t>(dice.between(2, static_cast<double>(sizes.links)));
    chain.particle_mass.back() += sizes.load;
  } else {
    chain.particle_mass[sizes.links / 2] += sizes.load;
  }
  if (form != 1) {
    const double part = sizes.length * static_cast<double>(last) / static_cast<double>(sizes.links);
    const std::vector<Vec3> points = hung(dice, part, last, share);
    const Vec3 shift = points[last] - chain.position[last];
    for (std::size_t i = last; i <= sizes.links; ++i) chain.position[i] += shift;
    for (std::size_t i = 1; i < last; ++i) chain.position[i] = points[i];
  }
  swing(chain, last, angle, rate);
  const Vec3 held = chain.position[last];
  move(chain, last, held, Vec3::Zero(), dice.within(2 * std::sqrt(kGravity / sizes.length)));
  chain.holds = {{0, fixed_at(Vec3::Zero())}, {last, fixed_at(held)}};
  return world;
}

}  // namespace taut::promise
