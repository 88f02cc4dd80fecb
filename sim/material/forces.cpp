#include "sim/material/forces.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <stdexcept>

#include "sim/material/elements.h"
#include "sim/measure/measure.h"

namespace taut::material {
namespace {

Eigen::Map<const Vec3> point(const double* values, std::size_t index) {
  return Eigen::Map<const Vec3>(values + 3 * index);
}

bool is_clamped(const Hold& hold) {
  return !hold.clamp.isZero(0);
}

/// EI or its damping of the rope that bends at a particle, half of either link's, over its length.
double over_length(const Connector& connector, std::size_t particle, double Section::*value) {
  double sum = 0, length = 0;
  for (const std::size_t link : {particle - 1, particle}) {
    if (link >= connector.links()) continue;  // beyond either end
    sum += connector.rest[link] * connector.sections[link].*value;
    length += connector.rest[link];
  }
  return 2 * sum / (length * length);
}

/// The same of one link's half beside a clamp.
double over_half(const Connector& connector, std::size_t link, double Section::*value) {
  return 2 * connector.sections[link].*value / connector.rest[link];
}

/// The curvature at rest of what bends at a particle, half of either link's, times its length.
Vec3 rest_of(const Connector& connector, std::size_t particle) {
  Vec3 sum = Vec3::Zero();
  for (const std::size_t link : {particle - 1, particle}) {
    if (link >= connector.links()) continue;
    sum += connector.rest[link] / 2 * connector.sections[link].rest_curvature;
  }
  return sum;
}

Vec3 rest_of_half(const Connector& connector, std::size_t link) {
  return connector.rest[link] / 2 * connector.sections[link].rest_curvature;
}

void check_sections(const Connector& connector) {
  if (connector.sections.empty()) return;
  const auto fails = [&](const char* what) {
    throw std::invalid_argument("connector " + connector.name + what);
  };
  if (connector.sections.size() != connector.links()) fails(" needs a section for each link");
  for (std::size_t k = 0; k < connector.links(); ++k) {
    if (!(connector.rest[k] > 0)) fails(" has sections and a link without length");
    if (std::isfinite(connector.sections[k].axial_stiffness) != connector.stretches()) {
      fails(" has links that stretch and links that do not");
    }
  }
}

bool bends(const Connector& connector) {
  return std::ranges::any_of(connector.sections, [](const Section& section) {
    return section.bending_stiffness > 0 || section.bending_damping > 0;
  });
}

/// The turn of a hold that is the farthest from none, rad.
double farthest(const Hold& hold) {
  double most = 0;
  if (!hold.turn) return most;
  for (const PathKey& key : hold.turn->keys()) most = std::max(most, std::abs(key.position.x()));
  return most;
}

}  // namespace

const StretchElement* pressed_together(std::span<const StretchElement> stretches,
                                       const double* positions) {
  for (const StretchElement& link : stretches) {
    if (link.pulls) continue;
    if ((point(positions, link.b) - point(positions, link.a)).norm() < kShareOfNothing * link.rest)
      return &link;
  }
  return nullptr;
}

void add_stretches(const Connector& connector, std::uint32_t index, std::uint32_t first,
                   std::vector<StretchElement>& elements) {
  if (!connector.stretches()) return;
  for (std::uint32_t k = 0; k < connector.links(); ++k) {
    const Section& section = connector.sections[k];
    elements.push_back({.a = first + k,
                        .b = first + k + 1,
                        .rest = connector.rest[k],
                        .stiffness = section.axial_stiffness / connector.rest[k],
                        .damping = section.axial_damping / connector.rest[k],
                        .connector = index,
                        .link = k,
                        .pulls = connector.pulls});
  }
}

std::uint32_t add_bends(const Connector& connector, std::uint32_t clamps, std::uint32_t first,
                        std::vector<BendElement>& elements) {
  if (!bends(connector)) return 0;
  constexpr auto kStiffness = &Section::bending_stiffness, kDamping = &Section::bending_damping;
  std::uint32_t clamp = clamps;
  auto hold = connector.holds.begin();
  for (std::uint32_t i = 0; i < connector.particles(); ++i) {
    const std::uint32_t at = first + i;
    while (hold != connector.holds.end() && hold->particle < i) ++hold;
    const bool clamped = hold != connector.holds.end() && hold->particle == i && is_clamped(*hold);
    if (clamped) {
      if (i > 0) {
        elements.push_back({at - 1, at, at, over_half(connector, i - 1, kStiffness),
                            over_half(connector, i - 1, kDamping), clamp,
                            rest_of_half(connector, i - 1)});
      }
      if (i < connector.links()) {
        elements.push_back({at, at, at + 1, over_half(connector, i, kStiffness),
                            over_half(connector, i, kDamping), clamp, rest_of_half(connector, i)});
      }
      ++clamp;
    } else if (i > 0 && i < connector.links()) {
      elements.push_back({at - 1, at, at + 1, over_length(connector, i, kStiffness),
                          over_length(connector, i, kDamping), BendElement::kNone,
                          rest_of(connector, i)});
    }
  }
  return clamp - clamps;
}

void add_closing_bend(const Connector& connector, std::uint32_t first,
                      std::vector<BendElement>& elements) {
  if (!bends(connector)) return;
  const std::size_t last = connector.links() - 1;
  const double length = connector.rest[last] + connector.rest[0];
  const auto over = [&](double Section::*value) {
    return 2 *
           (connector.rest[last] * connector.sections[last].*value +
            connector.rest[0] * connector.sections[0].*value) /
           (length * length);
  };
  elements.push_back({.a = first + static_cast<std::uint32_t>(last),
                      .b = first,
                      .c = first + 1,
                      .stiffness = over(&Section::bending_stiffness),
                      .damping = over(&Section::bending_damping),
                      .rest = rest_of_half(connector, last) + rest_of_half(connector, 0)});
}

void add_drags(const Connector& connector, const Air& air, std::uint32_t first,
               std::vector<DragElement>& elements) {
  const Drag& drag = connector.drag;
  if (connector.sections.empty() || air.density == 0 || (drag.across == 0 && drag.along == 0)) {
    return;
  }
  for (std::uint32_t k = 0; k < connector.links(); ++k) {
    elements.push_back({.a = first + k,
                        .b = first + k + 1,
                        .density = air.density,
                        .length = connector.rest[k],
                        .diameter = connector.sections[k].diameter,
                        .across = drag.across,
                        .along = drag.along});
  }
}

void MaterialForces::rebuild(const World& world, std::size_t room,
                             std::span<const std::uint32_t> leaders) {
  applied_.clear();
  time_ = world.time;
  std::uint32_t point = 0;
  for (const Connector& connector : world.connectors) {
    const auto particles = static_cast<std::uint32_t>(connector.particles());
    if (connector.applied_force) applied_.push_back({point, particles, connector.applied_force});
    point += particles;
  }
  any_ = has_materials(world) || has_applied();
  stretches_.clear();
  bends_.clear();
  drags_.clear();
  twists_.clear();
  leaders_.clear();
  clamps_.clear();
  body_clamps_.clear();
  rest_.clear();
  if (!any_) return;
  stretches_.reserve(room);
  bends_.reserve(room);
  drags_.reserve(room);
  rest_.reserve(room);
  wind_ = world.air.wind_at(world.time);
  std::uint32_t first = 0;
  for (std::uint32_t c = 0; c < world.connectors.size(); ++c) {
    const Connector& connector = world.connectors[c];
    check_sections(connector);
    rest_.insert(rest_.end(), connector.rest.begin(), connector.rest.end());
    rest_.push_back(0);
    add_stretches(connector, c, first, stretches_);
    add_drags(connector, world.air, first, drags_);
    const auto before = static_cast<std::uint32_t>(clamps_.size());
    const std::uint32_t clamps = material::add_bends(connector, before, first, bends_);
    for (std::size_t h = 0; h < connector.holds.size() && clamps > 0; ++h) {
      if (!is_clamped(connector.holds[h])) continue;
      const Hold& hold = connector.holds[h];
      if (!is_prescribed(world, hold.to)) {
        body_clamps_.push_back(
            {static_cast<std::uint32_t>(clamps_.size()), hold.to.body, hold.clamp.normalized()});
      }
      clamps_.push_back({c, h, {}, {}});
    }
    const bool loop = is_loop(world, c);
    if (loop && clamps == 0) add_closing_bend(connector, first, bends_);
    if ((loop || clamps > 0) && carries_twist(world, c))
      add_twist(connector, c, first, before, loop);
    first += static_cast<std::uint32_t>(connector.particles());
  }
  for (BodyClamp& at : body_clamps_) {
    const auto bend =
        std::ranges::find_if(bends_, [&](const BendElement& one) { return one.clamp == at.clamp; });
    at.bend = static_cast<std::size_t>(bend - bends_.begin());
  }
  lengths_.clear();
  bent_links_.clear();
  lengths_.reserve(bends_.capacity());
  bent_links_.reserve(bends_.capacity());
  for (const BendElement& bend : bends_) {
    lengths_.push_back({rest_[bend.a], rest_[bend.b]});
    bent_links_.push_back({bend.a, bend.b});
  }
  moduli_.clear();
  axial_.clear();
  if (has_winches(world)) {
    for (const StretchElement& link : stretches_) {
      axial_.push_back({link.stiffness * link.rest, link.damping * link.rest});
    }
    for (std::size_t i = 0; i < bends_.size(); ++i) {
      moduli_.push_back(bends_[i].stiffness * bent_length(i));
    }
  }
  if (!leaders.empty()) name_leaders(leaders);
}

/// Lets elements end at the points that stand for theirs.
void MaterialForces::name_leaders(std::span<const std::uint32_t> leaders) {
  if (!twists_.empty() || has_applied()) leaders_.assign(leaders.begin(), leaders.end());
  const auto change = [&](std::uint32_t& point) { point = leaders[point]; };
  for (StretchElement& link : stretches_) {
    change(link.a);
    change(link.b);
  }
  for (BendElement& bend : bends_) {
    change(bend.a);
    change(bend.b);
    change(bend.c);
  }
  for (DragElement& link : drags_) {
    change(link.a);
    change(link.b);
  }
}

void MaterialForces::place(const World& world, double time) {
  time_ = time;
  if (world.air.gusts) wind_ = world.air.wind_at(time);
  for (Clamp& clamp : clamps_) {
    const Hold& hold = world.connectors[clamp.connector].holds[clamp.hold];
    clamp.motion = clamp_motion(world, hold, time);
    if (!twists_.empty()) clamp.frame = clamp_frame(world, hold, time);
  }
}

void MaterialForces::edges(const BendElement& bend, const double* positions, Vec3& e0,
                           Vec3& e1) const {
  if (bend.clamped_before()) {
    e0 = clamps_[bend.clamp].motion.direction;
  } else {
    e0 = point(positions, bend.b) - point(positions, bend.a);
  }
  if (bend.clamped_behind()) {
    e1 = clamps_[bend.clamp].motion.direction;
  } else {
    e1 = point(positions, bend.c) - point(positions, bend.b);
  }
}

void MaterialForces::edge_rates(const BendElement& bend, const double* velocities, Vec3& e0,
                                Vec3& e1) const {
  if (bend.clamped_before()) {
    e0 = clamps_[bend.clamp].motion.rate;
  } else {
    e0 = point(velocities, bend.b) - point(velocities, bend.a);
  }
  if (bend.clamped_behind()) {
    e1 = clamps_[bend.clamp].motion.rate;
  } else {
    e1 = point(velocities, bend.c) - point(velocities, bend.b);
  }
}

void MaterialForces::add(const double* positions, const double* velocities,
                         std::vector<Vec3>& force) const {
  for (const StretchElement& link : stretches_) {
    const Vec3 gap = point(positions, link.b) - point(positions, link.a);
    const Vec3 gap_rate = point(velocities, link.b) - point(velocities, link.a);
    const double length = gap.norm();
    if (length == 0) continue;
    const Vec3 unit = gap / length;
    double rate = unit.dot(gap_rate);
    if (link.rest_rate != 0) rate -= length / link.rest * link.rest_rate;
    const double tension = link.tension(length, rate);
    force[link.a] += tension * unit;
    force[link.b] -= tension * unit;
  }
  add_bends(positions, velocities, force);
  add_drag(positions, velocities, force);
  add_twists(positions, velocities, force);
  add_applied(positions, velocities, force);
}

/// Joined particles stand where their leaders do, which get the force.
void MaterialForces::add_applied(const double* positions, const double* velocities,
                                 std::vector<Vec3>& force) const {
  for (const Applied& applied : applied_) {
    at_.resize(applied.particles);
    moving_.resize(applied.particles);
    pushed_.assign(applied.particles, Vec3::Zero());
    const auto leader = [&](std::uint32_t i) {
      return leaders_.empty() ? applied.first + i : leaders_[applied.first + i];
    };
    for (std::uint32_t i = 0; i < applied.particles; ++i) {
      at_[i] = point(positions, leader(i));
      moving_[i] = point(velocities, leader(i));
    }
    (*applied.force)(time_, at_, moving_, pushed_);
    for (std::uint32_t i = 0; i < applied.particles; ++i) force[leader(i)] += pushed_[i];
  }
}

void MaterialForces::slope(const BendElement& bend, const double* positions,
                           const double* velocities, Vec3& by_e0, Vec3& by_e1) const {
  Vec3 e0, e1;
  edges(bend, positions, e0, e1);
  const Bend shape(e0, e1, bend.rest);
  shape.slope(bend.stiffness, by_e0, by_e1);
  if (!(bend.damping > 0)) return;
  Vec3 damped0, damped1, rate0, rate1;
  edge_rates(bend, velocities, rate0, rate1);
  shape.resistance(bend.damping, rate0, rate1, damped0, damped1);
  by_e0 += damped0;
  by_e1 += damped1;
}

void MaterialForces::add_bends(const double* positions, const double* velocities,
                               std::vector<Vec3>& force) const {
  Vec3 by_e0, by_e1;
  for (const BendElement& bend : bends_) {
    slope(bend, positions, velocities, by_e0, by_e1);
    if (!bend.clamped_before()) {
      force[bend.a] += by_e0;
      force[bend.b] -= by_e0;
    }
    if (!bend.clamped_behind()) {
      force[bend.b] += by_e1;
      force[bend.c] -= by_e1;
    }
  }
}

std::vector<MaterialForces::ClampMoment> MaterialForces::clamp_moments(
    const double* positions, const double* velocities) const {
  std::vector<ClampMoment> made;
  for (const Clamp& clamp : clamps_) made.push_back({clamp.connector, clamp.hold});
  const auto add = [&](std::uint32_t clamp, const Vec3& by_direction, double about) {
    const Vec3& direction = clamps_[clamp].motion.direction;
    made[clamp].moment += direction.cross(by_direction) + about * direction;
  };
  Vec3 by_e0, by_e1;
  for (const BendElement& bend : bends_) {
    if (bend.clamp == BendElement::kNone) continue;
    slope(bend, positions, velocities, by_e0, by_e1);
    add(bend.clamp, bend.clamped_before() ? by_e0 : by_e1, 0);
  }
  for (const TwistElement& rod : twists_) {
    if (rod.closed) continue;
    double moment = rod.stiffness * twist(rod, positions);
    if (rod.damping > 0) moment += rod.damping * twist_rate(rod, positions, velocities);
    const Vec3 &from = clamps_[rod.from].motion.direction, &to = clamps_[rod.to].motion.direction;
    add(rod.from, moment * Carry(from, link_of(rod, 0, positions)).slope(), -moment);
    add(rod.to, moment * Carry(link_of(rod, rod.links - 1, positions), to).slope(), moment);
  }
  return made;
}

Vec3 MaterialForces::drag(const DragElement& link, const double* positions,
                          const double* velocities) const {
  const Vec3 edge = point(positions, link.b) - point(positions, link.a);
  Vec3 speed = (point(velocities, link.a) + point(velocities, link.b)) / 2 - wind_;
  if (link.flow != 0) speed += link.flow * edge.normalized();
  return drag_force(edge, speed, link.density_area(), link.across, link.along) / 2;
}

void MaterialForces::add_drag(const double* positions, const double* velocities,
                              std::vector<Vec3>& force) const {
  for (const DragElement& link : drags_) {
    const Vec3 half = drag(link, positions, velocities);
    force[link.a] += half;
    force[link.b] += half;
  }
}

void MaterialForces::flow_past(std::size_t drag, double length, double speed) {
  drags_[drag].length = length;
  drags_[drag].flow = speed;
}

double MaterialForces::bent_length(std::size_t bend) const {
  const double before = bends_[bend].clamped_before() ? 0 : lengths_[bend].before;
  const double behind = bends_[bend].clamped_behind() ? 0 : lengths_[bend].behind;
  return (before + behind) / 2;
}

void MaterialForces::pay_out(std::size_t stretch, double rest, double rate) {
  StretchElement& link = stretches_[stretch];
  link.rest = rest;
  link.stiffness = axial_[stretch].stiffness / rest;
  link.damping = axial_[stretch].damping / rest;
  link.rest_rate = rate;
}

void MaterialForces::bend_over_lengths(std::size_t first, std::size_t end) {
  for (std::size_t i = first; i < end; ++i) {
    lengths_[i] = {rest_[bent_links_[i].before], rest_[bent_links_[i].behind]};
    bends_[i].stiffness = moduli_[i] / bent_length(i);
  }
}

double MaterialForces::cycles() const {
  const auto count = [](const auto& list) { return static_cast<double>(list.size()); };
  double turns = 0;
  for (const TwistElement& rod : twists_) turns += rod.links;
  return 45 * count(stretches_) + 130 * count(bends_) + 60 * count(drags_) + 150 * turns;
}

// The twist of connectors among the forces of a world.

/// The twist of a connector that carries any; its clamps are numbered from `clamps` on.
void MaterialForces::add_twist(const Connector& connector, std::uint32_t index, std::uint32_t first,
                               std::uint32_t clamps, bool closed) {
  double softness = 0, damping = 0, rest = 0;
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const Section& section = connector.sections[k];
    const double own = connector.rest[k] / section.twisting_stiffness;  // rad for 1 N m
    softness += own;
    // Each link takes its share of the rate, as it takes its share of the twist.
    damping += own * section.twisting_damping / section.twisting_stiffness;
    rest += connector.rest[k] * section.rest_twist;
  }
  double most = std::abs(rest);
  for (const Hold& hold : connector.holds) most += farthest(hold);
  twists_.push_back({.connector = index,
                     .first = first,
                     .links = static_cast<std::uint32_t>(connector.links()),
                     .closed = closed,
                     .from = clamps,
                     .to = clamps + 1,
                     .stiffness = 1 / softness,
                     .damping = damping / (softness * softness),
                     .rest = rest,
                     .most = most,
                     .start = connector.end_turn.start,
                     .since = connector.end_turn.since});
}

/// Calls `visit(link, slope)`, slope the derivative of the twist by the link's edge.
template <class Visit>
void MaterialForces::each_slope(const TwistElement& rod, const double* positions,
                                Visit visit) const {
  Vec3 edge = link_of(rod, 0, positions), next;
  const Vec3 first =
      rod.closed ? link_of(rod, rod.links - 1, positions) : clamps_[rod.from].motion.direction;
  const Vec3 last = rod.closed ? edge : clamps_[rod.to].motion.direction;
  Vec3 before = Carry(first, edge).slope();
  for (std::uint32_t k = 0; k < rod.links; ++k) {
    next = k + 1 < rod.links ? link_of(rod, k + 1, positions) : last;
    const Vec3 behind = Carry(edge, next).slope();
    visit(k, Vec3((before + behind) / edge.norm()));
    before = behind;
    edge = next;
  }
}

Vec3 MaterialForces::link_of(const TwistElement& rod, std::uint32_t link,
                             const double* positions) const {
  return point(positions, point_of(rod, link + 1)) - point(positions, point_of(rod, link));
}

double MaterialForces::turned(const TwistElement& rod, const double* positions) const {
  const auto direction = [&](std::uint32_t link) -> Vec3 {
    return link_of(rod, link, positions).normalized();
  };
  const Vec3 first = rod.closed ? direction(0) : clamps_[rod.from].motion.direction;
  const Vec3 last = rod.closed ? first : clamps_[rod.to].motion.direction;
  const Quat from = rod.closed ? frame_along(first) : clamps_[rod.from].frame.frame;
  const Quat to = rod.closed ? from : clamps_[rod.to].frame.frame;
  CarriedFrame carried(from, first);
  for (std::uint32_t k = 0; k < rod.links; ++k) carried.carry(direction(k));
  carried.carry(last);
  // As near to the last one as whole turns bring it.
  const double now = carried.turn_to(to) - rod.start;
  constexpr double kTurn = 2 * std::numbers::pi;
  return now + kTurn * std::round((rod.since - now) / kTurn);
}

double MaterialForces::twist(const TwistElement& rod, const double* positions) const {
  const double turn = turned(rod, positions) - rod.rest;
  return rod.closed ? turn : turn + clamps_[rod.to].frame.turn - clamps_[rod.from].frame.turn;
}

double MaterialForces::twist_rate(const TwistElement& rod, const double* positions,
                                  const double* velocities) const {
  double rate = 0;
  if (!rod.closed) {
    const Clamp &from = clamps_[rod.from], &to = clamps_[rod.to];
    const Carry first(from.motion.direction, link_of(rod, 0, positions));
    const Carry last(link_of(rod, rod.links - 1, positions), to.motion.direction);
    rate += to.frame.spin + to.frame.turn_rate - from.frame.spin - from.frame.turn_rate;
    rate += first.slope().dot(from.motion.rate) + last.slope().dot(to.motion.rate);
  }
  each_slope(rod, positions, [&](std::uint32_t link, const Vec3& slope) {
    rate += slope.dot(link_of(rod, link, velocities));
  });
  return rate;
}

void MaterialForces::twist_slope(const TwistElement& rod, const double* positions,
                                 std::vector<Vec3>& slope) const {
  slope.assign(rod.links + 1, Vec3::Zero());
  each_slope(rod, positions, [&](std::uint32_t link, const Vec3& by_edge) {
    slope[link] -= by_edge;
    slope[link + 1] += by_edge;
  });
  if (!rod.closed) return;  // else the last particle is the first
  slope.front() += slope.back();
  slope.back().setZero();
}

void MaterialForces::add_twists(const double* positions, const double* velocities,
                                std::vector<Vec3>& force) const {
  for (const TwistElement& rod : twists_) {
    double moment = rod.stiffness * twist(rod, positions);
    if (rod.damping > 0) moment += rod.damping * twist_rate(rod, positions, velocities);
    each_slope(rod, positions, [&](std::uint32_t link, const Vec3& slope) {
      force[point_of(rod, link)] += moment * slope;
      force[point_of(rod, link + 1)] -= moment * slope;
    });
  }
}

void MaterialForces::follow(const double* positions) {
  for (TwistElement& rod : twists_) rod.since = turned(rod, positions);
}

void MaterialForces::load_twists(const World& world) {
  for (TwistElement& rod : twists_) {
    const EndTurn& turn = world.connectors[rod.connector].end_turn;
    rod.start = turn.start;
    rod.since = turn.since;
  }
}

void MaterialForces::store_twists(World& world) const {
  for (const TwistElement& rod : twists_)
    world.connectors[rod.connector].end_turn.since = rod.since;
}

// The stiffest of what stretches, bends and twists, which limits explicit steps.

// Of each element the matrix is stiffness d d^T, d how it changes with its points along the way in
// which it does: 1, -1 for a stretch; 1/l0, -(1/l0 + 1/l1), 1/l1 for a bend.
MaterialForces::HighestMode MaterialForces::highest_mode(const std::vector<double>& inverse_mass,
                                                         double bent) const {
  std::vector<double> stiff(inverse_mass.size()), damped(inverse_mass.size());  // sums of rows
  // By the angle a, of Bend's energy and resistance: (2 tan^2(a/2))'' and (2 tan(a/2))'^2.
  const double tangent = std::tan(bent / 2), square = 1 + tangent * tangent;
  const double stiffer = square * (square + 2 * tangent * tangent), slower = square * square;
  const auto add = [&](double stiffness, double damping,
                       std::initializer_list<std::uint32_t> points,
                       std::initializer_list<double> changes) {
    double sum = 0;
    for (const double change : changes) sum += change;
    auto change = changes.begin();
    for (const std::uint32_t p : points) {
      stiff[p] += stiffness * *change * sum;
      damped[p] += damping * *change++ * sum;
    }
  };
  for (const StretchElement& link : stretches_) {
    add(link.stiffness, link.damping, {link.a, link.b}, {1, 1});
  }
  for (std::size_t i = 0; i < bends_.size(); ++i) {
    const BendElement& bend = bends_[i];
    const double l0 = bend.clamped_before() ? 0 : 1 / lengths_[i].before;
    const double l1 = bend.clamped_behind() ? 0 : 1 / lengths_[i].behind;
    add(stiffer * bend.stiffness, slower * bend.damping, {bend.a, bend.b, bend.c},
        {l0, l0 + l1, l1});
  }
  // Of twist what the moment bends aside, at most (moment / 2) (e0^2 + e1^2) / l^2 where two links
  // meet, e how far their ends part across; and stiffness d d^T, d at most 1/l of each link, where
  // neighbours meet at one radian.
  for (const TwistElement& rod : twists_) {
    const double moment = rod.stiffness * (rod.most + std::abs(rod.since) + 2 * std::numbers::pi);
    double sum = 0;
    for (std::uint32_t k = 0; k < rod.links; ++k) sum += 2 / rest_[rod.first + k];
    for (std::uint32_t k = 0; k < rod.links; ++k) {
      const std::uint32_t a = point_of(rod, k), b = point_of(rod, k + 1);
      const double change = 1 / rest_[rod.first + k];
      add(moment, 0, {a, b}, {change, change});
      for (const std::uint32_t p : {a, b}) {
        stiff[p] += rod.stiffness * change * sum;
        damped[p] += rod.damping * change * sum;
      }
    }
  }
  // Where 4/h^2 - 2c/h - k, Gershgorin's bound of a particle's row, is above zero for each, a step
  // of h is stable: the particle with the shortest step counts, w^2 = k and c = 2 z w.
  HighestMode found;
  double most = 0;
  for (std::size_t p = 0; p < stiff.size(); ++p) {
    const double k = inverse_mass[p] * stiff[p], half = inverse_mass[p] * damped[p] / 2;
    const double rate = std::sqrt(k + half * half) + half;
    if (!(rate > most)) continue;
    most = rate;
    found.frequency = std::sqrt(k);
    found.damping = 2 * half;
  }
  return found;
}

}  // namespace taut::material

double taut::elastic_energy(const World& world) {
  material::MaterialForces forces;
  forces.rebuild(world, 0);
  forces.place(world, world.time);
  std::vector<Vec3> position;
  for (const Connector& connector : world.connectors) {
    position.insert(position.end(), connector.position.begin(), connector.position.end());
  }
  double energy = 0;
  for (const material::StretchElement& link : forces.stretches()) {
    const double longer = (position[link.b] - position[link.a]).norm() - link.rest;
    if (!link.pulls || longer > 0) energy += link.stiffness * longer * longer / 2;
  }
  Vec3 e0, e1;
  for (const material::BendElement& bend : forces.bends()) {
    forces.edges(bend, position.data()->data(), e0, e1);
    energy += material::Bend(e0, e1, bend.rest).energy(bend.stiffness);
  }
  for (const material::TwistElement& rod : forces.twists()) {
    const double twist = forces.twist(rod, position.data()->data());
    energy += rod.stiffness * twist * twist / 2;
  }
  return energy;
}
