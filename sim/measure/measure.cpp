#include "sim/measure/measure.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "sim/topology/components.h"
#include "sim/world/places.h"
#include "sim/world/winched.h"

namespace taut {
namespace {

/// Sorted: the particles, as connector and number, that are joined with one that is held.
std::vector<std::pair<std::size_t, std::size_t>> held_by_others(const World& world) {
  std::vector<std::pair<std::size_t, std::size_t>> found;
  for (const Joint& joint : world.joints) {
    const Joint::Particle& leads = leader(world, joint);
    if (!holds(world.connectors[leads.connector], leads.particle)) continue;
    for (const auto& [connector, particle] : joint.particles) {
      found.emplace_back(connector, particle);
    }
  }
  std::ranges::sort(found);
  return found;
}

/// Calls `visit(mass, position, velocity)` for every particle that no hold carries. The particles
/// between the ends of a massless span only follow, so they carry nothing.
template <typename Visit>
void each_free_particle(const World& world, Visit visit) {
  const auto joined = held_by_others(world);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    auto hold = connector.holds.begin();
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (hold != connector.holds.end() && hold->particle == i) {
        ++hold;
        continue;
      }
      if (!joined.empty() && std::ranges::binary_search(joined, std::pair(c, i))) continue;
      const bool end = i == 0 || i + 1 == connector.particles();
      if (connector.model == ConnectorModel::span && !end) continue;
      visit(connector.particle_mass[i], connector.position[i], connector.velocity[i]);
    }
  }
}

/// Calls `visit(mass, position, velocity, flow)` for half of every link of a winched connector: at
/// its particle, past which the material moves by `flow` (m/s), held or not.
template <typename Visit>
void each_flow(const World& world, Visit visit) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (!connector.winch) continue;
    const Winch& winch = *connector.winch;
    const PaidOut first = paid_out(world, c, 0, world.time);
    const PaidOut last = paid_out(world, c, 1, world.time);
    for (std::size_t k = 0; k < connector.links(); ++k) {
      const Vec3 way = connector.position[k + 1] - connector.position[k];
      const Vec3 along = connector.stretches() ? Vec3(way / connector.rest[k]) : way.normalized();
      for (const std::size_t i : {k, k + 1}) {
        visit(winch.density * connector.rest[k] / 2, connector.position[i], connector.velocity[i],
              Vec3(winch.flow(i, first, last).speed * along));
      }
    }
  }
}

/// Calls `visit(mass, position)` for the ends of winched connectors whose motion is known
/// beforehand: their mass changes.
template <typename Visit>
void each_held_flow(const World& world, Visit visit) {
  for (const Connector& connector : world.connectors) {
    if (!connector.winch) continue;
    for (const Hold& hold : connector.holds) {
      if (!is_prescribed(world, hold.to)) continue;
      const double link = hold.particle == 0 ? connector.rest.front() : connector.rest.back();
      visit(connector.winch->density * link / 2, connector.position[hold.particle]);
    }
  }
}

template <typename Visit>
void each_free_body(const World& world, Visit visit) {
  for (const Body& body : world.bodies) {
    if (!body.driven()) visit(body);
  }
}

bool dissipates(const World& world) {
  if (std::ranges::any_of(world.pulleys, &Pulley::has_friction)) return true;
  return std::ranges::any_of(world.connectors, [&](const Connector& connector) {
    const bool drags = connector.drag.across > 0 || connector.drag.along > 0;
    return connector.applied_force != nullptr ||
           (world.air.density > 0 && drags && !connector.sections.empty()) ||
           std::ranges::any_of(connector.sections, [](const Section& section) {
             return section.axial_damping > 0 || section.bending_damping > 0 ||
                    section.twisting_damping > 0;
           });
  });
}

}  // namespace

double kinetic_energy(const World& world) {
  double energy = 0;
  each_free_body(world, [&](const Body& body) {
    energy += body.mass_properties.mass * body.velocity.squaredNorm() / 2 +
              body.spin.dot(body.world_inertia() * body.spin) / 2;
  });
  each_free_particle(world, [&](double mass, const Vec3&, const Vec3& velocity) {
    energy += mass * velocity.squaredNorm() / 2;
  });
  each_flow(world, [&](double mass, const Vec3&, const Vec3& velocity, const Vec3& flow) {
    energy += mass * (velocity + flow / 2).dot(flow);
  });
  for (const Pulley& pulley : world.pulleys) {
    energy += pulley.inertia * pulley.speed * pulley.speed / 2;
  }
  return energy;
}

double potential_energy(const World& world) {
  double energy = 0;
  each_free_body(world, [&](const Body& body) {
    energy -= body.mass_properties.mass * world.gravity.dot(body.position);
  });
  each_free_particle(world, [&](double mass, const Vec3& position, const Vec3&) {
    energy -= mass * world.gravity.dot(position);
  });
  each_held_flow(world, [&](double mass, const Vec3& position) {
    energy -= mass * world.gravity.dot(position);
  });
  return energy;
}

double energy(const World& world) {
  const double rigid = kinetic_energy(world) + potential_energy(world);
  return has_materials(world) ? rigid + elastic_energy(world) : rigid;
}

Vec3 linear_momentum(const World& world) {
  Vec3 momentum = Vec3::Zero();
  each_free_body(world,
                 [&](const Body& body) { momentum += body.mass_properties.mass * body.velocity; });
  each_free_particle(
      world, [&](double mass, const Vec3&, const Vec3& velocity) { momentum += mass * velocity; });
  each_flow(world, [&](double mass, const Vec3&, const Vec3&, const Vec3& flow) {
    momentum += mass * flow;
  });
  return momentum;
}

Vec3 angular_momentum(const World& world, const Vec3& about) {
  Vec3 momentum = Vec3::Zero();
  each_free_body(world, [&](const Body& body) {
    momentum += body.mass_properties.mass * (body.position - about).cross(body.velocity) +
                body.world_inertia() * body.spin;
  });
  each_free_particle(world, [&](double mass, const Vec3& position, const Vec3& velocity) {
    momentum += mass * (position - about).cross(velocity);
  });
  each_flow(world, [&](double mass, const Vec3& position, const Vec3&, const Vec3& flow) {
    momentum += mass * (position - about).cross(flow);
  });
  return momentum;
}

double stretch_max(const World& world) {
  double most = 0;
  for (const Connector& connector : world.connectors) {
    for (std::size_t k = 0; k < connector.links(); ++k) {
      const double length = (connector.position[k + 1] - connector.position[k]).norm();
      const double rest = connector.rest[k];
      const double longer = rest > 0 ? length / rest - 1 : length;
      most = larger(most, connector.pulls ? longer : std::abs(longer));
    }
  }
  return most;
}

double moving_mass(const World& world) {
  double mass = 0;
  each_free_body(world, [&](const Body& body) { mass += body.mass_properties.mass; });
  each_free_particle(world, [&](double particle, const Vec3&, const Vec3&) { mass += particle; });
  return mass;
}

double length_scale(const World& world) {
  constexpr double kShort = 1e-3;
  double longest = 0, length = 0;
  for (const Connector& connector : world.connectors) longest = std::max(longest, connector.length);
  // The mean square of the distances from the centre is half the inertia's trace over the mass.
  each_free_body(world, [&](const Body& body) {
    const MassProperties& m = body.mass_properties;
    if (m.mass > 0) length = std::max(length, std::sqrt(m.inertia.trace() / (2 * m.mass)));
  });
  for (const Connector& connector : world.connectors) {
    for (const Hold& hold : connector.holds) {
      if (is_prescribed(world, hold.to)) continue;
      const MassProperties& m = world.bodies[hold.to.body].mass_properties;
      const double arm = (hold.to.point - m.centre).squaredNorm();
      if (m.mass > 0) {
        length = std::max(length, std::sqrt(arm + m.inertia.trace() / (2 * m.mass)));
      }
    }
  }
  return longest > kShort * length ? longest : length;
}

double energy_scale(const World& world) {
  return moving_mass(world) * world.gravity.norm() * length_scale(world) + kinetic_energy(world);
}

bool is_closed(const World& world) {
  const auto rests = [](const Path& path) { return path.keys().size() == 1; };
  const bool bodies = std::ranges::all_of(
      world.bodies, [&](const Body& body) { return !body.driven() || rests(*body.path); });
  return bodies && !dissipates(world) &&
         std::ranges::all_of(world.connectors, [&](const Connector& connector) {
           if (connector.winch && !connector.winch->rests()) return false;
           return std::ranges::all_of(connector.holds, [&](const Hold& hold) {
             return (hold.to.kind != Attachment::Kind::path || rests(*hold.to.path)) &&
                    (!hold.turn || rests(*hold.turn));
           });
         });
}

namespace {

/// The signed share of all directions, of either sense, from which two segments are seen to cross.
double seen_to_cross(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 ac = c - a, ad = d - a, bc = c - b, bd = d - b;
  Vec3 normals[] = {ac.cross(ad), ad.cross(bd), bd.cross(bc), bc.cross(ac)};
  for (Vec3& normal : normals) {
    const double length = normal.norm();
    if (!(length > 0)) return 0;  // in one plane
    normal /= length;
  }
  double angle = 0;
  for (int i = 0; i < 4; ++i) {
    angle += std::asin(std::clamp(normals[i].dot(normals[(i + 1) % 4]), -1.0, 1.0));
  }
  const double side = (d - c).cross(b - a).dot(ac);
  return (side > 0 ? angle : -angle) / (4 * std::numbers::pi);
}

std::size_t segments(const Curve& curve) {
  const std::size_t corners = curve.corners.size();
  return curve.closed || corners == 0 ? corners : corners - 1;
}

const Vec3& corner(const Curve& curve, std::size_t index) {
  return curve.corners[index % curve.corners.size()];
}

/// The curve, closed on a sphere of `radius` (m) about `middle`.
Curve closed_far_away(Curve curve, const Vec3& middle, double radius) {
  if (curve.closed || curve.corners.size() < 2) return curve;
  const auto outwards = [&](const Vec3& from) {
    const Vec3 way = from - middle;
    return way.norm() > 0 ? way.normalized() : Vec3(Vec3::UnitX());
  };
  const Vec3 first = outwards(curve.corners.front()), last = outwards(curve.corners.back());
  Vec3 axis = last.cross(first);
  if (!(axis.norm() > 1e-9)) axis = last.unitOrthogonal();
  axis.normalize();
  constexpr int kParts = 8;
  const double turn = std::atan2(last.cross(first).dot(axis), last.dot(first));
  for (int i = 0; i <= kParts; ++i) {
    const Vec3 at = Eigen::AngleAxisd(turn * i / kParts, axis) * last;
    curve.corners.push_back(middle + radius * at);
  }
  curve.closed = true;
  return curve;
}

}  // namespace

Curve curve_of(const World& world, std::size_t connector) {
  Curve made{world.connectors[connector].position};
  const std::size_t last = made.corners.size() - 1;
  for (const Joint& joint : world.joints) {
    const auto ties = [&](std::size_t particle) {
      return std::ranges::any_of(joint.particles, [&](const Joint::Particle& at) {
        return at.connector == connector && at.particle == particle;
      });
    };
    made.closed = made.closed || (last > 0 && ties(0) && ties(last));
  }
  if (made.closed) made.corners.pop_back();
  return made;
}

int linking_number(const Curve& one, const Curve& other) {
  Vec3 middle = Vec3::Zero();
  for (const Curve* curve : {&one, &other}) {
    for (const Vec3& at : curve->corners) middle += at;
  }
  middle /=
      static_cast<double>(std::max<std::size_t>(one.corners.size() + other.corners.size(), 1));
  double size = 0;
  for (const Curve* curve : {&one, &other}) {
    for (const Vec3& at : curve->corners) size = std::max(size, (at - middle).norm());
  }
  // Of different size, so that what closes one is apart from what closes the other.
  const Curve a = closed_far_away(one, middle, 10 * size);
  const Curve b = closed_far_away(other, middle, 20 * size);
  double sum = 0;
  for (std::size_t i = 0; i < segments(a); ++i) {
    for (std::size_t k = 0; k < segments(b); ++k) {
      sum += seen_to_cross(corner(a, i), corner(a, i + 1), corner(b, k), corner(b, k + 1));
    }
  }
  return static_cast<int>(std::lround(sum));
}

double writhe(const Curve& curve) {
  double sum = 0;
  for (std::size_t i = 0; i < segments(curve); ++i) {
    for (std::size_t k = i + 2; k < segments(curve); ++k) {
      sum += seen_to_cross(corner(curve, i), corner(curve, i + 1), corner(curve, k),
                           corner(curve, k + 1));
    }
  }
  return 2 * sum;
}

}  // namespace taut
