// The hand's path that leads the tip of a nunchaku's free stick along a figure-eight whose plane
// turns: the rows of turning_eight.csv. A program on an installed taut:
//   g++ $(pkg-config --cflags taut) turning_eight.cpp $(pkg-config --libs taut)
// Says on the error stream how near the tip comes to each of its points.
#include <taut/sim/choreography/choreography.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>

namespace {

using namespace taut;

/// Two equal sticks on a chain; the first is held, pointing forward and up.
World nunchaku() {
  Body held, free;
  held.name = "held";
  held.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  held.grip = Vec3(0, 0.015, 0);
  const Quat tilt(Eigen::AngleAxisd(std::numbers::pi / 3, Vec3::UnitX()));
  held.path =
      std::make_shared<const Path>(std::vector<PathKey>{{0, Vec3(-0.22, 1.053, 0.483), tilt}});
  const Vec3 end = held.path->at(0).position + tilt * Vec3(0, 0.135, 0);
  Connector chain = straight_connector("chain", 0.12, 0.012, 11, end, -Vec3::UnitY());
  free.name = "free";
  free.mass_properties = held.mass_properties;
  free.position = end - Vec3(0, 0.27, 0);
  const auto end_of = [](std::size_t body) {
    Attachment to;
    to.kind = Attachment::Kind::body;
    to.body = body;
    to.point = Vec3(0, 0.15, 0);
    return to;
  };
  chain.holds = {{0, end_of(0)}, {10, end_of(1)}};
  World world;
  world.bodies = {held, free};
  world.connectors = {chain};
  return world;
}

}  // namespace

int main() {
  choreography::Choreography routine;
  routine.world = nunchaku();
  routine.body = 1;
  routine.point = Vec3(0, -0.15, 0);  // the tip
  const Vec3 end = routine.world.connectors[0].position[0];
  // 0.8 m wide, 1.6 s a lap, four laps; between the first and the last its plane turns by 60
  // degrees.
  for (int k = 0; k <= 32; ++k) {
    const double along = std::numbers::pi / 4 * k;
    const double turn = std::numbers::pi / 4 * std::clamp((k - 8) / 16.0, 0.0, 1.0);
    const double wide = 0.4 * std::sin(along), high = -0.27 - 0.15 * std::cos(2 * along);
    routine.waypoints.push_back(
        {1.2 + 0.2 * k, end + Vec3(wide * std::cos(turn), high, wide * std::sin(turn))});
  }
  routine.until = 9;
  routine.limits = {.shoulder = Vec3(-0.2, 1.4, 0), .reach = 0.7, .speed = 2, .acceleration = 20};
  routine.pivot = 0.67;

  const choreography::HandPath path = choreography::choreograph(routine, 0.001);
  std::puts("t,x,y,z,qw,qx,qy,qz");
  for (const PathKey& key : path.keys) {
    std::printf("%.4f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f,%.6f\n", key.time, key.position.x(),
                key.position.y(), key.position.z(), key.rotation.w(), key.rotation.x(),
                key.rotation.y(), key.rotation.z());
  }
  for (std::size_t k = 0; k < path.miss.size(); ++k) {
    std::fprintf(stderr, "at %.2f s: %.2f mm\n", routine.waypoints[k].time, 1e3 * path.miss[k]);
  }
  std::fprintf(stderr, "hand: %.3f m from the shoulder, %.2f m/s, %.1f m/s^2; pull %.2f N\n",
               path.reach, path.speed, path.acceleration, path.tension);
}
