#include "sim/world/world.h"

#include <gtest/gtest.h>

#include "sim/measure/measure.h"
#include "sim/motion/rotation.h"
#include "sim/run/trajectory.h"

namespace taut::world_test {
namespace {

Attachment on_body(std::size_t body, const Vec3& point) {
  return {Attachment::Kind::body, point, nullptr, body};
}

TEST(Body, ShapesHaveTheirKnownMoments) {
  const MassProperties rod = solid_cylinder(3, 2, 0);
  EXPECT_DOUBLE_EQ(rod.inertia(0, 0), 3 * 2 * 2 / 12.0);
  EXPECT_EQ(rod.inertia(1, 1), 0);
  const MassProperties disc = solid_cylinder(3, 0, 2);  // radius 1
  EXPECT_DOUBLE_EQ(disc.inertia(1, 1), 3 / 2.0);
  EXPECT_DOUBLE_EQ(disc.inertia(2, 2), 3 / 4.0);
  EXPECT_DOUBLE_EQ(solid_sphere(5, 2).inertia(0, 0), 2.0);  // 2/5 m r^2
  const MassProperties box = solid_box(12, Vec3(1, 2, 3));
  EXPECT_TRUE(box.inertia.diagonal().isApprox(Vec3(13, 10, 5)));
}

TEST(Body, PointMassesAddUpLikeOneBody) {
  // Four point masses, joined one by one in any order, against the sums over all of them.
  const double masses[] = {0.2, 0.5, 0.1, 0.7};
  const Vec3 points[] = {{1, 0, 0}, {0, 2, 0}, {0, -1, 1}, {0.3, 0.4, -2}};
  MassProperties joined = solid_sphere(0.3, 0.4);
  double mass = 0.3;
  Vec3 moment = Vec3::Zero();
  for (int i = 0; i < 4; ++i) {
    joined = with_point_mass(joined, masses[i], points[i]);
    mass += masses[i];
    moment += masses[i] * points[i];
  }
  const Vec3 centre = moment / mass;
  const auto about = [](double m, const Vec3& r) {
    return Mat3(m * (r.squaredNorm() * Mat3::Identity() - r * r.transpose()));
  };
  Mat3 inertia = solid_sphere(0.3, 0.4).inertia + about(0.3, centre);
  for (int i = 0; i < 4; ++i) inertia += about(masses[i], points[i] - centre);
  EXPECT_NEAR(joined.mass, mass, 1e-15);
  EXPECT_TRUE(joined.centre.isApprox(centre, 1e-14));
  EXPECT_TRUE(joined.inertia.isApprox(inertia, 1e-14));
}

World spinning_stick_with_cord() {
  World world;
  Body stick;
  stick.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  stick.position = Vec3(0.1, 0.2, 0.3);
  stick.rotation = Quat(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  stick.velocity = Vec3(1, -2, 0.5);
  stick.spin = Vec3(3, 1, -4);
  world.bodies = {stick};
  Connector cord = straight_connector("cord", 0.2, 0.06, 3, Vec3::Zero(), Vec3::UnitX());
  cord.holds = {{0, on_body(0, Vec3(0, 0.15, 0.014))}};
  world.connectors = {cord};
  return world;
}

TEST(World, FinishJoinsTheEndsMassAndMovesNothing) {
  const World before = spinning_stick_with_cord();
  World after = before;
  finish(after);
  const Body &was = before.bodies[0], &is = after.bodies[0];
  EXPECT_NEAR(is.mass_properties.mass, 0.14, 1e-16);
  EXPECT_LT((is.frame().position - was.frame().position).norm(), 1e-15);
  for (const Vec3& point : {Vec3(0, 0.15, 0.014), Vec3(0, -0.15, 0), Vec3(0.1, 0, 0)}) {
    EXPECT_LT((is.point(point) - was.point(point)).norm(), 1e-15);
    EXPECT_LT((is.point_velocity(point) - was.point_velocity(point)).norm(), 1e-14);
  }
  EXPECT_LT((after.connectors[0].position[0] - was.point(Vec3(0, 0.15, 0.014))).norm(), 1e-15);
  // The energy is that of the stick and a particle that moves with it, apart from the two left.
  const double end = 0.02 * was.point_velocity(Vec3(0, 0.15, 0.014)).squaredNorm() / 2;
  EXPECT_NEAR(kinetic_energy(after), kinetic_energy(before) + end, 1e-14);
}

TEST(World, DrivenBodiesFollowTheirPathByTheirGrip) {
  World world;
  Body held;
  held.mass_properties = solid_cylinder(0.12, 0.3, 0.028);
  held.grip = Vec3(0, -0.1, 0);
  held.path = std::make_shared<const Path>(
      std::vector<PathKey>{{0, Vec3(0, 1, 0), Quat::Identity()},
                           {1, Vec3(1, 1, 0), Quat(Eigen::AngleAxisd(1.2, Vec3::UnitZ()))}});
  world.bodies = {held};
  Connector cord = straight_connector("cord", 0.2, 0.06, 3, Vec3::Zero(), Vec3::UnitX());
  cord.holds = {{0, on_body(0, Vec3(0, 0.15, 0))}};
  world.connectors = {cord};
  finish(world);
  EXPECT_EQ(world.bodies[0].mass_properties.mass, 0.12);  // driven: nothing to join
  place_held(world, 0.4);
  const FrameMotion path = held.path->at(0.4);
  EXPECT_LT((world.bodies[0].point(held.grip) - path.position).norm(), 1e-15);
  EXPECT_LT((world.bodies[0].point_velocity(held.grip) - path.velocity).norm(), 1e-14);
  // The acceleration of the tip, against the differences of its velocity (h^2/6 of its 4th
  // derivative, some 1e3 m/s^4 here).
  const double h = 1e-4;
  const auto tip = [&](double t) { return hold_motion(world, cord.holds[0].to, t); };
  const Vec3 change = (tip(0.4 + h).velocity - tip(0.4 - h).velocity) / (2 * h);
  EXPECT_LT((tip(0.4).acceleration - change).norm(), 1e3 * h * h);
  EXPECT_EQ(world.connectors[0].position[0], tip(0.4).position);
  EXPECT_TRUE(is_prescribed(world, cord.holds[0].to));
}

TEST(Measure, OneParticleAndOneBodyByHand) {
  World world;
  world.gravity = Vec3(0, -10, 0);
  Connector cord = straight_connector("cord", 1, 0.4, 2, Vec3(0, 3, 0), Vec3(0, -1, 0));
  cord.holds = {{0, {Attachment::Kind::fixed, Vec3(0, 3, 0), nullptr, 0}}};
  cord.velocity[1] = Vec3(2, 0, 0);
  world.connectors = {cord};
  Body ball;
  ball.mass_properties = solid_sphere(5, 2);  // moment 2
  ball.position = Vec3(0, 0, 1);
  ball.velocity = Vec3(0, 3, 0);
  ball.spin = Vec3(1, 0, 0);
  world.bodies = {ball};
  EXPECT_DOUBLE_EQ(kinetic_energy(world), 0.2 * 4 / 2 + 5 * 9 / 2.0 + 2 * 1 / 2.0);
  EXPECT_DOUBLE_EQ(potential_energy(world), 0.2 * 10 * 2);
  EXPECT_TRUE(linear_momentum(world).isApprox(Vec3(0.4, 15, 0)));
  // r x m v: particle (0,2,0) x (0.4,0,0) = (0,0,-0.8); ball (0,0,1) x (0,15,0) = (-15,0,0), +2.
  EXPECT_TRUE(angular_momentum(world).isApprox(Vec3(-13, 0, -0.8)));
  EXPECT_TRUE(angular_momentum(world, Vec3(0, 2, 0)).isApprox(Vec3(-13, 0, 0)));
  world.connectors[0].position[1].y() = 1.9;
  EXPECT_NEAR(stretch_max(world), 0.1, 1e-14);
}

TEST(Measure, EnergyScaleCountsEverythingThatMovesOnce) {
  World world;
  world.gravity = Vec3(0, -10, 0);
  Body ball;
  ball.mass_properties = solid_sphere(5, 2);
  ball.position = Vec3(0, -2, 0);
  ball.velocity = Vec3(1, 0, 0);
  world.bodies = {ball};
  Connector cord = straight_connector("cord", 1, 0.6, 3, Vec3::Zero(), Vec3(0, -1, 0));
  cord.holds = {{0, {}}, {2, on_body(0, Vec3(0, 1, 0))}};
  world.connectors = {cord};
  finish(world);
  // The ball with the end that it carries, and the particle between; not the end that is fixed.
  EXPECT_DOUBLE_EQ(moving_mass(world), 5.2 + 0.2);
  EXPECT_DOUBLE_EQ(energy_scale(world), 5.4 * 10 * 1 + kinetic_energy(world));
}

TEST(World, TopologyIsAllThatMethodsBuildOn) {
  World world = spinning_stick_with_cord();
  const auto path = [](double height) {
    return std::make_shared<const Path>(std::vector<PathKey>{{0, {0, 0, 0}}, {1, {0, height, 0}}});
  };
  world.connectors[0].holds.push_back({2, {Attachment::Kind::path, Vec3::Zero(), path(1), 0}});
  finish(world);
  const std::uint64_t before = world.topology;
  const auto changed = [&](const auto& change) {
    World other = world;
    change(other, other.connectors[0]);
    return structure(other) != before;
  };
  EXPECT_FALSE(changed([](World& w, Connector& cord) {
    w.time = 0.5;
    place_held(w, 0.5);
    cord.velocity[1] = Vec3(1, 2, 3);
  })) << "a step";
  EXPECT_FALSE(changed([&](World&, Connector& cord) { cord.holds[1].to.path = path(1); }))
      << "the same path elsewhere in memory";
  EXPECT_TRUE(changed([&](World&, Connector& cord) { cord.holds[1].to.path = path(2); }));
  EXPECT_TRUE(changed([](World&, Connector& cord) { cord.rest[1] *= 2; }));
  EXPECT_TRUE(changed([](World&, Connector& cord) { cord.particle_mass[1] *= 2; }));
  EXPECT_TRUE(changed([](World& w, Connector&) { w.bodies[0].mass_properties.mass *= 2; }));
  EXPECT_TRUE(changed([&](World& w, Connector&) { w.bodies[0].path = path(1); }));
  EXPECT_TRUE(changed([](World&, Connector& cord) { cord.model = ConnectorModel::span; }));
  EXPECT_TRUE(changed([](World&, Connector& cord) { cord.restitution = 0.5; }));
  EXPECT_TRUE(changed([](World&, Connector& cord) { cord.holds[0].to.approach.arrival = 1; }));
}

TEST(Path, AnotherCircleHasAnotherFingerprint) {
  Circle circle;
  const std::uint64_t before = Path::round(circle).fingerprint();
  EXPECT_EQ(before, Path::round(circle).fingerprint());
  circle.ramp *= 2;
  EXPECT_NE(before, Path::round(circle).fingerprint());
}

TEST(Trajectory, TheHashSeesEveryBit) {
  World world = spinning_stick_with_cord();
  finish(world);
  const std::uint64_t hash = state_hash(world);
  EXPECT_EQ(hash, state_hash(World(world)));
  World other = world;
  other.connectors[0].velocity[2].z() = -0.0;
  EXPECT_NE(hash, state_hash(other));
  other = world;
  other.bodies[0].spin.x() = std::nextafter(other.bodies[0].spin.x(), 0);
  EXPECT_NE(hash, state_hash(other));
  const Snapshot shot = snapshot(world);
  EXPECT_EQ(shot.connectors[0], world.connectors[0].position);
  EXPECT_EQ(shot.bodies[0].position, world.bodies[0].frame().position);
}

/// Down to 1e-12 of twice the squared cosine of half the angle, |a + b| is 1.4e-6 with roundings of
/// 1e-16: ten digits of it are right.
TEST(RotationBetween, TakesADirectionToAnyOther) {
  constexpr double kTold = 1e-9;
  const std::vector<Vec3> directions = {{1, 0, 0}, {0, -2, 0}, {0, 0, 3}, {1, 2, -0.5}};
  for (const Vec3& from : directions) {
    for (const Vec3& to : directions) {
      for (const double sign : {1.0, -1.0}) {
        for (const double off : {0.0, 1e-10, 1e-7, 1e-5, 1e-2}) {
          const Vec3 end = (sign * to + off * to.unitOrthogonal()).normalized();
          const Quat turn = rotation_between(from, end);
          EXPECT_NEAR((turn * from.normalized() - end).norm(), 0, kTold);
          EXPECT_NEAR(turn.norm(), 1, kTold);
        }
      }
    }
  }
}

}  // namespace
}  // namespace taut::world_test
