// Cloth that hangs: it lags behind a body that moves, swings on and comes to rest; no leg comes
// through the skirt, nor the skirt through the belt's tails.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "render/mesh/skinning.h"
#include "scenes/character/cloth.h"
#include "scenes/load/load_scene.h"
#include "scenes/model/load_model.h"

namespace taut::character_hanging {
namespace {

using Vec3f = Eigen::Vector3f;
constexpr double swings_from = 1, swings_for = 0.3, way = 0.15;  // s, s, m
const std::array<std::string, 4> kEnds = {"LeftTail3", "RightTail3", "SkirtFrontC3", "SkirtBackC3"};

class CharacterHanging : public testing::Test {
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
  /// A joint of cloth from the pelvis, m.
  Vec3 from_hips(const scenes::HangingCloth& cloth, double time, const std::string& name) const {
    scenes::Placement placed = shifted(place(time));
    cloth.hang(time, placed);
    return placed.position[skeleton_.find(name)] - placed.position[skeleton_.find("Hips")];
  }

  const scenes::Model model_ = scenes::load_model(TAUT_SOURCE_DIR "/assets/martial_artist.glb");
  const scenes::Skeleton skeleton_{model_};
};

TEST_F(CharacterHanging, LagsSwingsOnAndSettles) {
  scenes::HangingCloth cloth(model_, skeleton_);
  cloth.simulate(6, 120, [&](double t) { return shifted(place(t)); });
  for (const std::string& end : kEnds) {
    const double rest = from_hips(cloth, swings_from, end).x();
    double behind = 0, beyond = 0;
    for (double t = swings_from; t < 6; t += 0.01) {
      const double aside = from_hips(cloth, t, end).x() - rest;
      behind = std::min(behind, aside);
      beyond = std::max(beyond, aside);
      // Three seconds are five swings, each of which leaves less than half: 0.15 m / 2^5.
      if (t > swings_from + swings_for + 3) {
        EXPECT_NEAR(aside, 0, way / 32) << end << t;
      }
    }
    EXPECT_LT(behind, -0.01) << end;
    EXPECT_GT(behind, -way) << end;
    EXPECT_GT(beyond, 0.002) << end;
    EXPECT_LT(beyond, way) << end;
  }
}

TEST_F(CharacterHanging, HangsStillOnAStillBody) {
  scenes::HangingCloth cloth(model_, skeleton_);
  cloth.simulate(2, 120, [&](double) { return shifted(0); });
  scenes::Placement last = shifted(0);
  cloth.hang(2, last);
  for (double t = 0; t < 2; t += 0.1) {
    scenes::Placement now = shifted(0);
    cloth.hang(t, now);
    for (std::size_t bone = 0; bone < skeleton_.size(); ++bone)
      EXPECT_LT((now.position[bone] - last.position[bone]).norm(), 0.002)
          << model_.bones[bone].name;
  }
}

TEST_F(CharacterHanging, IsAsLongAsEver) {
  scenes::HangingCloth cloth(model_, skeleton_);
  cloth.simulate(2, 120, [&](double t) { return shifted(place(t)); });
  scenes::Placement placed = shifted(place(1.2));
  cloth.hang(1.2, placed);
  for (std::size_t bone = 0; bone < skeleton_.size(); ++bone) {
    if (!scenes::fabric_of(model_.bones[bone].name)) continue;
    const auto parent = std::size_t(skeleton_.parent(bone));
    EXPECT_NEAR((placed.position[bone] - placed.position[parent]).norm(),
                (skeleton_.rest(bone) - skeleton_.rest(parent)).norm(), 1e-12)
        << model_.bones[bone].name;
  }
}

/// Whether the line from p to q goes through a triangle.
bool pierces(const Vec3f& p, const Vec3f& q, const std::array<Vec3f, 3>& t) {
  const Vec3f n = (t[1] - t[0]).cross(t[2] - t[0]);
  const float before = n.dot(p - t[0]), behind = n.dot(q - t[0]);
  if (before * behind > 0 || before == behind) return false;
  const Vec3f at = p + before / (before - behind) * (q - p);
  for (std::size_t k = 0; k < 3; ++k)
    if (n.dot((t[(k + 1) % 3] - t[k]).cross(at - t[k])) < 0) return false;
  return true;
}

class LongCharacterHangingRoutine : public testing::Test {
 protected:
  const scenes::Mesh& mesh(std::string_view name) const {
    return *std::ranges::find(model_.meshes, name, &scenes::Mesh::name);
  }

  const scenes::Scene scene_ = scenes::load_scene(TAUT_SOURCE_DIR "/scenes/nunchaku.toml", true);
  const scenes::Model& model_ = *scene_.stage->characters[0];
};

TEST_F(LongCharacterHangingRoutine, NoLegComesThroughTheSkirt) {
  const scenes::Mesh &jacket = mesh("Jacket"), &trousers = mesh("Trousers");
  const auto is_outer_skirt = [&](std::uint32_t vertex) {
    const scenes::Vertex& v = jacket.vertices[vertex];
    float share = 0;
    for (std::size_t k = 0; k < 4; ++k)
      if (model_.bones[v.bones[k]].name.starts_with("Skirt")) share += v.weights[k];
    return share > 0.5f && v.normal[0] * v.position[0] + v.normal[2] * v.position[2] > 0.06f;
  };
  std::vector<std::array<std::uint32_t, 3>> skirt;
  for (std::size_t k = 0; k < jacket.indices.size(); k += 3) {
    const std::array<std::uint32_t, 3> corners = {jacket.indices[k], jacket.indices[k + 1],
                                                  jacket.indices[k + 2]};
    if (std::ranges::all_of(corners, is_outer_skirt)) skirt.push_back(corners);
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;  // of the trousers, about the hem
  for (std::size_t k = 0; k < trousers.indices.size(); ++k) {
    const std::uint32_t a = trousers.indices[k];
    const std::uint32_t b = trousers.indices[k % 3 == 2 ? k - 2 : k + 1];
    if (trousers.vertices[a].position[1] > 0.6f) edges.insert(std::minmax(a, b));
  }
  ASSERT_GT(skirt.size(), 1000U);
  ASSERT_GT(edges.size(), 1000U);
  std::vector<mesh::MovingVertex> cloth, legs;
  for (double time = 0; time < scene_.duration; time += 0.2) {
    const auto bones = mesh::bone_matrices(model_, scene_.performances[0]->bones_at(time));
    mesh::skin(jacket, bones, cloth);
    mesh::skin(trousers, bones, legs);
    int pierced = 0;
    for (const auto& corners : skirt) {
      std::array<Vec3f, 3> t;
      for (std::size_t k = 0; k < 3; ++k) t[k] = cloth[corners[k]].position;
      const Vec3f low = t[0].cwiseMin(t[1]).cwiseMin(t[2]),
                  high = t[0].cwiseMax(t[1]).cwiseMax(t[2]);
      for (const auto& [a, b] : edges) {
        const Vec3f &p = legs[a].position, &q = legs[b].position;
        if ((p.cwiseMax(q).array() < low.array()).any()) continue;
        if ((p.cwiseMin(q).array() > high.array()).any()) continue;
        pierced += pierces(p, q, t);
      }
    }
    EXPECT_EQ(pierced, 0) << time;
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

TEST_F(LongCharacterHangingRoutine, TailsStayBeforeTheSkirt) {
  const scenes::Mesh &belt = mesh("Belt"), &jacket = mesh("Jacket");
  const auto hips = std::size_t(model_.bone("Hips"));
  int hidden = 0, all = 0;
  std::vector<mesh::MovingVertex> tails, cloth;
  for (double time = 0; time < scene_.duration; time += 0.2) {
    const std::vector<Pose> poses = scene_.performances[0]->bones_at(time);
    const auto bones = mesh::bone_matrices(model_, poses);
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
}  // namespace taut::character_hanging
