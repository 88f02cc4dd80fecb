#include "scenes/character/cues.h"

#include <algorithm>

#include "scenes/character/soft.h"
#include "sim/run/simulation.h"

namespace taut::scenes {
namespace {

constexpr double moves = 0.02;                    // m/s: a hand that is slower rests
constexpr double stance = 0.9, stance_by = 0.25;  // s, that it takes, and before the hand moves
constexpr double comes_to_rest = 0.35;            // s
constexpr double long_rest = 1.9;                 // s
constexpr double bow_after = 0.75, bow_takes = 0.32, bow_stays = 0.08, rise_takes = 0.38;  // s
constexpr double rises_after = 0.30, stands_in = 0.45;                                     // s
constexpr double past_by = 0.42, past_until = 0.15, ducks = 0.28;  // s, before and after all rests
constexpr double last_stroke = 0.62, stroke_takes = 0.48;          // s, before all rests
// Speeds of the stick (m/s) from which he braces himself, and at which he does entirely.
constexpr double brisk = 1.9, fast = 3.0;
constexpr double braced_by = 0.25, bracing = 0.22;  // s, before it is fast; and how smoothly
constexpr double windup = 0.26;                     // s, before the hand is fast
constexpr double stroke = 0.35, strong = 0.8;  // m/s, by which it then is faster, and much faster
constexpr double foreseen_within = 0.01;       // m, the method's tolerance

/// The stick's centre over the duration: the chain is one link, which nothing but its ends holds.
Track swing(const Path& hand, const FreeStick& stick, double duration) {
  const auto path = std::make_shared<const Path>(hand);
  World world;
  Body body;
  body.mass_properties = solid_cylinder(stick.mass, stick.length, stick.diameter);
  const Vec3 from = path->at(0).pose().to_world(stick.from);
  body.position = from - (stick.chain + stick.length / 2) * Vec3::UnitY();
  world.bodies.push_back(body);
  Connector chain =
      straight_connector("chain", stick.chain, stick.chain_mass, 2, from, -Vec3::UnitY());
  Hold first, last;
  first.to.kind = Attachment::Kind::path;
  first.to.path = path;
  first.to.point = stick.from;
  last.particle = 1;
  last.to.kind = Attachment::Kind::body;
  last.to.point = Vec3(0, stick.length / 2, 0);
  chain.holds = {first, last};
  world.connectors.push_back(std::move(chain));
  finish(world);
  Simulation simulation(world, make_method("direct", {{"tolerance", foreseen_within}}));
  return Track::sample(duration, acting_rate, [&](double time) {
    simulation.advance_to(time);
    return Eigen::VectorXd(std::as_const(simulation).world().bodies[0].frame().position);
  });
}

Track norms(Track rates) {
  rates.samples() = rates.samples().colwise().norm().eval();
  return rates;
}

}  // namespace

double Cues::ready(double time) const {
  return smoothstep((time - (begins - stance_by - stance)) / stance);
}

double Cues::plays(double time) const {
  if (!(rests > begins)) return 0;
  return smoothstep((time - begins + stance_by) / stance_by) *
         smoothstep((rests + comes_to_rest - time) / comes_to_rest);
}

double Cues::struck(double time) const {
  return rests > begins ? smoothstep((time - rests + last_stroke) / stroke_takes) : 0;
}

double Cues::passes(double time) const {
  if (!swings || !(rests > begins)) return 0;
  return smoothstep((time - rests + past_by) / ducks) -
         smoothstep((time - rests - past_until) / ducks);
}

double Cues::rises(double time) const {
  return greets() ? smoothstep((time - rests - rises_after) / stands_in) : 0;
}

bool Cues::greets() const {
  return rests > begins && ends - rests > long_rest;
}

double Cues::nod(double time) const {
  const double since = time - rests - bow_after;
  return greets() ? smoothstep(since / bow_takes) -
                        smoothstep((since - bow_takes - bow_stays) / rise_takes)
                  : 0;
}

Cues foresee(const Path& hand, const std::optional<FreeStick>& stick, double duration) {
  Cues cues;
  cues.begins = cues.rests = cues.ends = duration;
  if (stick) {
    cues.swings = true;
    cues.stick = swing(hand, *stick, duration);
  }
  bool moved = false;
  for (double time = 0; time <= duration; time += 1 / acting_rate) {
    if (!(hand.at(time).velocity.norm() > moves)) continue;
    if (!moved) cues.begins = time;
    moved = true;
    cues.rests = time;
  }
  if (!stick) return cues;

  cues.off = cues.stick;
  for (Eigen::Index i = 0; i < cues.off.count(); ++i)
    cues.off.samples().col(i) = cues.plays(cues.off.time(i)) * (cues.stick[i] - cues.stick[0]);
  Track speed = norms(cues.stick.rates()).smoothed(0.25);
  for (double& v : speed.samples().reshaped()) v = smoothstep((v - brisk) / (fast - brisk));
  cues.braced = speed.smoothed(bracing).ahead(braced_by);
  const Track haste =
      norms(Track::sample(duration, acting_rate,
                          [&](double time) { return Eigen::VectorXd(hand.at(time).position); })
                .rates())
          .smoothed(0.10);
  cues.winds_up = haste.ahead(windup);
  // A stroke that comes, but not what goes on at one speed.
  for (Eigen::Index i = 0; i < haste.count(); ++i) {
    const double faster = cues.winds_up[i][0] - haste[i][0] - stroke;
    cues.winds_up.samples()(0, i) = soft(std::max(0.0, faster) / strong, 1.0);
  }
  return cues;
}

}  // namespace taut::scenes
