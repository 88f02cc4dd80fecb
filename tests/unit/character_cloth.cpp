// The martial artist's clothes on his body, as they are drawn: with the arms raised as far as arms
// go, the jacket neither tears nor turns inside out, and nothing comes through it.
#include <gtest/gtest.h>

#include <cmath>

#include "render/skinning.h"
#include "scenes/character/skeleton.h"

namespace taut {
namespace {

using Vec3f = Eigen::Vector3f;
constexpr double degree = M_PI / 180;

class CharacterCloth : public testing::Test {
 protected:
  /// Both upper arms so far above the horizontal and so far forward (degrees). The shoulder blades
  /// take a third of the way up, as they do.
  std::vector<BoneMatrix> raised(double above, double forward) const {
    const Skeleton skeleton(model_);
    Posture posture = skeleton.upright();
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
    return bone_matrices(model_, skeleton.poses(skeleton.place(posture)));
  }

  const Mesh& mesh(std::string_view name) const {
    for (const Mesh& m : model_.meshes)
      if (m.name == name) return m;
    throw std::out_of_range(std::string(name));
  }

  std::vector<MovingVertex> skinned(const Mesh& m, const std::vector<BoneMatrix>& bones) const {
    std::vector<MovingVertex> vertices;
    skin(m, bones, vertices);
    return vertices;
  }
  std::vector<MovingVertex> at_rest(const Mesh& m) const {
    std::vector<MovingVertex> vertices;
    for (const Vertex& v : m.vertices)
      vertices.push_back({Vec3f(v.position.data()), Vec3f(v.normal.data())});
    return vertices;
  }

  const Model model_ = load_model(TAUT_SOURCE_DIR "/assets/martial_artist.glb");
};

/// Whether a triangle faces against the normals of its corners.
bool is_inside_out(const MovingVertex& a, const MovingVertex& b, const MovingVertex& c) {
  return (b.position - a.position)
             .cross(c.position - a.position)
             .dot(a.normal + b.normal + c.normal) < 0;
}

TEST_F(CharacterCloth, ARaisedArmNeitherTearsTheJacketNorTurnsItInsideOut) {
  const Mesh& jacket = mesh("Jacket");
  const auto rest = at_rest(jacket);
  for (const auto& [above, forward] : {std::pair{0, 0}, {0, 60}, {30, 0}, {30, 60}}) {
    const auto now = skinned(jacket, raised(above, forward));
    double most = 0;
    int turned = 0;
    for (std::size_t i = 0; i < jacket.indices.size(); i += 3) {
      const std::uint32_t* t = &jacket.indices[i];
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t a = t[k], b = t[(k + 1) % 3];
        const double length = double((rest[b].position - rest[a].position).norm());
        // Of a thread shorter than 3 mm nobody sees how far it stretches.
        if (length > 0.003)
          most = std::max(most, double((now[b].position - now[a].position).norm()) / length);
      }
      turned += is_inside_out(now[t[0]], now[t[1]], now[t[2]]) &&
                !is_inside_out(rest[t[0]], rest[t[1]], rest[t[2]]);
    }
    EXPECT_LT(most, 2.5) << above << ", " << forward;
    EXPECT_LE(turned, 5) << above << ", " << forward;
  }
}

/// How often the ray from `from` along `direction` meets a mesh within a hand's breadth.
int crossings(const Vec3f& from, const Vec3f& direction, const std::vector<MovingVertex>& vertices,
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
  const Mesh &jacket = mesh("Jacket"), &hand = mesh("HandR");
  const auto cloth = at_rest(jacket), arm = at_rest(hand);
  std::vector<std::size_t> covered;
  for (std::size_t i = 0; i < arm.size(); i += 3)
    if (crossings(arm[i].position, arm[i].normal, cloth, jacket.indices) > 0) covered.push_back(i);
  ASSERT_GT(covered.size(), 100u);
  const Skeleton skeleton(model_);
  for (const double bend : {0.0, 50.0, 100.0}) {
    Posture posture = skeleton.upright();
    const Vec3 upper =
        skeleton.rest(skeleton.find("RightForeArm")) - skeleton.rest(skeleton.find("RightArm"));
    const Vec3 hinge = upper.cross(Vec3::UnitZ()).normalized();  // the fore arm rises forward
    posture.turn[skeleton.find("RightForeArm")] = Eigen::AngleAxisd(bend * degree, hinge);
    const auto bones = bone_matrices(model_, skeleton.poses(skeleton.place(posture)));
    const auto bent = skinned(jacket, bones), skin_now = skinned(hand, bones);
    int bare = 0;
    for (const std::size_t i : covered)
      bare += crossings(skin_now[i].position, skin_now[i].normal.normalized(), bent,
                        jacket.indices) == 0;
    EXPECT_LE(bare, int(covered.size() / 50)) << bend;
  }
}

}  // namespace
}  // namespace taut
