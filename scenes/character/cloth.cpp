#include "scenes/character/cloth.h"

#include <algorithm>
#include <map>

#include "scenes/character/capsules.h"
#include "sim/motion/rotation.h"
#include "sim/run/simulation.h"

namespace taut::scenes {
namespace {

constexpr double bending_damping = 0.12;  // s, of the stiffness: a few swings and it is still
constexpr double axial_damping = 0.05;    // s, of the bands' stiffness
constexpr double band_mass = 0.2;         // of a strip's per length: the cloth counts once
constexpr Drag drag = {1.2, 0.02};
constexpr double air_density = 1.2;      // kg/m^3
constexpr double hung_for = 1;           // s, before the first sample
constexpr double time_step = 1.0 / 480;  // s

/// The motion of bones over [0, duration], later by hung_for.
std::map<std::size_t, std::shared_ptr<const Path>> paths_of(const std::vector<std::size_t>& bones,
                                                            double duration, double rate,
                                                            const Placed& placed) {
  std::vector<std::vector<PathKey>> keys(bones.size());
  for (int i = 0; i == 0 || (i - 1) / rate < duration; ++i) {
    const Placement now = placed(i / rate);
    for (std::size_t k = 0; k < bones.size(); ++k)
      keys[k].push_back({hung_for + i / rate, now.position[bones[k]], now.turn[bones[k]]});
  }
  std::map<std::size_t, std::shared_ptr<const Path>> paths;
  for (std::size_t k = 0; k < bones.size(); ++k)
    paths[bones[k]] = std::make_shared<const Path>(std::move(keys[k]));
  return paths;
}

}  // namespace

void Garment::add_chain(std::string panel, std::vector<std::size_t> bones) {
  chains_.push_back({std::move(panel), std::move(bones)});
}

/// Completes a connector of which the particles' places are known.
void Garment::weave(double mass, const Section& section, Connector& strip) const {
  strip.name = fabric_->name;
  strip.radius = fabric_->stand_off;
  strip.links_touch = true;
  strip.drag = drag;
  for (std::size_t k = 1; k < strip.position.size(); ++k) {
    strip.rest.push_back((strip.position[k] - strip.position[k - 1]).norm());
    strip.length += strip.rest.back();
  }
  strip.mass = mass * strip.length;
  strip.velocity.assign(strip.position.size(), Vec3::Zero());
  strip.particle_mass.assign(strip.position.size(),
                             strip.mass / static_cast<double>(strip.position.size()));
  weigh_by_links(strip);
  strip.sections.assign(strip.links(), section);
}

Connector Garment::strip(const Chain& chain, const std::shared_ptr<const Path>& path) const {
  const Pose limb = path->at(0).pose();
  Connector strip;
  for (const std::size_t bone : chain.bones)
    strip.position.push_back(limb.to_world(from_limb(bone)));
  Section section;
  section.bending_stiffness = fabric_->bending_stiffness;
  section.bending_damping = bending_damping * fabric_->bending_stiffness;
  section.diameter = fabric_->width;
  weave(fabric_->mass, section, strip);
  Hold hold;
  hold.to.kind = Attachment::Kind::path;
  hold.to.path = path;
  hold.to.point = from_limb(chain.bones[0]);
  hold.clamp = (from_limb(chain.bones[1]) - from_limb(chain.bones[0])).normalized();
  strip.holds = {hold};
  return strip;
}

/// Joins chains by a band through such a joint of each, and the last one to the first where it is
/// closed.
void Garment::join(const std::vector<std::size_t>& chains, std::size_t joint, bool closed,
                   World& world) const {
  Connector band;
  for (std::size_t i = 0; i < chains.size(); ++i) {
    band.position.push_back(world.connectors[chains[i]].position[joint]);
    world.joints.push_back({{{chains[i], joint}, {world.connectors.size(), i}}});
  }
  if (closed) {
    band.position.push_back(band.position.front());
    world.joints[world.joints.size() - chains.size()].particles.push_back(
        {world.connectors.size(), chains.size()});
  }
  Section section;
  section.axial_stiffness = fabric_->band_stiffness;
  section.axial_damping = axial_damping * fabric_->band_stiffness;
  weave(band_mass * fabric_->mass, section, band);
  world.connectors.push_back(std::move(band));
}

World Garment::world(double duration, double rate, const Placed& placed) const {
  std::vector<std::size_t> moving = {limb_};
  for (const auto& [bone, solid] : obstacles_) moving.push_back(bone);
  const auto paths = paths_of(moving, duration, rate, placed);
  World world;
  world.air.density = air_density;
  for (const auto& [bone, solid] : obstacles_) {
    world.obstacles.push_back(solid);
    world.obstacles.back().path = paths.at(bone);
  }
  std::map<std::string, std::vector<std::size_t>> panels;
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < chains_.size(); ++i) {
    world.connectors.push_back(strip(chains_[i], paths.at(limb_)));
    panels[chains_[i].panel].push_back(i);
    all.push_back(i);
  }
  if (fabric_->band_stiffness > 0) {
    const bool is_slit = panels.size() > 1;
    if (is_slit) join(all, 1, true, world);
    for (const auto& [name, chains] : panels)
      for (std::size_t joint = is_slit ? 2 : 1; joint < chains_[chains[0]].bones.size(); ++joint)
        join(chains, joint, false, world);
  }
  finish(world);
  return world;
}

Track Garment::simulate(double duration, double rate, const Placed& placed) const {
  Eigen::Index rows = 0;
  for (const Chain& chain : chains_) rows += 3 * Eigen::Index(chain.bones.size() - 1);
  Simulation simulation(world(duration, rate, placed), make_method("xpbd", {{"step", time_step}}));
  return Track::sample(duration, rate, [&](double time) {
    simulation.advance_to(hung_for + time);
    const Placement now = placed(time);
    Eigen::VectorXd joints(rows);
    Eigen::Index row = 0;
    for (std::size_t c = 0; c < chains_.size(); ++c) {
      const std::vector<Vec3>& at = std::as_const(simulation).world().connectors[c].position;
      for (std::size_t k = 1; k < at.size(); ++k, row += 3)
        joints.segment<3>(row) = now.turn[limb_].conjugate() * (at[k] - now.position[limb_]);
    }
    return joints;
  });
}

void Garment::hang(const Eigen::VectorXd& joints, Placement& placed) const {
  Eigen::Index row = 0;
  for (const Chain& chain : chains_) {
    Quat turn = placed.turn[limb_];
    Vec3 joint = placed.position[limb_] + turn * from_limb(chain.bones[0]);
    for (std::size_t k = 0; k + 1 < chain.bones.size(); ++k, row += 3) {
      const Vec3 rest = from_limb(chain.bones[k + 1]) - from_limb(chain.bones[k]);
      const Vec3 there =
          placed.position[limb_] + placed.turn[limb_] * Vec3(joints.segment<3>(row)) - joint;
      turn = rotation_between(turn * rest, there) * turn;
      placed.position[chain.bones[k]] = joint;
      placed.turn[chain.bones[k]] = turn;
      joint += turn * rest;
    }
    placed.position[chain.bones.back()] = joint;
    placed.turn[chain.bones.back()] = turn;
  }
}

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
