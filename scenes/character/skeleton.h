// A skeleton: the bones of a model at rest and their names, poses over time, forward kinematics,
// and limbs of two bones that reach a point.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "scenes/model/model.h"
#include "sim/motion/types.h"

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
  /// How a bone is turned at rest, in the model's axes.
  const Quat& rest_rotation(std::size_t bone) const { return rest_rotation_[bone]; }
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

// The poses of a character's bones over time, worked out before the simulation runs.

class Performance {
 public:
  virtual ~Performance() = default;
  /// World-space pose of every bone (order of Model::bones) at `time` (s); a pure function of time.
  virtual std::vector<Pose> bones_at(double time) const = 0;
  /// The pose of a bone that is not of cloth, at less cost. Throws std::out_of_range.
  virtual Pose limb_at(std::size_t bone, double time) const { return bones_at(time).at(bone); }
};

// The fabrics of a character's clothes: which of its bones are cloth that hangs, and of what.

/// What chains of bones are made of: strips of cloth that hang from a limb side by side.
struct Fabric {
  std::string_view name;     // of the bones, after the side: SkirtFrontA1, LeftCuffB1
  double mass;               // kg/m, of a strip
  double bending_stiffness;  // EI of a strip, N m^2
  double width;              // m, of a strip, that the air meets
  double band_stiffness;     // EA of the cloth between one strip and the next, N; 0: none
  std::string_view touches;  // the bones' names, after the side: of the limb that it hangs on if it
                             // has that name, else of all that begin so
  double stand_off;          // m, from the middle of the cloth to what it touches
};

/// A bone's name without its side.
std::string_view without_side(std::string_view bone);

/// The fabric of the bone of that name; null: it is not of cloth that hangs.
const Fabric* fabric_of(std::string_view bone);

// Limbs: two bones that reach a point.

/// How far (m) the hand's path at `time` is beyond the reach of a standing body; 0: within reach.
/// Only for performances of make_performance().
double beyond_reach(const Performance& performance, double time);

/// The two bones of a limb at rest: from its root joint to the middle one, and on to its end (m).
struct Limb {
  Vec3 upper = Vec3::Zero(), lower = Vec3::Zero();
  Vec3 bends = Vec3::Zero();  // towards which it bends if it is straight at rest

  /// The farthest that the end gets from the root without the middle joint snapping straight.
  double reach() const { return 0.998 * (upper.norm() + lower.norm()); }
};

/// Rotations of the two bones (from the model's axes at rest to the world), and the middle joint
/// (m).
struct LimbTurns {
  Quat upper, lower;
  Vec3 middle;
};

/// Bends a limb from `root` to `target` by the law of cosines, in the plane that contains `pole`.
/// The middle joint keeps its sense of bending at rest. Towards a target beyond reach the limb is
/// stretched out.
LimbTurns bend_limb(const Limb& limb, const Vec3& root, const Vec3& target, const Vec3& pole);

/// The part of a rotation that turns about `axis` (unit), rad in (-pi, pi].
double twist_about(const Quat& rotation, const Vec3& axis);

// The names of a figure's bones, and models with other names.

/// The bones that a figure needs. It also moves others, such as fingers, if the model has them.
const std::vector<std::string_view>& needed_bones();

/// All names that a figure knows: needed bones, fingers, toes, and bones of the face.
const std::vector<std::string_view>& known_bones();

/// Pairs of a figure's name for a bone and the model's.
using BoneNames = std::vector<std::pair<std::string, std::string>>;

/// The names of a Mixamo character: the figure's with a prefix ("mixamorig:", "mixamorig2:"), and
/// Spine2 for the Chest.
BoneNames mixamo_names(const Model& model);

/// Gives the model's bones the figure's names. Another bone that has such a name is renamed. Throws
/// BadAsset, which names all bones that the model lacks.
void rename_bones(Model& model, const BoneNames& names);

/// Throws BadAsset, which names all needed bones that the model lacks and possible remedies.
void check_bones(const Model& model);

}  // namespace taut::scenes
