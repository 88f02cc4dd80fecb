#include "scenes/character/palm.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/character/touch.h"

namespace taut::scenes {

Palm::Palm(const Model& model, const Skeleton& skeleton, std::size_t hand) : skeleton_(skeleton) {
  for (const Mesh& mesh : model.meshes)
    for (const Vertex& v : mesh.vertices) {
      const auto strongest = std::ranges::max_element(v.weights);
      if (*strongest > 0 &&
          v.bones[static_cast<std::size_t>(strongest - v.weights.begin())] == hand)
        skin_.push_back(v);
    }
}

std::vector<Vec3> Palm::bent(const FingerTurns& fingers) const {
  Posture posture = skeleton_.upright();
  for (const auto& [bone, turn] : fingers) posture.turn[bone] = turn;
  const Placement placed = skeleton_.place(posture);
  std::vector<Vec3> points;
  for (const Vertex& v : skin_) {
    const Vec3 rest(v.position[0], v.position[1], v.position[2]);
    Vec3 p = Vec3::Zero();
    for (std::size_t k = 0; k < 4; ++k)
      p += double{v.weights[k]} * (placed.position[v.bones[k]] +
                                   placed.turn[v.bones[k]] * (rest - skeleton_.rest(v.bones[k])));
    points.push_back(p);
  }
  return points;
}

std::vector<double> gaps_along(const std::vector<Vec3>& points, const Capsule& stick,
                               std::span<const double> places) {
  constexpr double half = 8 * mm;
  const Vec3 centre = (stick.a + stick.b) / 2, axis = (stick.b - stick.a).normalized();
  std::vector<double> least(places.size(), std::numeric_limits<double>::infinity());
  for (const Vec3& p : points) {
    const double at = (p - centre).dot(axis);
    for (std::size_t k = 0; k < places.size(); ++k)
      if (std::abs(at - places[k]) < half) least[k] = std::min(least[k], distance(p, stick));
  }
  return least;
}

}  // namespace taut::scenes
