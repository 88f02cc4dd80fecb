#include "sim/run/forces.h"

namespace taut {
namespace {

std::string link(std::size_t first) {
  return std::to_string(first) + '-' + std::to_string(first + 1);
}

}  // namespace

Named named(const World& world, const Forces::Link& of) {
  return {world.connectors[of.connector].name, link(of.link)};
}

Named named(const World& world, const Forces::Hold& of) {
  return {world.connectors[of.connector].name, std::to_string(of.particle)};
}

Named named(const World& world, const Forces::Side& of) {
  using Kind = Forces::Side::Kind;
  switch (of.kind) {
    case Kind::particle:
      return {world.connectors[of.index].name, std::to_string(of.at)};
    case Kind::link:
      return {world.connectors[of.index].name, link(of.at)};
    case Kind::body:
      return {world.bodies[of.index].name, ""};
    case Kind::obstacle:
      return {world.obstacles[of.index].name, ""};
  }
  return {};
}

}  // namespace taut
