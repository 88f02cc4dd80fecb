// The martial artist's clothes on his body, as they are drawn: with the arms raised as far as arms
// go, the jacket neither tears nor turns inside out, and nothing comes through it.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "render/mesh/skinning.h"
#include "scenes/character/skeleton.h"
#include "scenes/model/load_model.h"

namespace taut::character_cloth {
namespace {

using Vec3f = Eigen::Vector3f;
constexpr double degree = M_PI / 180;

class CharacterCloth : public testing::Test {
 protected:
  /// Both upper arms so far above the horizontal and so far forward (degrees). The shoulder blades
  /// take a third of the way up, as they do.
  std::vector<mesh::BoneMatrix> raised(double above, double forward) const {
    const scenes::Skeleton skeleton(model_);
    scenes::Posture posture = skeleton.upright();
    constexpr double at_rest = 40;  // degrees below the horizontal
    const double way = (above + at_rest) * degree, blade = way / 3;
    for (const auto& [side, sign] : {std::pair<std::string, double>{"Left", 1}, {"Right", -1}}) {
      const auto about = [&](const Vec3& axis, double angle) {
        return Quat(Eigen::AngleAxisd(sign * angle, axis));
      };
      posture.turn[skeleton.find(side + "Shoulder")] = about(Vec3::UnitZ(), blade);
      posture.turn[skeleton.find(side + "Arm")] =
          about(Vec3::UnitY(), -forward * degree) * about(Vec3::UnitZ(), way - blade);
    }
    return mesh::bone_matrices(model_, skeleton.poses(skeleton.place(posture)));
  }

  const scenes::Mesh& mesh(std::string_view name) const {
    for (const scenes::Mesh& m : model_.meshes)
      if (m.name == name) return m;
    throw std::out_of_range(std::string(name));
  }

  std::vector<mesh::MovingVertex> skinned(const scenes::Mesh& m,
                                          const std::vector<mesh::BoneMatrix>& bones) const {
    std::vector<mesh::MovingVertex> vertices;
    mesh::skin(m, bones, vertices);
    return vertices;
  }
  std::vector<mesh::MovingVertex> at_rest(const scenes::Mesh& m) const {
    std::vector<mesh::MovingVertex> vertices;
    for (const scenes::Vertex& v : m.vertices)
      vertices.push_back({Vec3f(v.position.data()), Vec3f(v.normal.data())});
    return vertices;
  }

  const scenes::Model model_ = scenes::load_model(TAUT_SOURCE_DIR "/assets/martial_artist.glb");
};

/// Whether a triangle faces against the normals of its corners.
bool is_inside_out(const mesh::MovingVertex& a, const mesh::MovingVertex& b,
                   const mesh::MovingVertex& c) {
  return (b.position - a.position)
             .cross(c.position - a.position)
             .dot(a.normal + b.normal + c.normal) < 0;
}

/// Arms straight up take the way from elbow to belt from 0.43 m over the arm pit to 0.67 m past it:
/// cloth that shares this evenly stretches to 1.6 of its length, and some threads more than others.
TEST_F(CharacterCloth, ARaisedArmNeitherTearsTheJacketNorTurnsItInsideOut) {
  const scenes::Mesh& jacket = mesh("Jacket");
  const auto rest = at_rest(jacket);
  for (const auto& [above, forward] :
       {std::pair{-75, 20}, {0, 0}, {0, 60}, {30, 0}, {30, 60}, {60, 0}, {60, 60}, {90, 0}}) {
    const auto now = skinned(jacket, raised(above, forward));
    double most = 0, turned = 0, all = 0;  // m2
    for (std::size_t i = 0; i < jacket.indices.size(); i += 3) {
      const std::uint32_t* t = &jacket.indices[i];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        const double length = double((rest[b].position - rest[a].position).norm());
        // Of a thread shorter than 3 mm nobody sees how far it stretches.
        if (length > 0.003)
          most = std::max(most, double((now[b].position - now[a].position).norm()) / length);
      }
      const double area = 0.5 * double((now[t[1]].position - now[t[0]].position)
                                           .cross(now[t[2]].position - now[t[0]].position)
                                           .norm());
      all += area;
      if (is_inside_out(now[t[0]], now[t[1]], now[t[2]]) &&
          !is_inside_out(rest[t[0]], rest[t[1]], rest[t[2]]))
        turned += area;
    }
    EXPECT_LT(most, 2.2) << above << ", " << forward;
    EXPECT_LT(turned, 1e-4 * all) << above << ", " << forward;
  }
}

/// Every edge has a triangle on either side, so that no pose opens a crack; but edges between
/// vertices at one place, which have the same weights and stay together.
TEST_F(CharacterCloth, TheJacketHasNoCracksWithTheArmsStraightUp) {
  const scenes::Mesh& jacket = mesh("Jacket");
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (std::size_t i = 0; i < jacket.indices.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = jacket.indices[i + k], b = jacket.indices[i + (k + 1) % 3];
      sides[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
    }
  const auto now = skinned(jacket, raised(90, 0));
  ASSERT_GT(sides.size(), 10000u);
  for (const auto& [edge, sum] : sides) {
    if (sum == 0) continue;
    EXPECT_LT((now[edge.first].position - now[edge.second].position).norm(), 1e-4f);
  }
}

/// How often the ray from `from` along `direction` meets a mesh within a hand's breadth.
int crossings(const Vec3f& from, const Vec3f& direction,
              const std::vector<mesh::MovingVertex>& vertices,
              const std::vector<std::uint32_t>& indices) {
  int count = 0;
  for (std::size_t i = 0; i < indices.size(); i += 3) {
    // Moller and Trumbore (1997).
    const Vec3f& a = vertices[indices[i]].position;
    const Vec3f u = vertices[indices[i + 1]].position - a,
                v = vertices[indices[i + 2]].position - a;
    const Vec3f s = from - a, h = direction.cross(v), q = s.cross(u);
    const float determinant = u.dot(h);
    if (std::abs(determinant) < 1e-14f) continue;
    const float x = s.dot(h) / determinant, y = direction.dot(q) / determinant;
    const float way = v.dot(q) / determinant;
    count += x >= 0 && y >= 0 && x + y <= 1 && way > 0 && way < 0.12f;
  }
  return count;
}

TEST_F(CharacterCloth, TheForeArmStaysInItsSleeve) {
  const scenes::Mesh &jacket = mesh("Jacket"), &guard = mesh("GuardR");
  const auto cloth = at_rest(jacket), arm = at_rest(guard);
  std::vector<std::size_t> covered;
  for (std::size_t i = 0; i < arm.size(); i += 2)
    if (crossings(arm[i].position, arm[i].normal, cloth, jacket.indices) > 0) covered.push_back(i);
  ASSERT_GT(covered.size(), 100u);
  const scenes::Skeleton skeleton(model_);
  for (const double bend : {0.0, 50.0, 100.0}) {
    scenes::Posture posture = skeleton.upright();
    const Vec3 upper =
        skeleton.rest(skeleton.find("RightForeArm")) - skeleton.rest(skeleton.find("RightArm"));
    const Vec3 hinge = upper.cross(Vec3::UnitZ()).normalized();  // the fore arm rises forward
    posture.turn[skeleton.find("RightForeArm")] = Eigen::AngleAxisd(bend * degree, hinge);
    const auto bones = mesh::bone_matrices(model_, skeleton.poses(skeleton.place(posture)));
    const auto bent = skinned(jacket, bones), arm_now = skinned(guard, bones);
    int bare = 0;
    for (const std::size_t i : covered)
      bare +=
          crossings(arm_now[i].position, arm_now[i].normal.normalized(), bent, jacket.indices) == 0;
    EXPECT_LE(bare, int(covered.size() / 50)) << bend;
  }
}

/// A blend of two bones 120 degrees apart draws the cloth halfway between them in to cos 60 degrees
/// of its distance from the joint, a chord; with a bone between them it stays beyond the cosine of
/// 45 degrees, wherever between two of the three.
TEST_F(CharacterCloth, ABentElbowIsRound) {
  constexpr double bend = 120;
  const scenes::Mesh& jacket = mesh("Jacket");
  const auto cloth = at_rest(jacket);
  const scenes::Skeleton skeleton(model_);
  const Vec3 joint = skeleton.rest(skeleton.find("RightForeArm"));
  const Vec3 along = (joint - skeleton.rest(skeleton.find("RightArm"))).normalized();
  scenes::Posture posture = skeleton.upright();
  posture.turn[skeleton.find("RightForeArm")] =
      Eigen::AngleAxisd(bend * degree, along.cross(Vec3::UnitZ()).normalized());
  const scenes::Placement placed = skeleton.place(posture);
  const auto bent = skinned(jacket, mesh::bone_matrices(model_, skeleton.poses(placed)));
  int outside = 0;
  for (std::size_t i = 0; i < cloth.size(); ++i) {
    const Vec3 from = cloth[i].position.cast<double>() - joint;
    if (from.norm() > 0.09 || std::abs(from.dot(along)) > 0.02 || from.z() > -0.05) continue;
    ++outside;
    const double now =
        (bent[i].position.cast<double>() - placed.position[skeleton.find("RightForeArm")]).norm();
    EXPECT_GT(now, std::cos(45 * degree) * from.norm()) << "vertex " << i;
  }
  EXPECT_GT(outside, 4);
}

}  // namespace
}  // namespace taut::character_cloth
