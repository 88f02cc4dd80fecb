#include "scenes/character/digit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace taut::scenes {
namespace {

constexpr double usual_radius = 0.008, usual_tip = 0.02;  // m, where there is no skin to measure

double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double t = std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0);
  return (p - a - t * d).norm();
}

}  // namespace

std::string hand_name(Side side) {
  return side == Side::left ? "LeftHand" : "RightHand";
}

Digit::Digit(const Model& model, const Skeleton& skeleton, Side side, const std::string& name) {
  for (std::size_t i = 0; i < 3; ++i) {
    bones_[i] = skeleton.find(hand_name(side) + name + std::to_string(i + 1));
    rest_[i] = skeleton.rest(bones_[i]);
  }
  take_skin(model);
  // The last phalanx has no joint at its end: it goes as far as its skin.
  const Vec3 along = (rest_[2] - rest_[1]).normalized();
  double length = 0;
  for (const Skin& v : skin_)
    if (v.phalanx == 2) length = std::max(length, (v.position - rest_[2]).dot(along));
  rest_[3] = rest_[2] + std::max(length - usual_radius, usual_tip / 2) * along;
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<double> distances;
    for (const Skin& v : skin_)
      if (v.phalanx == k)
        distances.push_back(distance_to_segment(v.position, rest_[k], rest_[k + 1]));
    const auto middle = distances.begin() + std::ssize(distances) / 2;
    if (!distances.empty()) std::nth_element(distances.begin(), middle, distances.end());
    radius_[k] = distances.empty() ? usual_radius : *middle;
  }
  pad_bare_bones();
  std::ranges::stable_sort(skin_, {}, &Skin::phalanx);
  for (const Skin& v : skin_) ++first_[v.phalanx + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
}

void Digit::take_skin(const Model& model) {
  for (const Mesh& mesh : model.meshes) {
    for (const Vertex& vertex : mesh.vertices) {
      Skin v{Vec3(vertex.position[0], vertex.position[1], vertex.position[2]), {}, 1, 0};
      for (std::size_t i = 0; i < 4; ++i) {
        const auto bone = std::ranges::find(bones_, std::size_t{vertex.bones[i]});
        if (vertex.weights[i] <= 0 || bone == bones_.end()) continue;
        v.weights[static_cast<std::size_t>(bone - bones_.begin())] += double{vertex.weights[i]};
        v.of_hand -= double{vertex.weights[i]};
      }
      if (v.of_hand > 0.5) continue;
      v.phalanx = static_cast<std::size_t>(std::ranges::max_element(v.weights) - v.weights.begin());
      skin_.push_back(v);
    }
  }
}

void Digit::pad_bare_bones() {
  for (std::size_t k = 0; k < 3; ++k) {
    if (std::ranges::any_of(skin_, [&](const Skin& v) { return v.phalanx == k; })) continue;
    const Vec3 bone = rest_[k + 1] - rest_[k];
    const Vec3 u = bone.unitOrthogonal(), w = bone.normalized().cross(u);
    Skin v{Vec3::Zero(), {}, 0, k};
    v.weights[k] = 1;
    for (const double share : {0.4, 0.7, 1.0})
      for (int i = 0; i < 8; ++i) {
        const double angle = i * M_PI / 4;
        v.position =
            rest_[k] + share * bone + radius_[k] * (std::cos(angle) * u + std::sin(angle) * w);
        skin_.push_back(v);
      }
  }
}

std::array<Vec3, 4> Digit::joints(const DigitTurns& turns) const {
  std::array<Vec3, 4> at{rest_[0]};
  for (std::size_t k = 0; k < 3; ++k) at[k + 1] = at[k] + turns[k] * (rest_[k + 1] - rest_[k]);
  return at;
}

void Digit::bend(const DigitTurns& turns, BentSkin& skin) const {
  const std::array<Vec3, 4> at = joints(turns);
  std::array<Mat3, 3> turn;
  std::array<Vec3, 3> move;  // of a phalanx: x to turn x + move
  for (std::size_t k = 0; k < 3; ++k) {
    turn[k] = turns[k].toRotationMatrix();
    move[k] = at[k] - turn[k] * rest_[k];
  }
  skin.points.clear();
  skin.first = first_;
  for (const Skin& v : skin_) {
    Vec3 p = v.of_hand * v.position;
    for (std::size_t k = 0; k < 3; ++k)
      if (v.weights[k] > 0) p += v.weights[k] * (turn[k] * v.position + move[k]);
    skin.points.push_back(p);
  }
  for (std::size_t k = 0; k < BentSkin::parts; ++k) {
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Vec3& p : skin.part(k)) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    skin.balls[k] = {(low + high) / 2, (high - low).norm() / 2};
  }
}

}  // namespace taut::scenes
