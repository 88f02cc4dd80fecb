// Many connectors at once: the bits of each alone, and the motion that every method has to find.
#include "sim/batch/batch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sim/measure/measure.h"
#include "sim/run/method.h"
#include "sim/run/trajectory.h"

namespace taut::batch_test {
namespace {

using batch::Width;

/// `count` ropes of 9 particles, each of its own length, masses, direction and motion; every third
/// is carried round a circle.
World ropes(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  World world;
  for (std::size_t i = 0; i < count; ++i) {
    const double length = 0.5 + 0.2 * number(random);
    Connector rope = straight_connector("rope" + std::to_string(i), length, 0.1, 9, vector(),
                                        (vector() - 1.5 * Vec3::UnitY()).normalized());
    for (double& mass : rope.particle_mass) mass *= 1.5 + 0.5 * number(random);
    rope.particle_mass.back() += 0.05;
    Attachment to;
    to.point = rope.position[0];
    if (i % 3 == 0) {
      to.kind = Attachment::Kind::path;
      to.point = Vec3::Zero();
      to.path = std::make_shared<const Path>(Path::round(
          {rope.position[0] + 0.1 * Vec3::UnitX(), rope.position[0], Vec3::UnitZ(), 0.5, 0.4}));
    }
    rope.holds = {{0, to}};
    const Vec3 spin = vector();
    for (std::size_t k = 0; k < rope.particles(); ++k) {
      rope.velocity[k] = spin.cross(rope.position[k] - rope.position[0]);
    }
    world.connectors.push_back(std::move(rope));
  }
  finish(world);
  return world;
}

template <typename Scalar>
World after(World world, double duration, double step, batch::Width width, int threads) {
  batch::Batch<Scalar> batch(world, step, width);
  for (int frame = 1; frame <= 4; ++frame) batch.advance(duration * frame / 4, threads);
  batch.store(world);
  return world;
}

template <typename Scalar>
class BatchOf : public testing::Test {};
using Scalars = testing::Types<float, double>;
TYPED_TEST_SUITE(BatchOf, Scalars);

TYPED_TEST(BatchOf, HasTheBitsOfEachAloneAtEveryWidthAndNumberOfThreads) {
  const World start = ropes(37);
  const World single = after<TypeParam>(start, 0.25, 1e-3, batch::Width::single, 1);
  for (std::size_t i = 0; i < start.connectors.size(); ++i) {
    World alone = start;
    alone.connectors = {start.connectors[i]};
    alone = after<TypeParam>(alone, 0.25, 1e-3, batch::Width::single, 1);
    ASSERT_EQ(alone.connectors[0].position, single.connectors[i].position) << i;
  }
  for (const batch::Width width :
       {batch::Width::single, batch::Width::sse2, batch::Width::avx2, batch::Width::avx512}) {
    if (width > batch::widest()) continue;
    for (const int threads : {1, 2, 3, 16}) {
      const World world = after<TypeParam>(start, 0.25, 1e-3, width, threads);
      EXPECT_EQ(state_hash(world), state_hash(single)) << static_cast<int>(width) << ' ' << threads;
    }
  }
}

TEST(Batch, IsOfSecondOrderAndKeepsLengths) {
  const World start = ropes(6);
  const World truth = [&] {
    World world = start;
    make_method("truth", {})->advance(world, 0.2);
    return world;
  }();
  const auto error = [&](double step) {
    const World world = after<double>(start, 0.2, step, batch::widest(), 1);
    EXPECT_LT(stretch_max(world), 1e-12);
    double most = 0, fastest = 0;
    for (std::size_t i = 0; i < world.connectors.size(); ++i) {
      const Connector &mine = world.connectors[i], &right = truth.connectors[i];
      for (std::size_t k = 0; k < mine.particles(); ++k) {
        most = std::max(most, (mine.position[k] - right.position[k]).norm());
        fastest = std::max(fastest, (mine.velocity[k] - right.velocity[k]).norm());
      }
    }
    EXPECT_LT(fastest, 300 * most);  // waves of at most some 300 rad/s carry it
    return most;
  };
  const double coarse = error(2.5e-4), fine = error(1.25e-4), finest = error(6.25e-5);
  EXPECT_NEAR(coarse / fine, 4, 0.4);
  EXPECT_NEAR(fine / finest, 4, 0.2);
  EXPECT_LT(finest, 1e-5);
}

TEST(Batch, FloatsAreNearDoubles) {
  const World start = ropes(5);
  const World fine = after<double>(start, 0.25, 1e-3, batch::widest(), 1);
  const World coarse = after<float>(start, 0.25, 1e-3, batch::widest(), 1);
  for (std::size_t i = 0; i < fine.connectors.size(); ++i) {
    for (std::size_t k = 0; k < 9; ++k) {
      // 250 steps of roundings of 6e-8 to directions, all one way, over 0.7 m.
      EXPECT_LT((fine.connectors[i].position[k] - coarse.connectors[i].position[k]).norm(), 1e-5);
    }
  }
}

TEST(Batch, RefusesWhatIsNotOfOneKind) {
  const auto refuses = [](const World& world) {
    EXPECT_THROW(batch::Batch<double>(world, 1e-3), std::invalid_argument);
  };
  refuses(World{});
  World world = ropes(2);
  world.connectors[1].holds.clear();
  refuses(world);
  world = ropes(2);
  world.connectors[1].holds.push_back({8, {}});
  refuses(world);
  world = ropes(2);
  world.connectors[1] = straight_connector("other", 1, 0.1, 5, Vec3::Zero(), -Vec3::UnitY());
  world.connectors[1].holds = {{0, {}}};
  refuses(world);
}

TEST(Batch, SaysWhichConnectorDiverged) {
  batch::Batch<double> batch(ropes(3), 0.1);
  EXPECT_THROW(batch.advance(20), Diverged);
}

}  // namespace
}  // namespace taut::batch_test
