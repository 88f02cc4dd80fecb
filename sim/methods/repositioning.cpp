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

Repositioning::Strand Repositioning::strand(World& world, const Span& span,
                                            const BeadTouches& touches, double dt) const {
  const std::size_t c = span.connector;
  return {world.connectors[c].position,       along_[c], weight_[c], c,
          touches.any() ? &touches : nullptr, dt};
}

void Repositioning::pass(World& world, const Span& span, const BeadTouches& touches,
                         double dt) const {
  const Strand at = strand(world, span, touches, dt);
  const std::vector<double>& rest = world.connectors[span.connector].rest;
  for (std::size_t k = span.a.particle; k < span.b.particle; ++k) {
    const double squared = (at.position[k + 1] - at.position[k]).squaredNorm();
    const double shortest = limits_.shortest * rest[k];
    const double longest = limits_.longest * rest[k];
    const double least = std::max(0.0, shortest - threshold_), most = longest + threshold_;
    if (squared >= least * least && squared <= most * most) continue;
    if (squared == 0) continue;
    draw(at, k, k + 1, squared, squared > longest * longest ? longest : shortest);
  }
}

/// Moves two particles, whose distance has this square, to the `wanted` distance (m), each by the
/// other's part of their mass.
void Repositioning::draw(const Strand& strand, std::size_t i, std::size_t j, double squared,
                         double wanted) {
  const double both = strand.weight[i] + strand.weight[j];
  if (both == 0) return;
  Vec3 &p = strand.position[i], &q = strand.position[j];
  const double distance = std::sqrt(squared);
  const Vec3 move = (q - p) * ((distance - wanted) / (distance * both));
  if (strand.touches) return draw_at_surfaces(strand, i, j, move, wanted);
  p += strand.weight[i] * move;
  q -= strand.weight[j] * move;
}

/// The same where the surfaces that they touch let them: what is kept from one of them falls to the
/// other, and none moves farther than both are off.
void Repositioning::draw_at_surfaces(const Strand& strand, std::size_t i, std::size_t j,
                                     const Vec3& move, double wanted) {
  const double weight_i = strand.weight[i], weight_j = strand.weight[j];
  const double both = weight_i + weight_j;
  Vec3 &p = strand.position[i], &q = strand.position[j];
  const Vec3 from_p = p, from_q = q;
  const TouchingBead* at_p = strand.touches->find(strand.connector, i);
  const TouchingBead* at_q = strand.touches->find(strand.connector, j);
  if (!at_p && !at_q) {
    p += weight_i * move;
    q -= weight_j * move;
    return;
  }
  const double distance = (q - p).norm();
  double more = 1;
  for (int attempt = 0; attempt < kDraws; ++attempt) {
    p = from_p + std::min(more * weight_i, both) * move;
    q = from_q - std::min(more * weight_j, both) * move;
    if (at_p) p = BeadTouches::allowed(*at_p, p, strand.dt);
    if (at_q) q = BeadTouches::allowed(*at_q, q, strand.dt);
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
  const Strand at = strand(world, span, touches, dt);
  const std::size_t parts = dividers_.size() - 1;
  for (std::size_t k = 0; k < parts; ++k) {
    const std::size_t first = dividers_[k], last = dividers_[k + 1];
    for (const std::size_t end : {first, last}) reach(at, first, last, end);
    if (parts > 1) meet(at, last, first);  // a corner that slides stays in reach
  }
  if (!as_printed_) meet(at, span.b.particle, span.a.particle);
}

/// Moves the particles between two into the reach of one of these, `end`.
void Repositioning::reach(const Strand& strand, std::size_t first, std::size_t last,
                          std::size_t end) const {
  if (strand.weight[end] > 0) {
    for (std::size_t i = first + 1; i < last; ++i) meet(strand, i, end);
    return;
  }
  const Vec3 place = strand.position[end];
  const double along = strand.along[end];
  for (std::size_t i = first + 1; i < last; ++i) {
    const double longest = limits_.longest * std::abs(strand.along[i] - along);
    const Vec3 apart = strand.position[i] - place;
    const double squared = apart.squaredNorm();
    if (squared <= longest * longest) continue;
    const Vec3 wanted = place + longest / std::sqrt(squared) * apart;
    const TouchingBead* bead = strand.touches ? strand.touches->find(strand.connector, i) : nullptr;
    strand.position[i] = bead ? BeadTouches::allowed(*bead, wanted, strand.dt) : wanted;
  }
}

/// Moves a particle and an end into each other's reach, each by the other's part of their mass.
void Repositioning::meet(const Strand& strand, std::size_t i, std::size_t end) const {
  const double longest = limits_.longest * std::abs(strand.along[i] - strand.along[end]);
  const double squared = (strand.position[end] - strand.position[i]).squaredNorm();
  if (squared > longest * longest) draw(strand, i, end, squared, longest);
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
