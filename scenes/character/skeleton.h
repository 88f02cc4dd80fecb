// The bones of a model at rest, and forward kinematics by turns away from it.
#pragma once

#include <string_view>
#include <vector>

#include "scenes/model/model.h"

namespace taut::scenes {

/// Bones placed in the world. A bone's turn takes its rest pose in the model's axes to its present
/// one, so that turns do not depend on how a file orients its bones.
struct Placement {
  std::vector<Vec3> position;  // of the joints, m
  std::vector<Quat> turn;
};

/// The input of forward kinematics: every bone's turn against its parent's, and the root's shift
/// (m).
struct Posture {
  std::vector<Quat> turn;
  Vec3 shift = Vec3::Zero();
};

/// Forward kinematics. An elbow's bone, which carries the cloth over the joint, takes half the turn
/// of the fore arm, so that a bent sleeve is round where a blend of two bones would cut its corner.
class Skeleton {
 public:
  explicit Skeleton(const Model& model);

  std::size_t size() const { return parent_.size(); }
  int parent(std::size_t bone) const { return parent_[bone]; }
  /// Rest position of a joint in the model's axes (m).
  const Vec3& rest(std::size_t bone) const { return rest_[bone]; }
  /// Index of a bone. Throws BadAsset with the model's and the bone's name.
  std::size_t find(std::string_view name) const;
  /// Index of a bone, or -1 where the model has none of that name.
  int maybe(std::string_view name) const { return model_.bone(name); }

  Posture upright() const;  // nothing turned
  Placement place(const Posture& posture) const;
  /// Poses of the bones themselves, as skinning wants them.
  std::vector<Pose> poses(const Placement& placed) const;

 private:
  const Model& model_;
  std::vector<int> parent_;
  std::vector<int> halves_;  // per bone the one whose turn it takes half of, or -1
  std::vector<Vec3> rest_;
  std::vector<Quat> rest_rotation_;
};

}  // namespace taut::scenes
