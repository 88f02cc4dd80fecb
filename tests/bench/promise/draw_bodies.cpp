// Chains with free bodies.
#include "tests/bench/promise/parts.h"

namespace taut::promise {
namespace {

/// A box, turned anyhow, and a place on it.
struct Box {
  Body body;
  Vec3 size;   // m
  Vec3 point;  // m, where it is held, in its frame

  Box(Dice& dice, double mass, double extent, double rate) {
    const double x = dice.between(0.3, 1), y = dice.between(0.3, 1), z = dice.between(0.3, 1);
    size = extent * Vec3(x, y, z);
    point = place(dice);
    const double angle = dice.radians(0, 180);
    body.mass_properties = solid_box(mass, size);
    body.rotation = Quat(Eigen::AngleAxisd(angle, dice.direction()));
    body.spin = dice.within(rate);
  }
  Vec3 place(Dice& dice) const { return dice.within(0.5).cwiseProduct(size); }
  /// Puts it where its point is that particle.
  void hang(const Connector& chain, std::size_t particle) {
    const Vec3 arm = body.rotation * point;
    body.position = chain.position[particle] - arm;
    body.velocity = chain.velocity[particle] - body.spin.cross(arm);
  }
};

}  // namespace

World bodies(Dice& dice, const Sizes& sizes) {
  const int form = dice.pick(3);  // one hanging, two flying, two hanging one below the other
  const double rate = std::sqrt(kGravity / sizes.length);
  const double extent = dice.scale(0.05, 0.5) * sizes.length;
  const bool slack = dice.pick(2) == 1;
  const auto pieces = static_cast<std::size_t>(dice.between(2, 8));
  const double angle = dice.radians(10, 60);
  const Vec3 along = form == 1 ? dice.direction() : tilted(dice, 120);
  const auto directions = [&](std::size_t links, const Vec3& way) {
    return slack ? zigzag(links, pieces, way, angle) : straight(links, way);
  };
  World world;
  world.connectors = {
      shaped("chain", sizes.length, sizes.mass, Vec3::Zero(), directions(sizes.links, along))};
  Connector& chain = world.connectors[0];
  const Vec3 spin = dice.within(rate);
  move(chain, 0, Vec3::Zero(), Vec3::Zero(), spin);
  Box box(dice, sizes.load, extent, 2 * rate);
  box.hang(chain, sizes.links);
  box.body.name = "box";
  world.bodies = {box.body};
  chain.holds = {{sizes.links, on_body(0, box.point)}};
  if (form != 1) chain.holds.insert(chain.holds.begin(), {0, fixed_at(Vec3::Zero())});
  if (form == 0) return world;

  Box other(dice, sizes.load * dice.scale(0.2, 5), extent, 2 * rate);
  other.body.name = "other";
  if (form == 1) {
    other.hang(chain, 0);
    chain.holds.insert(chain.holds.begin(), {0, on_body(1, other.point)});
    world.bodies.push_back(other.body);
    return world;
  }
  const Vec3 from = box.place(dice), arm = box.body.rotation * from;
  const double share = dice.between(0.3, 1);
  const auto links = static_cast<std::size_t>(
      std::max(2.0, dice.between(0.3, 1) * static_cast<double>(sizes.links)));
  Connector below = shaped("below", share * sizes.length, share * sizes.mass,
                           box.body.position + arm, directions(links, tilted(dice, 120)));
  move(below, 0, below.position[0], box.body.velocity + box.body.spin.cross(arm),
       dice.within(rate));
  other.hang(below, links);
  below.holds = {{0, on_body(0, from)}, {links, on_body(1, other.point)}};
  world.bodies.push_back(other.body);
  world.connectors.push_back(below);
  return world;
}

}  // namespace taut::promise
