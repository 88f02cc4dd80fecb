// The parts of a performance: limbs, tracks and capsules, against their definitions.
#include <gtest/gtest.h>

#include <random>

#include "scenes/character/capsules.h"
#include "scenes/character/skeleton.h"
#include "scenes/character/track.h"

namespace taut::character_parts {
namespace {

class Random {
 public:
  double operator()(double low, double high) { return low + (high - low) * unit_(engine_); }
  Vec3 point() { return {(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)}; }

 private:
  std::mt19937 engine_{7};
  std::uniform_real_distribution<double> unit_{0, 1};
};

TEST(CharacterLimb, ReachesItsTargetOnThePolesSide) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const scenes::Limb limb{Vec3(0.3, -0.01, 0.02), Vec3(0.25, -0.05, 0.03)};
    const Vec3 root = random.point(), pole = random.point();
    const Vec3 target = root + random(0.08, limb.reach()) * random.point().normalized();
    const scenes::LimbTurns turns = scenes::bend_limb(limb, root, target, pole);
    const Vec3 middle = root + turns.upper * limb.upper;
    EXPECT_LT((middle - turns.middle).norm(), 1e-12);
    EXPECT_LT((middle + turns.lower * limb.lower - target).norm(), 1e-12);
    // The middle joint lies in the half plane of the pole.
    const Vec3 along = (target - root).normalized();
    const Vec3 side = pole - pole.dot(along) * along;
    const Vec3 off = middle - root - (middle - root).dot(along) * along;
    EXPECT_GT(off.dot(side), 0);
    EXPECT_LT(off.cross(side).norm(), 1e-9);
  }
}

TEST(CharacterLimb, StopsShortOfWhatItCannotReach) {
  const scenes::Limb limb{Vec3(0.3, 0, 0), Vec3(0.3, 0, 0.001)};
  const scenes::LimbTurns turns =
      scenes::bend_limb(limb, Vec3::Zero(), Vec3(0, 2, 0), Vec3(1, 0, 0));
  const Vec3 end = turns.upper * limb.upper + turns.lower * limb.lower;
  EXPECT_LT((end - Vec3(0, limb.reach(), 0)).norm(), 1e-12);
}

TEST(CharacterLimb, TwistIsTheTurnAboutTheAxisAlone) {
  const Vec3 axis = Vec3(1, 2, -1).normalized();
  for (const double angle : {-3.0, -0.7, 0.0, 1.2, 3.1})
    EXPECT_NEAR(scenes::twist_about(Quat(Eigen::AngleAxisd(angle, axis)), axis), angle, 1e-12);
  EXPECT_NEAR(scenes::twist_about(Quat(Eigen::AngleAxisd(1.0, axis.unitOrthogonal())), axis), 0,
              1e-12);
}

scenes::Track ramp() {
  return scenes::Track::sample(4, 100,
                               [](double t) { return Eigen::VectorXd::Constant(1, 3 * t); });
}

TEST(CharacterTrack, AFollowerOfARampIsItsLagBehind) {
  const scenes::Track lagged = ramp().lagged(0.1);
  EXPECT_NEAR(lagged.at(3.5)[0], 3 * (3.5 - 0.1), 1e-9);
}

/// The mean delay of an impulse's response is the centroid of the rate of a step's.
TEST(CharacterTrack, AFollowersMeanDelayIsItsLag) {
  const double rate = 400, lag = 0.1;
  const scenes::Track step = scenes::Track::sample(
      3, rate, [](double t) { return Eigen::VectorXd::Constant(1, t > 1 ? 1 : 0); });
  const scenes::Track answer = step.lagged(lag).rates();
  double sum = 0, moment = 0;
  for (Eigen::Index i = 0; i < answer.count(); ++i) {
    sum += answer[i][0];
    moment += answer[i][0] * (answer.time(i) - 1);
  }
  EXPECT_NEAR(moment / sum, lag, 1 / rate);
}

TEST(CharacterTrack, SmoothingShiftsNothingInTime) {
  const scenes::Track smooth = ramp().smoothed(0.05);
  EXPECT_NEAR(smooth.at(2.0)[0], 6, 1e-9);
  EXPECT_NEAR(ramp().rates().at(2.0)[0], 3, 1e-9);
  EXPECT_NEAR(ramp().ahead(0.25).at(2.0)[0], 3 * 2.25, 1e-9);
}

TEST(CharacterTrack, ReadsThirdOrderBetweenItsSamples) {
  // Halving the spacing divides the error of a cubic reading by eight at least.
  double error[2];
  for (const int k : {0, 1}) {
    const double rate = 20 << k;
    const scenes::Track sine = scenes::Track::sample(
        2, rate, [](double t) { return Eigen::VectorXd::Constant(1, std::sin(5 * t)); });
    error[k] = 0;
    for (double t = 0.5; t < 1.5; t += 0.003)
      error[k] = std::max(error[k], std::abs(sine.at(t)[0] - std::sin(5 * t)));
  }
  EXPECT_LT(error[1], error[0] / 7.5);
}

TEST(CharacterCapsule, DistanceOfSegmentsIsThatOfTheirClosestPoints) {
  Random random;
  for (int i = 0; i < 300; ++i) {
    const Vec3 a0 = random.point(), a1 = random.point();
    const Vec3 b0 = random.point(), b1 = i % 3 ? random.point() : Vec3(b0 + 2 * (a1 - a0));
    double least = 1e9;
    const int n = 100;
    for (int j = 0; j <= n; ++j) {
      const Vec3 p = a0 + (a1 - a0) * j / n;
      const Vec3 d = b1 - b0;
      const double t = std::clamp((p - b0).dot(d) / d.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (p - b0 - t * d).norm());
    }
    const double distance = scenes::segment_distance(a0, a1, b0, b1);
    EXPECT_LE(distance, least + 1e-12);
    EXPECT_GT(distance, least - (a1 - a0).norm() / n);  // no sample is farther from the closest
  }
}

}  // namespace
}  // namespace taut::character_parts
