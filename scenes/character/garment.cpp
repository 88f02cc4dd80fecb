#include "scenes/character/garment.h"

#include <map>

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

}  // namespace taut::scenes
