#include "tests/bench/engines/points.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include "tests/bench/engines/solids.h"

namespace taut::engines {
namespace {

void check_net(const World& world) {
  const auto need = [](bool holds, const char* what) {
    if (!holds) throw std::invalid_argument(what);
  };
  need(std::ranges::all_of(world.bodies, &Body::driven), "engines are given nets without bodies");
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      need(hold.to.kind == Attachment::Kind::fixed, "engines are given nets on fixed points");
    }
    need(!connector.links_touch, "engines are given beads that touch obstacles");
    for (const Obstacle& obstacle : world.obstacles) {
      need(obstacle.touches(connector.category), "engines are given obstacles that all nets touch");
    }
  }
  for (const Obstacle& obstacle : world.obstacles) {
    check_solid(obstacle);
    need(!obstacle.path, "engines are given nets beside obstacles that stand still");
  }
}

}  // namespace

Points::Points(const World& world) : obstacles_(world.obstacles), gravity_(world.gravity) {
  check_net(world);
  std::vector<std::uint32_t> leaders;
  find_leaders(world, leaders);
  point_of_.resize(leaders.size());
  std::size_t particle = 0;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    auto hold = connector.holds.begin();
    for (std::size_t i = 0; i < connector.particles(); ++i, ++particle) {
      const bool held = hold != connector.holds.end() && hold->particle == i;
      if (held) ++hold;
      if (leaders[particle] != particle) continue;
      point_of_[particle] = points_.size();
      points_.push_back({connector.position[i], connector.velocity[i], joined_mass(world, c, i),
                         held, connector.radius});
    }
  }
  for (std::size_t i = 0; i < leaders.size(); ++i) point_of_[i] = point_of_[leaders[i]];
  particle = 0;
  for (const Connector& connector : world.connectors) {
    for (std::size_t k = 0; k < connector.links(); ++k, ++particle) {
      const Link link{point_of_[particle], point_of_[particle + 1], connector.rest[k],
                      connector.pulls};
      if (!points_[link.a].held || !points_[link.b].held) links_.push_back(link);
    }
    ++particle;
  }
}

void Points::place(const std::vector<Vec3>& positions, double time, World& world) const {
  auto point = point_of_.begin();
  for (Connector& connector : world.connectors) {
    for (Vec3& position : connector.position) position = positions[*point++];
  }
  place_held(world, time);
}

}  // namespace taut::engines
