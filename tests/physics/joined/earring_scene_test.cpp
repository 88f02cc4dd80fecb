// The earring of a character who shakes his head, against pendulums, and against the skin beside
// it.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/mesh/skinning.h"
#include "scenes/load/load_scene.h"
#include "tests/physics/worlds.h"

namespace taut::earring_scene_test {
namespace {

constexpr double kStill = 3.45;  // s, when the head has stopped

const scenes::Scene& scene() {
  static const scenes::Scene earring =
      scenes::load_scene(TAUT_SOURCE_DIR "/scenes/earring.toml", true);
  return earring;
}

/// The drop's centre from the ear, as a unit vector.
Vec3 direction(const World& world) {
  return (world.bodies[0].position - world.connectors[0].position[0]).normalized();
}

/// The slower frequency (rad/s) of small swings: a stiff rod, which is the chain under the load of
/// twenty times its mass, and the drop jointed to it.
double slow_swing(const World& world) {
  const Connector& chain = world.connectors[0];
  const Body& drop = world.bodies[0];
  const double l = chain.length, r = chain.holds[1].to.point.norm(), g = worlds::kGravity;
  const double m = drop.bare.mass, rod = chain.mass, inertia = drop.bare.inertia(0, 0);
  Eigen::Matrix2d mass, stiffness;
  mass << (m + rod / 3) * l * l, m * l * r, m * l * r, m * r * r + inertia;
  stiffness << (m + rod / 2) * g * l, 0, 0, m * g * r;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> solver(stiffness, mass);
  return std::sqrt(solver.eigenvalues()[0]);
}

/// A pendulum of one bead on a rod of `length` (m), whose upper end moves as it is told.
class DrivenPendulum {
 public:
  DrivenPendulum(double length, const Vec3& down) : length_(length), down_(down) {}

  /// A step of Runge and Kutta's from `time`; the rate of the direction n is u:
  /// u' = (f - (f.n) n)/L - u.u n with f = g - a, a the end's acceleration.
  void step(double time, double dt, auto&& acceleration) {
    const auto slope = [&](double at, const Vec3& n, const Vec3& u) {
      const Vec3 f = Vec3(0, -worlds::kGravity, 0) - acceleration(at);
      return Vec3((f - f.dot(n) * n) / length_ - u.squaredNorm() * n);
    };
    const Vec3 n = down_, u = rate_;
    const Vec3 k1 = slope(time, n, u), u2 = u + dt / 2 * k1;
    const Vec3 k2 = slope(time + dt / 2, n + dt / 2 * u, u2), u3 = u + dt / 2 * k2;
    const Vec3 k3 = slope(time + dt / 2, n + dt / 2 * u2, u3), u4 = u + dt * k3;
    const Vec3 k4 = slope(time + dt, n + dt * u3, u4);
    down_ = (n + dt / 6 * (u + 2 * u2 + 2 * u3 + u4)).normalized();
    rate_ = u + dt / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }

  const Vec3& down() const { return down_; }

 private:
  double length_;
  Vec3 down_, rate_ = Vec3::Zero();
};

// A pendulum of one bead and the earring's slow frequency goes the same way. The pendulum lacks the
// fast mode, five times as fast, whose answer to the shaking is (1/5)^2 of the slow one's at most.
TEST(EarringScene, WhileTheHeadShakesItGoesWithADrivenPendulum) {
  Simulation simulation = scenes::start(scene());
  const World& world = simulation.world();
  const double w = slow_swing(world);
  DrivenPendulum pendulum(worlds::kGravity / (w * w), direction(world));
  const Attachment ear = world.connectors[0].holds[0].to;
  constexpr double sampling = 1.0 / 240;  // s
  double largest = 0, apart = 0;
  for (int k = 0; sampling * k < kStill; ++k) {
    pendulum.step(sampling * k, sampling,
                  [&](double t) { return hold_motion(world, ear, t).acceleration; });
    simulation.advance_to(sampling * (k + 1));
    const Vec3 is = direction(world);
    largest = std::max(largest, std::hypot(is.x(), is.z()));
    apart = std::max(apart, (is - pendulum.down()).norm());
  }
  EXPECT_GT(largest, 0.3);
  EXPECT_LT(apart, 0.04 * largest);
}

// Free: the largest and least angles from straight down, a and b, come twice a period each, with
// the frequency w (1 - (a^2 + b^2)/16) of a spherical pendulum to second order.
TEST(EarringScene, OnceTheHeadStopsItSwingsAtItsOwnFrequency) {
  Simulation simulation = scenes::start(scene());
  const World& world = simulation.world();
  constexpr double sampling = 1e-3;  // s
  std::vector<double> peaks;         // s
  double a = 0, b = INFINITY, before = 0, now = 0;
  for (int k = 0; kStill + sampling * k <= scene().duration; ++k) {
    simulation.advance_to(kStill + sampling * k);
    const double next = std::acos(-direction(world).y());
    if (k > 1 && now > before && now >= next) peaks.push_back(kStill + sampling * (k - 1));
    a = std::max(a, next);
    b = std::min(b, next);
    before = now;
    now = next;
  }
  ASSERT_GE(peaks.size(), 12u);
  const double measured =
      std::numbers::pi * static_cast<double>(peaks.size() - 1) / (peaks.back() - peaks.front());
  EXPECT_GT(a, 0.3);
  EXPECT_NEAR(measured / (slow_swing(world) * (1 - (a * a + b * b) / 16)), 1, 1e-3);
}

TEST(EarringScene, ItsEndStaysInTheEarAndItsDropClearOfTheSkin) {
  Simulation simulation = scenes::start(scene());
  const World& world = simulation.world();
  const scenes::Model& model = *scene().stage->characters[0];
  std::vector<mesh::MovingVertex> skinned;
  const auto head = static_cast<std::size_t>(model.bone("Head"));
  for (int frame = 0; frame < scene().frames(); frame += 2) {
    const double time = frame / 60.0;
    simulation.advance_to(time);
    const std::vector<Pose> bones = scene().performances[0]->bones_at(time);
    const Vec3 ear = bones[head].to_world(world.connectors[0].holds[0].to.point);
    EXPECT_LT((world.connectors[0].position[0] - ear).norm(), 1e-6) << time;
    double clear = INFINITY;
    const std::vector<mesh::BoneMatrix> matrices = mesh::bone_matrices(model, bones);
    for (const scenes::Mesh& mesh : model.meshes) {
      mesh::skin(mesh, matrices, skinned);
      for (const mesh::MovingVertex& vertex : skinned) {
        const Vec3 at(vertex.position[0], vertex.position[1], vertex.position[2]);
        clear = std::min(clear, (at - world.bodies[0].position).norm());
      }
    }
    EXPECT_GT(clear - 0.007, 0.002) << time;  // the drop's radius; a vertex is every 4 mm
  }
}

TEST(EarringScene, TheMethodIsAsAccurateAsItSays) {
  Simulation direct = scenes::start(scene()),
             truth = scenes::start(scene(), {"truth", {{"local_error", 1e-10}}});
  for (int frame = 1; frame <= 240; ++frame) {
    direct.advance_to(frame / 60.0);
    truth.advance_to(frame / 60.0);
    EXPECT_LT((direct.world().bodies[0].position - truth.world().bodies[0].position).norm(), 1e-5)
        << frame;
  }
}

}  // namespace
}  // namespace taut::earring_scene_test
