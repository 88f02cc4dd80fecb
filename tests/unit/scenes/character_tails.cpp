// The belt's tails: they lag behind a body that moves, swing on, and come to rest before the cloth.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "render/mesh/skinning.h"
#include "scenes/character/character.h"
#include "scenes/character/tails.h"
#include "scenes/load/load_scene.h"
#include "scenes/model/load_model.h"

namespace taut::character_tails {
namespace {

constexpr double swings_from = 1, swings_for = 0.3, way = 0.15;  // s, s, m

class CharacterTails : public testing::Test {
 protected:
  /// The body, shifted to its left by so much.
  scenes::Placement shifted(double aside) const {
    scenes::Posture posture = skeleton_.upright();
    posture.shift.x() = aside;
    return skeleton_.place(posture);
  }
  /// Where it is while it goes its way and stays there.
  static double place(double time) {
    const double u = std::clamp((time - swings_from) / swings_for, 0.0, 1.0);
    return way * u * u * (3 - 2 * u);
  }

  const scenes::Model model_ = scenes::load_model(TAUT_SOURCE_DIR "/assets/martial_artist.glb");
  const scenes::Skeleton skeleton_{model_};
  const scenes::Tails tails_{skeleton_};
};

TEST_F(CharacterTails, LagSwingOnAndSettle) {
  const scenes::Track swing = tails_.swing(6, 120, [&](double t) { return shifted(place(t)); });
  const Eigen::VectorXd rest = swing.at(swings_from);
  for (const Eigen::Index point : {0, 1, 2, 3}) {  // bend and end of the left tail, of the right
    const auto aside = [&](double t) { return swing.at(t)[3 * point] - rest[3 * point]; };
    double behind = 0, beyond = 0;
    for (double t = swings_from; t < 6; t += 0.01) {
      behind = std::min(behind, aside(t));
      beyond = std::max(beyond, aside(t));
    }
    EXPECT_LT(aside(swings_from + swings_for / 2), -0.02) << point;  // it moves fastest here
    EXPECT_GT(behind, -way) << point;
    EXPECT_GT(beyond, 0.01) << point;
    EXPECT_LT(beyond, way) << point;
    for (double t = swings_from + 2.5; t < 6; t += 0.1) EXPECT_NEAR(aside(t), 0, 0.003) << point;
  }
}

TEST_F(CharacterTails, AStillBodysTailsHangStill) {
  const scenes::Track swing = tails_.swing(2, 120, [&](double) { return shifted(0); });
  for (Eigen::Index i = 240; i-- > 120;) EXPECT_LT((swing[i] - swing[240]).norm(), 0.001);
  // Forward only, before the cloth.
  for (const Eigen::Index point : {0, 1, 2, 3}) {
    const Vec3 offset = swing[240].segment<3>(3 * point);
    EXPECT_GT(offset.z(), 0);
    EXPECT_LT(offset.z(), 0.02);
    EXPECT_LT(std::hypot(offset.x(), offset.y()), 0.001);
  }
}

TEST_F(CharacterTails, AreAsLongAsEver) {
  scenes::Placement placed = shifted(0);
  Eigen::VectorXd offsets = Eigen::VectorXd::Zero(12);
  offsets << 0.03, 0, 0.02, 0.08, 0, 0.03, -0.02, 0.01, 0.02, 0.05, 0.02, 0.06;
  tails_.hang(offsets, placed);
  for (const std::string side : {"Left", "Right"}) {
    const auto upper = skeleton_.find(side + "Tail1"), lower = skeleton_.find(side + "Tail2");
    EXPECT_NEAR((placed.position[lower] - placed.position[upper]).norm(),
                (skeleton_.rest(lower) - skeleton_.rest(upper)).norm(), 1e-12);
  }
}

/// Whether the ray from `from` along `direction` meets a triangle within 5 cm.
bool meets(const Eigen::Vector3f& from, const Eigen::Vector3f& direction, const Eigen::Vector3f& a,
           const Eigen::Vector3f& b, const Eigen::Vector3f& c) {
  Eigen::Matrix3f m;  // from + way direction = a + x (b - a) + y (c - a)
  m << b - a, c - a, -direction;
  if (std::abs(m.determinant()) < 1e-12f) return false;
  const Eigen::Vector3f s = m.inverse() * (from - a);
  return s.x() >= 0 && s.y() >= 0 && s.x() + s.y() <= 1 && s.z() > 0 && s.z() < 0.05f;
}

TEST_F(CharacterTails, StayBeforeTheSkirtOverTheRoutine) {
  const scenes::Scene scene = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/nunchaku.toml", true);
  const scenes::Model& model = *scene.stage->characters[0];
  const auto mesh = [&](std::string_view name) -> const scenes::Mesh& {
    return *std::ranges::find(model.meshes, name, &scenes::Mesh::name);
  };
  const scenes::Mesh &belt = mesh("Belt"), &jacket = mesh("Jacket");
  const auto hips = std::size_t(model.bone("Hips"));
  int hidden = 0, all = 0;
  std::vector<mesh::MovingVertex> tails, cloth;
  for (double time = 0; time < scene.duration; time += 0.2) {
    const std::vector<Pose> poses = scene.performances[0]->bones_at(time);
    const auto bones = mesh::bone_matrices(model, poses);
    mesh::skin(belt, bones, tails);
    mesh::skin(jacket, bones, cloth);
    const Eigen::Vector3f front = (poses[hips].rotation * Vec3::UnitZ()).cast<float>();
    for (std::size_t i = 0; i < tails.size(); i += 4) {
      if (belt.vertices[i].position[1] > 0.99f) continue;  // the belt itself
      const Eigen::Vector3f& p = tails[i].position;
      bool in_cloth = false;
      for (std::size_t k = 0; k < jacket.indices.size() && !in_cloth; k += 3) {
        const auto corner = [&](std::size_t j) { return cloth[jacket.indices[k + j]].position; };
        if ((corner(0) - p).squaredNorm() > 0.01f) continue;
        in_cloth = meets(p, front, corner(0), corner(1), corner(2));
      }
      hidden += in_cloth;
      ++all;
    }
  }
  ASSERT_GT(all, 5000);
  EXPECT_LT(hidden, all / 100);
}

}  // namespace
}  // namespace taut::character_tails
