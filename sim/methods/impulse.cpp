#include "sim/methods/impulse.h"

#include <algorithm>
#include <cmath>
#include <ranges>

#include "sim/methods/span_impulse.h"
#include "sim/run/companion.h"
#include "sim/topology/room.h"
#include "sim/topology/span.h"

namespace taut::methods {
namespace {

constexpr std::string_view kImpulse = "impulse";
constexpr int kSettlings = 8;   // times that spans which share a body are gone through at most
constexpr double kSense = 1e6;  // m; no scene is so wide
constexpr double kMore = 1e-6;  // rounding of a particle's mass
constexpr std::size_t kEvents = 1024;

/// A connector's data for repositioning, beside its state.
struct Strand {
  std::vector<double> along;   // m, rest length from the first particle
  std::vector<double> weight;  // how easily a particle is moved; zero: held
  std::vector<Vec3> flown;     // m, positions after free flight and impulses
};

class Impulse final : public Method {
 public:
  explicit Impulse(const Settings& settings)
      : step_(number(settings, "step")),
        threshold_(number(settings, "h")),
        limits_{number(settings, "l_c"), number(settings, "l_t")},
        passes_(static_cast<int>(number(settings, "passes"))),
        as_printed_(flag(settings, "as_printed")),
        impulses_(limits_, as_printed_) {}

  void advance(World& world, double until) override {
    if (!prepared_ || topology_ != world.topology) prepare(world);
    const StepTimes times(world.time, until, step_);
    for (std::uint64_t i = 0; i < times.count; ++i) step(world, times.at(i + 1), times.dt);
    world.time = until;
  }

 private:
  void prepare(const World& world);
  void make_room(const World& world);
  void weigh(const Connector& connector, Strand& strand) const;
  void step(World& world, double time, double dt);
  void fly(World& world, double dt);
  void settle(World& world, double time, double dt);
  void reposition(Connector& connector, const Strand& strand, const Span& span) const;
  void stay_in_reach(Connector& connector, const Strand& strand, const Span& span) const;
  void meet(Connector& connector, const Strand& strand, std::size_t i, std::size_t end) const;
  void check(const World& world, double time) const;

  double step_, threshold_;
  LinkLimits limits_;
  int passes_;
  bool as_printed_;
  SpanImpulses impulses_;
  std::vector<Span> spans_, spans_before_;
  std::vector<Strand> strands_;
  bool prepared_ = false;
  std::uint64_t topology_ = 0;
  double step_cycles_ = 0, pass_cycles_ = 0;  // see Counters::cycles
};

void Impulse::prepare(const World& world) {
  refuse_obstacles(kImpulse, world);
  refuse_materials(kImpulse, world);
  refuse_joints(kImpulse, world);
  refuse_winches(kImpulse, world);
  refuse_strings(kImpulse, world);
  topology_ = world.topology;
  impulses_.prepare(world);
  if (!prepared_) {
    events_.reserve(kEvents);
    const std::size_t spans = room(world).holds + world.connectors.size();
    spans_.reserve(spans);
    spans_before_.reserve(spans);
  }
  prepared_ = true;
  std::swap(spans_, spans_before_);
  divide(world, spans_before_, spans_);
  make_room(world);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    weigh(world.connectors[c], strands_[c]);
  }
  // A link that is as long as it may be costs a pass its length and a comparison, another a root, a
  // division and a move that the next link waits for; of a step, flight, reach and velocities are
  // some 80 operations a particle, and a body's impulses as much as thirty of them.
  step_cycles_ = 400 * static_cast<double>(spans_.size());
  pass_cycles_ = 0;
  for (const Connector& connector : world.connectors) {
    step_cycles_ += 40 * static_cast<double>(connector.particles());
    pass_cycles_ += 40 * static_cast<double>(connector.links());
  }
  for (const Body& body : world.bodies) step_cycles_ += body.driven() ? 100 : 1200;
  if (!as_printed_) return;
  for (const Span& span : spans_) {  // "the end points are set to have infinite mass"
    for (const SpanEnd* end : {&span.a, &span.b}) {
      if (end->kind != SpanEnd::Kind::follower) strands_[span.connector].weight[end->particle] = 0;
    }
  }
}

/// Strands for all connectors that the world has room for, with as much room as any of them.
void Impulse::make_room(const World& world) {
  if (strands_.size() >= world.connectors.size()) return;
  strands_.resize(world.connectors.capacity());
  const auto capacity = [](const Connector& c) { return c.position.capacity(); };
  std::size_t most = 0;
  for (const Connector& connector : world.connectors) most = std::max(most, capacity(connector));
  if (double(strands_.size()) * double(most) > kMostRoom) most = 0;
  for (std::size_t c = 0; c < strands_.size(); ++c) {
    const bool cut_off = c >= world.connectors.size();  // later, from any of them
    const std::size_t particles = cut_off ? most : capacity(world.connectors[c]);
    strands_[c].along.reserve(particles);
    strands_[c].weight.reserve(particles);
    strands_[c].flown.reserve(particles);
  }
}

/// Reads the lengths and masses of a connector.
void Impulse::weigh(const Connector& connector, Strand& strand) const {
  const std::size_t n = connector.particles();
  strand.along.assign(n, 0.0);
  strand.weight.assign(n, 1.0);
  for (std::size_t i = 0; i + 1 < n; ++i) strand.along[i + 1] = strand.along[i] + connector.rest[i];
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
    strand.weight[i] = carries ? 0 : mass > 0 && share > 0 ? share / mass : 1;
  }
  for (const Hold& hold : connector.holds) strand.weight[hold.particle] = 0;
}

void Impulse::step(World& world, double time, double dt) {
  fly(world, dt);
  place_held(world, time);
  settle(world, time, dt);
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    strands_[c].flown = world.connectors[c].position;
  }
  for (const Span& span : spans_) {
    Connector& connector = world.connectors[span.connector];
    const Strand& strand = strands_[span.connector];
    for (int pass = 0; pass < passes_; ++pass) reposition(connector, strand, span);
    stay_in_reach(connector, strand, span);
  }
  const double rate = 1 / dt;
  // Velocities from positions: flight gave dx/dt + g dt/2, repositioning adds what it moved.
  for (std::size_t c = 0; c < world.connectors.size(); ++c) {
    Connector& connector = world.connectors[c];
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      connector.velocity[i] += rate * (connector.position[i] - strands_[c].flown[i]);
    }
  }
  ++counters_.steps;
  counters_.solves += static_cast<std::uint64_t>(passes_);
  counters_.cycles += step_cycles_ + passes_ * pass_cycles_;
  check(world, time);
}

void Impulse::fly(World& world, double dt) {
  const Vec3 fall = world.gravity * (dt * dt / 2);
  const Vec3 gain = world.gravity * dt;
  for (std::size_t i = 0; i < world.bodies.size(); ++i) {
    Body& body = world.bodies[i];
    if (body.driven()) continue;
    body.position += body.velocity * dt + fall;
    body.velocity += gain;
    impulses_.rotation(i).turn(body.rotation, body.spin, dt);
  }
  for (Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      connector.position[i] += connector.velocity[i] * dt + fall;
      connector.velocity[i] += gain;
    }
  }
}

void Impulse::settle(World& world, double time, double dt) {
  for (Span& span : spans_) impulses_.watch(world, span, time, events_);
  bool moved = true;
  for (int i = 0; moved && i < kSettlings; ++i) {
    moved = false;
    for (Span& span : spans_) moved |= impulses_.act(world, span, time, dt, events_);
  }
  place_carried(world);
}

/// Section IV.B: neighbours nearer than l_c or farther than l_t, by more than h, are moved to that
/// distance, each by the other's part of their mass.
void Impulse::reposition(Connector& connector, const Strand& strand, const Span& span) const {
  for (std::size_t k = span.a.particle; k < span.b.particle; ++k) {
    Vec3& p = connector.position[k];
    Vec3& q = connector.position[k + 1];
    const Vec3 apart = q - p;
    const double squared = apart.squaredNorm();
    const double shortest = limits_.shortest * connector.rest[k];
    const double longest = limits_.longest * connector.rest[k];
    const double least = std::max(0.0, shortest - threshold_), most = longest + threshold_;
    if (squared >= least * least && squared <= most * most) continue;
    const double weight = strand.weight[k] + strand.weight[k + 1];
    if (weight == 0 || squared == 0) continue;
    const double distance = std::sqrt(squared);
    const double wanted = distance > longest ? longest : shortest;
    const Vec3 move = apart * ((distance - wanted) / (distance * weight));
    p += strand.weight[k] * move;
    q -= strand.weight[k + 1] * move;
  }
}

/// Section IV.B: a particle farther from an end than the rest length between them is moved to that
/// distance; from both ends, and the ends themselves last.
void Impulse::stay_in_reach(Connector& connector, const Strand& strand, const Span& span) const {
  const std::size_t first = span.a.particle, last = span.b.particle;
  for (const std::size_t end : {first, last}) {
    if (strand.weight[end] > 0) {
      for (std::size_t i = first + 1; i < last; ++i) meet(connector, strand, i, end);
      continue;
    }
    const Vec3 place = connector.position[end];
    const double along = strand.along[end];
    for (std::size_t i = first + 1; i < last; ++i) {
      const double longest = limits_.longest * std::abs(strand.along[i] - along);
      const Vec3 apart = connector.position[i] - place;
      const double squared = apart.squaredNorm();
      if (squared <= longest * longest) continue;
      connector.position[i] = place + longest / std::sqrt(squared) * apart;
    }
  }
  if (!as_printed_) meet(connector, strand, last, first);
}

/// Moves a particle and an end into each other's reach, each by the other's part of their mass.
void Impulse::meet(Connector& connector, const Strand& strand, std::size_t i,
                   std::size_t end) const {
  const double longest = limits_.longest * std::abs(strand.along[i] - strand.along[end]);
  const Vec3 apart = connector.position[end] - connector.position[i];
  const double squared = apart.squaredNorm();
  const double weight = strand.weight[i] + strand.weight[end];
  if (squared <= longest * longest || weight == 0) return;
  const double distance = std::sqrt(squared);
  const Vec3 move = apart * ((distance - longest) / (distance * weight));
  connector.position[i] += strand.weight[i] * move;
  connector.position[end] -= strand.weight[end] * move;
}

void Impulse::check(const World& world, double time) const {
  for (const Connector& connector : world.connectors) {
    for (std::size_t i = 0; i < connector.particles(); ++i) {
      if (connector.position[i].squaredNorm() < kSense * kSense) continue;  // false for NaN
      throw Diverged(std::string(kImpulse), time, counters_.steps, connector.name,
                     i > 0 ? i - 1 : 0,
                     connector.position[i].allFinite() ? "a particle is beyond any scene"
                                                       : "a position is not finite");
    }
  }
}

}  // namespace

MethodInfo impulse_method() {
  return {
      .name = kImpulse,
      .summary = "impulses between the ends, particles repositioned",
      .settings = {step_setting(false, 10),
                   {.name = "h",
                    .meaning =
                        "How far a link's length may be off before it is corrected; larger is "
                        "faster.",
                    .unit = "m",
                    .fallback = 1e-5},
                   {.name = "l_c",
                    .meaning =
                        "The length at which a link resists compression, of its rest length; 0 "
                        "folds.",
                    .unit = "1",
                    .fallback = 1.0,
                    .maximum = 1},
                   {.name = "l_t",
                    .meaning = "The length at which a link or span resists stretching, of its rest "
                               "length.",
                    .unit = "1",
                    .fallback = 1.0,
                    .minimum = 1,
                    .maximum = 10},
                   {.name = "passes",
                    .meaning = "Repositioning passes over all links in a step; more keep lengths "
                               "better.",
                    .unit = "1",
                    .fallback = 1.0,
                    .minimum = 1,
                    .maximum = 1000,
                    .whole = true,
                    .sweep = {1.0, 4.0, 16.0}},
                   {.name = "as_printed",
                    .meaning = "Equation (5) and the ends as the paper prints them, uncorrected.",
                    .unit = "",
                    .fallback = false}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Impulse>(settings);
      },
      .paper_role = PaperRole::proposed,
      .forms = {{"as-printed", {{"as_printed", true}}}},
      .follows_spans = true,
      .companion =
          [](const MethodInfo&, const Settings&) {
            return Companion{.none = "does not converge to the exact solution, whatever its step"};
          },
      .cost = {.memory = 100, .step = 2e-8},
  };
}

}  // namespace taut::methods
