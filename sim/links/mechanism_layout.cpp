// How a mechanism lays a world out: points, bodies, rows and forces, in room for what may join.
#include <algorithm>
#include <stdexcept>

#include "sim/links/mechanism.h"
#include "sim/topology/room.h"

namespace taut {
namespace {

constexpr double kMassless = -1;

}  // namespace

void Mechanism::rebuild(const World& world) {
  gravity_ = world.gravity;
  reserve(world);
  add_bodies(world);
  add_points(world);
  velocities_ = 3 * points() + 7 * bodies_.size() + world.pulleys.size();
  twists_ = velocities_ + 3 * points();
  add_rows(world);
  add_row_ends();
  material_.rebuild(world, room_, leaders_);
  add_winches(world);
  add_pulleys(world);
  if (material_.any() || has_winches()) {
    force_.reserve(room_);
    force_.resize(points());
    body_push_.resize(bodies_.size());
  }
  point_acceleration_.assign(points(), gravity_);
  direction_.resize(rows_.size());
  violation_.resize(rows_.size());
  rate_.resize(rows_.size());
  velocity_term_.resize(rows_.size());
}

void Mechanism::reserve(const World& world) {
  std::size_t points = 0, joints = 0;
  for (const Connector& connector : world.connectors) {
    points += connector.particles();
    for (const double rest : connector.rest) joints += rest > 0 ? 0 : 1;
  }
  if (room_ > 0 && points <= room_) return;
  const Room all = room(world);
  room_ = all.particles;
  inverse_mass_.reserve(room_);
  point_acceleration_.reserve(room_);
  body_points_.reserve(all.holds);
  prescribed_.reserve(all.holds);
  row_ends_.reserve(2 * all.holds);
  const std::size_t rows = room_ + 2 * joints;
  rows_.reserve(rows);
  direction_.reserve(rows);
  violation_.reserve(rows);
  rate_.reserve(rows);
  velocity_term_.reserve(rows);
}

void Mechanism::add_bodies(const World& world) {
  free_index_.resize(world.bodies.size());
  body_index_.clear();
  for (std::size_t b = 0; b < world.bodies.size(); ++b) {
    const Body& body = world.bodies[b];
    if (body.driven()) continue;
    const std::size_t index = body_index_.size();
    free_index_[b] = index;
    body_index_.push_back(b);
    if (index == bodies_.size()) bodies_.emplace_back();
    const MassProperties& mass = body.mass_properties;
    FreeBody& made = bodies_[index];
    made.inverse_mass = 1 / mass.mass;
    if (made.inertia == mass.inertia) continue;  // as before
    made.inertia = mass.inertia;
    made.rotation = FreeRotation(mass.inertia);
    made.inverse_inertia = made.rotation.inverse_inertia(Quat::Identity());
  }
  bodies_.resize(body_index_.size());
}

void Mechanism::add_points(const World& world) {
  inverse_mass_.clear();
  body_points_.clear();
  prescribed_.clear();
  for (const Connector& connector : world.connectors) {
    const std::size_t first = inverse_mass_.size();
    for (const double mass : connector.particle_mass) {
      inverse_mass_.push_back(mass > 0 ? 1 / mass : kMassless);
    }
    for (const Hold& hold : connector.holds) {
      const std::uint32_t point = small(first + hold.particle);
      inverse_mass_[point] = 0;
      if (is_prescribed(world, hold.to)) {
        prescribed_.emplace_back(point, hold.to);
      } else {
        const Vec3 centre = world.bodies[hold.to.body].mass_properties.centre;
        body_points_.push_back({.point = point,
                                .body = small(free_index_[hold.to.body]),
                                .local = hold.to.point - centre});
      }
    }
  }
  join_points(world);
  if (std::ranges::find(inverse_mass_, kMassless) != inverse_mass_.end()) {
    throw std::invalid_argument("a particle that nothing holds needs a mass");
  }
}

void Mechanism::join_points(const World& world) {
  joined_.clear();
  leaders_.clear();
  if (world.joints.empty()) return;
  find_leaders(world, leaders_);
  std::vector<double> mass;
  for (const Connector& connector : world.connectors) {
    mass.insert(mass.end(), connector.particle_mass.begin(), connector.particle_mass.end());
  }
  for (std::uint32_t p = 0; p < points(); ++p) {
    const std::uint32_t leads = leaders_[p];
    if (leads == p) continue;
    joined_.emplace_back(p, leads);
    inverse_mass_[p] = 0;
    mass[leads] += mass[p];
    if (inverse_mass_[leads] != 0) inverse_mass_[leads] = 1 / mass[leads];
  }
}

void Mechanism::add_rows(const World& world) {
  rows_.clear();
  has_strings_ = taut::has_strings(world);
  std::size_t first = 0;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    const std::size_t rows = connector.stretches() ? 0 : connector.links();
    for (std::size_t k = 0; k < rows; ++k) {
      const double rest = connector.rest[k];
      const int axes = rest > 0 ? 1 : 3;
      for (int axis = 0; axis < axes; ++axis) {
        rows_.push_back({.a = small(first + k),
                         .b = small(first + k + 1),
                         .rest = rest,
                         .axis = rest > 0 ? Row::kAlongLink : axis,
                         .pulls = connector.pulls && rest > 0,
                         .connector = small(c),
                         .link = small(k)});
      }
    }
    first += connector.particles();
  }
  if (!is_joined()) return;
  for (Row& row : rows_) {
    row.a = leaders_[row.a];
    row.b = leaders_[row.b];
  }
}

void Mechanism::add_winches(const World& world) {
  winches_.clear();
  std::size_t first = 0;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    if (connector.winch) {
      const auto index = [](const auto& all, auto found) {
        return small(static_cast<std::size_t>(found - all.begin()));
      };
      Winched added{.winch = connector.winch, .connector = small(c), .first_point = small(first)};
      added.first_row = index(rows_, std::ranges::find(rows_, small(c), &Row::connector));
      const auto& drags = material_.drags();
      const auto drag = std::ranges::find(drags, small(first), &material::DragElement::a);
      if (drag != drags.end()) added.first_drag = index(drags, drag);
      const auto& bends = material_.bends();
      const auto point = &material::BendElement::b;
      added.first_bend = index(bends, std::ranges::lower_bound(bends, first, {}, point));
      added.bends_end =
          index(bends, std::ranges::lower_bound(bends, first + connector.particles(), {}, point));
      winches_.push_back(std::move(added));
    }
    first += connector.particles();
  }
}

void Mechanism::add_row_ends() {
  row_ends_.clear();
  if (body_points_.empty()) return;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    if (inverse_mass_[rows_[r].a] != 0 && inverse_mass_[rows_[r].b] != 0) continue;  // both free
    for (std::size_t i = 0; i < body_points_.size(); ++i) {
      const auto point = body_points_[i].point;
      if (rows_[r].a == point) row_ends_.push_back({small(r), small(i), 1.0});
      if (rows_[r].b == point) row_ends_.push_back({small(r), small(i), -1.0});
    }
  }
}

}  // namespace taut
