#include "sim/methods/repositioning.h"

#include <algorithm>
#include <cmath>

#include "sim/topology/room.h"

namespace taut::methods {
namespace {

constexpr double kMore = 1e-6;  // rounding of a particle's mass
constexpr int kDraws = 3;       // times that two particles are drawn together, where one touches
constexpr double kMostDrawn = 100;  // by how much more than if neither did

}  // namespace

void Repositioning::prepare(const World& world, const std::vector<Span>& spans) {
  make_room(world);
  if (dividers_.empty()) dividers_.reserve(room(world).particles + 2);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) weigh(world.connectors[c], c);
  if (!as_printed_) return;
  for (const Span& span : spans) {  // "the end points are set to have infinite mass"
    for (const SpanEnd* end : {&span.a, &span.b}) {
      if (end->kind != SpanEnd::Kind::follower) weight_[span.connector][end->particle] = 0;
    }
  }
}

/// For all connectors that the world has room for, with as much room as any of them.
void Repositioning::make_room(const World& world) {
  if (along_.size() >= world.connectors.size()) return;
  const std::size_t connectors = world.connectors.capacity();
  along_.resize(connectors);
  weight_.resize(connectors);
  flown_.resize(connectors);
  const auto capacity = [](const Connector& c) { return c.position.capacity(); };
  std::size_t most = 0;
  for (const Connector& connector : world.connectors) most = std::max(most, capacity(connector));
  if (double(connectors) * double(most) > kMostRoom) most = 0;
  for (std::size_t c = 0; c < connectors; ++c) {
    const bool cut_off = c >= world.connectors.size();  // later, from any of them
    const std::size_t particles = cut_off ? most : capacity(world.connectors[c]);
    along_[c].reserve(particles);
    weight_[c].reserve(particles);
    flown_[c].reserve(particles);
  }
}

/// Reads the lengths and masses of a connector.
void Repositioning::weigh(const Connector& connector, std::size_t index) {
  const std::size_t n = connector.particles();
  std::vector<double>&along = along_[index], &weight = weight_[index];
  along.assign(n, 0.0);
  weight.assign(n, 1.0);
  for (std::size_t i = 0; i + 1 < n; ++i) along[i + 1] = along[i] + connector.rest[i];
  const bool massless = connector.model == ConnectorModel::span || !(connector.mass > 0);
  double share = 0;  // kg, of the heaviest particle between the ends
  for (std::size_t i = 1; i + 1 < n && !massless; ++i) {
    share = std::max(share, connector.particle_mass[i]);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const double mass = connector.particle_mass[i];
    // An end that carries more than its share of the connector has infinite mass here, as every
    // end in the paper; so a rope's bare end stays one of its particles.
    const bool carries = (i == 0 || i + 1 == n) && mass > share * (1 + kMore);
    weight[i] = carries ? 0 : mass > 0 && share > 0 ? share / mass : 1;
  }
  for (const Hold& hold : connector.holds) weight[hold.particle] = 0;
}

void Repositioning::begin(const World& world) {
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    flown_[c] = world.connectors[c].position;
  }
}

void Repositioning::pass(World& world, const Span& span, BeadTouches& touches, double dt) {
  const Connector& connector = world.connectors[span.connector];
  for (std::size_t k = span.a.particle; k < span.b.particle; ++k) {
    const double squared = (connector.position[k + 1] - connector.position[k]).squaredNorm();
    const double shortest = limits_.shortest * connector.rest[k];
    const double longest = limits_.longest * connector.rest[k];
    const double least = std::max(0.0, shortest - threshold_), most = longest + threshold_;
    if (squared >= least * least && squared <= most * most) continue;
    if (squared == 0) continue;
    draw({world, span.connector, touches, dt}, k, k + 1,
         squared > longest * longest ? longest : shortest);
  }
}

/// Moves two particles to the `wanted` distance (m), each by the other's part of their mass.
void Repositioning::draw(const Where& where, std::size_t i, std::size_t j, double wanted) {
  Connector& connector = where.world.connectors[where.connector];
  const std::vector<double>& weight = weight_[where.connector];
  const double both = weight[i] + weight[j];
  if (both == 0) return;
  Vec3 &p = connector.position[i], &q = connector.position[j];
  const Vec3 apart = q - p;
  const double distance = apart.norm();
  const Vec3 move = apart * ((distance - wanted) / (distance * both));
  const TouchingBead* at_p = where.touches.find(where.connector, i);
  const TouchingBead* at_q = where.touches.find(where.connector, j);
  if (!at_p && !at_q) {
    p += weight[i] * move;
    q -= weight[j] * move;
    return;
  }
  // What a surface keeps from one of them falls to the other; none moves farther than both are off.
  const Vec3 from_p = p, from_q = q;
  double more = 1;
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    p = from_p + std::min(more * weight[i], both) * move;
    q = from_q - std::min(more * weight[j], both) * move;
    if (at_p) p = BeadTouches::allowed(*at_p, p, where.dt);
    if (at_q) q = BeadTouches::allowed(*at_q, q, where.dt);
    const double reached = (distance - (q - p).norm()) / (distance - wanted);
    if (!(reached > 1 / kMostDrawn)) return;  // they can be drawn no nearer
    more /= reached;
  }
}

void Repositioning::stay_in_reach(World& world, const Span& span, BeadTouches& touches, double dt) {
  dividers_.clear();
  dividers_.push_back(span.a.particle);
  for (const TouchingBead& bead : touches.beads()) {
    if (bead.connector != span.connector || bead.role == TouchingBead::Role::free) continue;
    if (bead.particle <= span.a.particle || bead.particle >= span.b.particle) continue;
    dividers_.push_back(bead.particle);
  }
  dividers_.push_back(span.b.particle);
  const Where where{world, span.connector, touches, dt};
  const std::size_t parts = dividers_.size() - 1;
  for (std::size_t k = 0; k < parts; ++k) {
    const std::size_t first = dividers_[k], last = dividers_[k + 1];
    for (const std::size_t end : {first, last}) {
      for (std::size_t i = first + 1; i < last; ++i) reach(where, i, end);
    }
    if (parts > 1) meet(where, last, first);  // a corner that slides stays in reach
  }
  if (!as_printed_) meet(where, span.b.particle, span.a.particle);
}

/// Moves a particle into the reach of an end of its part.
void Repositioning::reach(const Where& where, std::size_t i, std::size_t end) {
  if (weight_[where.connector][end] > 0) return meet(where, i, end);
  const std::vector<double>& along = along_[where.connector];
  std::vector<Vec3>& position = where.world.connectors[where.connector].position;
  const double longest = limits_.longest * std::abs(along[i] - along[end]);
  const Vec3 apart = position[i] - position[end];
  const double squared = apart.squaredNorm();
  if (squared <= longest * longest) return;
  const Vec3 wanted = position[end] + longest / std::sqrt(squared) * apart;
  const TouchingBead* bead = where.touches.find(where.connector, i);
  position[i] = bead ? BeadTouches::allowed(*bead, wanted, where.dt) : wanted;
}

/// Moves a particle and an end into each other's reach, each by the other's part of their mass.
void Repositioning::meet(const Where& where, std::size_t i, std::size_t end) {
  const std::vector<double>& along = along_[where.connector];
  const std::vector<Vec3>& position = where.world.connectors[where.connector].position;
  const double longest = limits_.longest * std::abs(along[i] - along[end]);
  if ((position[end] - position[i]).squaredNorm() <= longest * longest) return;
  draw(where, i, end, longest);
}

void Repositioning::set_velocities(World& world, double dt) const {
  const double rate = 1 / dt;
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Connector& connector = world.connectors[c];
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      connector.velocity[i] += rate * (connector.position[i] - flown_[c][i]);
    }
  }
}

}  // namespace taut::methods
