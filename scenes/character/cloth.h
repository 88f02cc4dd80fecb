// Cloth that hangs on a character: the skirt of the jacket, the cuffs and the belt's tails.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "scenes/character/skeleton.h"
#include "scenes/character/track.h"
#include "sim/world/state.h"

namespace taut::scenes {

// A garment: strips of cloth that hang from a limb, as connectors.

/// Where a body is at a time (s).
using Placed = std::function<Placement(double time)>;

/// Chains of bones of one fabric that hang from one limb. Each chain is a connector of a link from
/// joint to joint, clamped to the limb in its direction at rest, that resists bending, meets the
/// air and touches limbs, or cloth beneath. Chains whose names differ by a letter, PanelA1, PanelB1
/// and so on, are a panel: a band of cloth joins each to the next at every joint. What hangs as
/// several panels is closed at the first joint, and slit below.
class Garment {
 public:
  Garment(const Skeleton& skeleton, const Fabric& fabric, std::size_t limb)
      : skeleton_(&skeleton), fabric_(&fabric), limb_(limb) {}

  const Fabric& fabric() const { return *fabric_; }
  std::size_t limb() const { return limb_; }
  /// A chain's bones from the limb on; the last one has no length.
  void add_chain(std::string panel, std::vector<std::size_t> bones);
  /// A solid in the axes of a bone at rest.
  void add_obstacle(std::size_t bone, Obstacle solid) { obstacles_.emplace_back(bone, solid); }

  /// Where the joints are over [0, duration] (s), `rate` samples a second: 3 rows for each but the
  /// first of a chain, from the limb's joint, in the limb's axes (m). It hangs still before.
  Track simulate(double duration, double rate, const Placed& placed) const;
  /// Turns the chains' bones so that their joints are there.
  void hang(const Eigen::VectorXd& joints, Placement& placed) const;

 private:
  struct Chain {
    std::string panel;
    std::vector<std::size_t> bones;
  };
  World world(double duration, double rate, const Placed& placed) const;
  Connector strip(const Chain& chain, const std::shared_ptr<const Path>& path) const;
  void join(const std::vector<std::size_t>& chains, std::size_t joint, bool closed,
            World& world) const;
  void weave(double mass, const Section& section, Connector& strip) const;
  Vec3 from_limb(std::size_t bone) const { return skeleton_->rest(bone) - skeleton_->rest(limb_); }

  const Skeleton* skeleton_;
  const Fabric* fabric_;
  std::size_t limb_;
  std::vector<Chain> chains_;
  std::vector<std::pair<std::size_t, Obstacle>> obstacles_;  // with the bones that carry them
};

/// All garments of a model; each may touch those before it.
class HangingCloth {
 public:
  /// None where the model has no bones for it.
  HangingCloth(const Model& model, const Skeleton& skeleton);

  /// Simulates all of it over [0, duration] (s), `rate` samples a second.
  void simulate(double duration, double rate, const Placed& placed);
  /// Turns the bones of all that hangs to where it has been simulated to be.
  void hang(double time, Placement& placed) const;

 private:
  std::vector<Garment> garments_;
  std::vector<Track> motions_;  // of those that have been simulated
};

}  // namespace taut::scenes
