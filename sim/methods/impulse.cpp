#include "sim/methods/impulse.h"

#include <algorithm>
#include <cmath>
#include <ranges>

#include "sim/methods/bead_touches.h"
#include "sim/methods/repositioning.h"
#include "sim/methods/span_impulse.h"
#include "sim/methods/span_path.h"
#include "sim/motion/stop.h"
#include "sim/run/companion.h"
#include "sim/topology/room.h"
#include "sim/topology/span.h"

namespace taut::methods {
namespace {

constexpr std::string_view kImpulse = "impulse";
constexpr int kSettlings = 8;   // times that spans which share a body are gone through at most
constexpr double kSense = 1e6;  // m; no scene is so wide
constexpr std::size_t kEvents = 1024;

class Impulse final : public Method {
 public:
  explicit Impulse(const Settings& settings)
      : step_(number(settings, "step")),
        limits_{number(settings, "l_c"), number(settings, "l_t")},
        passes_(static_cast<int>(number(settings, "passes"))),
        as_printed_(flag(settings, "as_printed")),
        impulses_(limits_, as_printed_),
        repositioning_(limits_, number(settings, "h"), as_printed_) {}

  void advance(World& world, double until) override {
    if (!prepared_ || topology_ != world.topology) prepare(world);
    const StepTimes times(world.time, until, step_);
    for (std::uint64_t i = 0; i < times.count; ++i) {
      check_stop();
      step(world, times.at(i + 1), times.dt);
    }
    world.time = until;
  }

 private:
  void prepare(const World& world);
  void step(World& world, double time, double dt);
  void fly(World& world, double dt);
  void find_paths(World& world, double dt);
  void settle(World& world, double time, double dt);
  bool interact(World& world, std::size_t span, double time, double dt);
  void check(const World& world, double time) const;

  double step_;
  LinkLimits limits_;
  int passes_;
  bool as_printed_;
  SpanImpulses impulses_;
  std::vector<Span> spans_, spans_before_;
  Repositioning repositioning_;
  BeadTouches touches_;
  PathFinder finder_;
  std::vector<SpanPath> paths_;  // of spans_, where there are obstacles
  bool prepared_ = false;
  std::uint64_t topology_ = 0;
  double step_cycles_ = 0, pass_cycles_ = 0;  // see Counters::cycles
};

void Impulse::prepare(const World& world) {
  require(kImpulse, world);
  topology_ = world.topology;
  impulses_.prepare(world);
  touches_.prepare(world);
  if (!prepared_) {
    events_.reserve(kEvents);
    const std::size_t spans = room(world).holds + world.connectors.size();
    spans_.reserve(spans);
    spans_before_.reserve(spans);
  }
  prepared_ = true;
  std::swap(spans_, spans_before_);
  divide(world, spans_before_, spans_);
  repositioning_.prepare(world, spans_);
  if (touches_.any()) {
    if (paths_.capacity() == 0) finder_.reserve(room(world).particles);
    if (paths_.capacity() == 0) paths_.reserve(spans_.capacity());
    paths_.resize(spans_.size());
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
}

void Impulse::step(World& world, double time, double dt) {
  fly(world, dt);
  place_held(world, time);
  if (touches_.any()) {
    touches_.land(world, time, dt);
    find_paths(world, dt);
  }
  settle(world, time, dt);
  if (touches_.any()) touches_.begin_repositioning(world, dt);
  repositioning_.begin(world);
  for (const Span& span : spans_) {
    for (int pass = 0; pass < passes_; ++pass) {
      check_stop();
      repositioning_.pass(world, span, touches_, dt);
    }
    repositioning_.stay_in_reach(world, span, touches_, dt);
  }
  repositioning_.set_velocities(world, dt);
  if (touches_.any()) touches_.finish(world, repositioning_.flown(), dt);
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

/// Around what each span pulls in this step, and what that does to its beads there.
void Impulse::find_paths(World& world, double dt) {
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    SpanPath& path = paths_[s];
    path = finder_.find(world, spans_[s], repositioning_.along(spans_[s].connector), touches_);
    if (!path.bends) continue;
    path.state = impulses_.grip(world, spans_[s], path);
    for (TouchingBead* bead : finder_.corners()) {
      if (path.state == SpanPath::State::held) {
        touches_.hold(world, *bead, dt);
      } else if (path.state != SpanPath::State::slack) {
        bead->role = TouchingBead::Role::led;
      }
    }
  }
}

void Impulse::settle(World& world, double time, double dt) {
  for (std::size_t s = 0; s < spans_.size(); ++s) {
    if (touches_.any() && paths_[s].bends) {
      impulses_.watch_around(world, spans_[s], paths_[s], time, events_);
    } else {
      impulses_.watch(world, spans_[s], time, events_);
    }
  }
  bool moved = true;
  for (int i = 0; moved && i < kSettlings; ++i) {
    moved = false;
    for (std::size_t s = 0; s < spans_.size(); ++s) moved |= interact(world, s, time, dt);
    for (TouchingBead& bead : touches_.beads()) {  // what the impulses have pulled at
      const std::size_t last = world.connectors[bead.connector].particles() - 1;
      if (bead.particle == 0 || bead.particle == last) moved |= touches_.press(world, bead, dt);
    }
  }
  place_carried(world);
}

bool Impulse::interact(World& world, std::size_t index, double time, double dt) {
  Span& span = spans_[index];
  if (!touches_.any() || !paths_[index].bends) {
    return impulses_.act(world, span, time, dt, events_);
  }
  const SpanPath& path = paths_[index];
  if (path.state != SpanPath::State::held) {
    return impulses_.act_around(world, span, path, time, dt, events_);
  }
  Span before = span, after = span;
  before.b = {.kind = SpanEnd::Kind::prescribed, .particle = path.first.particle};
  after.a = {.kind = SpanEnd::Kind::prescribed, .particle = path.last.particle};
  bool moved = false;
  for (Span* part : {&before, &after}) {
    const double length = part == &before ? path.first_length : path.last_length;
    part->mass *= length / part->length;
    part->length = length;
    part->folds = part->links() > 1 || span.folds;
    moved |= impulses_.act(world, *part, time, dt, events_);
  }
  span.taut = before.taut || after.taut;
  return moved;
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

/// Shorter steps do not take the method to the truth.
SettingInfo impulse_step() {
  SettingInfo info = step_setting({}, 10);
  info.meaning =
      "Length of a time step. Raising it costs less and errs more; lowering it leaves the method's "
      "own error.";
  return info;
}

}  // namespace

MethodInfo impulse_method() {
  return {
      .name = kImpulse,
      .summary = "impulses between the ends, particles repositioned",
      .settings = {impulse_step(),
                   {.name = "h",
                    .meaning = "Length error up to which a link is not repositioned. Raising it "
                               "costs less and errs more.",
                    .unit = "m",
                    .fallback = 1e-5},
                   {.name = "l_c",
                    .meaning = "Shortest length of a link, as a share of its rest length; 0: links "
                               "fold. Raising it makes links resist compression earlier.",
                    .unit = "1",
                    .fallback = 1.0,
                    .maximum = 1},
                   {.name = "l_t",
                    .meaning = "Longest length of a link or span, as a share of its rest length. "
                               "Raising it lets the connector stretch.",
                    .unit = "1",
                    .fallback = 1.0,
                    .minimum = 1,
                    .maximum = 10},
                   {.name = "passes",
                    .meaning = "Repositioning passes over all links in a step. Raising it keeps "
                               "lengths better and costs more.",
                    .unit = "1",
                    .fallback = 1.0,
                    .minimum = 1,
                    .maximum = 1000,
                    .whole = true,
                    .sweep = {1.0, 4.0, 16.0}},
                   {.name = "as_printed",
                    .meaning =
                        "Equation (5) and the ends as the paper prints them, without corrections.",
                    .unit = "",
                    .fallback = false}},
      .make = [](const Settings& settings) -> std::unique_ptr<Method> {
        return std::make_unique<Impulse>(settings);
      },
      .paper_role = PaperRole::proposed,
      .forms = {{"as-printed", {{"as_printed", true}}}},
      .abilities = {kPlainFeatures | Features{Feature::span, Feature::obstacle,
                                              Feature::moving_obstacle, Feature::friction,
                                              Feature::restitution},
                    {{Feature::span, kContactFeatures}}},
      .companion =
          [](const MethodInfo&, const Settings&) {
            return Companion{.none = "does not converge to the exact solution, whatever its step"};
          },
      .particle_memory = 100,
  };
}

}  // namespace taut::methods
