#include "scenes/character/hanging_cloth.h"

#include <algorithm>

#include "scenes/character/capsules.h"
#include "sim/motion/rotation.h"

namespace taut::scenes {
namespace {

/// How round a body is beneath a strip of cloth, m.
constexpr double cloth_curvature = 0.10;
constexpr double cloth_friction = 0.3;
/// Strips of few links tremble where they strike a leg; thick cloth does not.
constexpr double trembling = 0.02;  // s

bool is_cloth(const Model& model, const Mesh& mesh) {
  return std::ranges::any_of(mesh.vertices, [&](const Vertex& v) {
    return v.weights[0] > 0 && fabric_of(model.bones[v.bones[0]].name);
  });
}

/// A bone of the model that goes on from `bone`; itself where none does.
std::size_t onward(const Model& model, std::size_t bone) {
  const bool hangs = fabric_of(model.bones[bone].name);
  for (std::size_t child = bone + 1; child < model.bones.size(); ++child)
    if (model.bones[child].parent == int(bone) && hangs == !!fabric_of(model.bones[child].name))
      return child;
  return bone;
}

/// A capsule along y from `from` to `to`.
Obstacle between(const Vec3& from, const Vec3& to, double radius) {
  Obstacle solid;
  solid.shape = capsule_shape(radius, (to - from).norm());
  solid.place.position = (from + to) / 2;
  solid.static_friction = solid.kinetic_friction = cloth_friction;
  solid.place.rotation = rotation_between(Vec3::UnitY(), to - from);
  return solid;
}

/// A limb: it holds nearly all of the skin, and nothing of cloth that hangs.
Obstacle limb_solid(const Model& model, const Skeleton& skeleton, std::size_t limb) {
  const Vec3 joint = skeleton.rest(limb), next = skeleton.rest(onward(model, limb));
  std::vector<double> distances;
  for (const Mesh& mesh : model.meshes) {
    if (is_cloth(model, mesh)) continue;
    for (const Vertex& v : mesh.vertices) {
      const auto most = std::size_t(std::ranges::max_element(v.weights) - v.weights.begin());
      if (!(v.weights[most] > 0) || v.bones[most] != limb) continue;
      const Vec3 point(v.position[0], v.position[1], v.position[2]);
      distances.push_back(point_distance(point, joint, next));
    }
  }
  std::ranges::sort(distances);
  const double radius = distances.empty() ? 0 : distances[distances.size() * 98 / 100];
  // It begins in the trunk.
  const Vec3 along = next - joint;
  const double begin = std::min(radius, along.norm());
  return between(begin * along.normalized(), along, radius);
}

/// What is beneath a strip of cloth that hangs round a limb: as high as the strip.
Obstacle cloth_solid(const Model& model, const Skeleton& skeleton, std::size_t bone,
                     std::size_t limb) {
  const Vec3 along = skeleton.rest(onward(model, bone)) - skeleton.rest(bone);
  const Vec3 out = skeleton.rest(bone) + along / 2 - skeleton.rest(limb);
  const Vec3 square = (out - out.dot(along) / along.squaredNorm() * along).normalized();
  return between(-cloth_curvature * square, along - cloth_curvature * square, cloth_curvature);
}

}  // namespace

HangingCloth::HangingCloth(const Model& model, const Skeleton& skeleton) {
  const auto parent_of = [&](std::size_t bone) {
    return static_cast<std::size_t>(skeleton.parent(bone));
  };
  for (std::size_t bone = 0; bone < skeleton.size(); ++bone) {
    const std::string& name = model.bones[bone].name;
    const Fabric* fabric = fabric_of(name);
    if (!fabric || skeleton.parent(bone) < 0 || fabric_of(model.bones[parent_of(bone)].name))
      continue;
    std::vector<std::size_t> bones = {bone};
    while (onward(model, bones.back()) != bones.back())
      bones.push_back(onward(model, bones.back()));
    if (bones.size() < 2) continue;
    const std::size_t limb = parent_of(bone);
    const auto same = [&](const Garment& garment) {
      return &garment.fabric() == fabric && garment.limb() == limb;
    };
    auto garment = std::ranges::find_if(garments_, same);
    if (garment == garments_.end()) {
      garments_.emplace_back(skeleton, *fabric, limb);
      garment = std::prev(garments_.end());
      const bool is_sleeve = without_side(model.bones[limb].name) == fabric->touches;
      for (std::size_t other = 0; other < skeleton.size(); ++other) {
        if (!without_side(model.bones[other].name).starts_with(fabric->touches)) continue;
        if ((is_sleeve && other != limb) || onward(model, other) == other) continue;
        garment->add_obstacle(other, fabric_of(model.bones[other].name)
                                         ? cloth_solid(model, skeleton, other, limb)
                                         : limb_solid(model, skeleton, other));
      }
    }
    garment->add_chain(name.substr(0, name.size() - 2), std::move(bones));
  }
  std::ranges::stable_sort(garments_, {}, [](const Garment& garment) { return &garment.fabric(); });
}

void HangingCloth::simulate(double duration, double rate, const Placed& placed) {
  motions_.clear();
  for (const Garment& garment : garments_) {
    const Track motion = garment.simulate(duration, rate, [&](double time) {
      Placement now = placed(time);
      hang(time, now);
      return now;
    });
    motions_.push_back(motion.smoothed(trembling));
  }
}

void HangingCloth::hang(double time, Placement& placed) const {
  for (std::size_t i = 0; i < motions_.size(); ++i) garments_[i].hang(motions_[i].at(time), placed);
}

}  // namespace taut::scenes
