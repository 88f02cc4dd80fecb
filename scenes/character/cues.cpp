#include "scenes/character/cues.h"

#include "scenes/character/soft.h"
#include "sim/run/simulation.h"

namespace taut::scenes {
namespace {

constexpr double moves = 0.02;                    // m/s: a hand that is slower rests
constexpr double stance = 0.9, stance_by = 0.25;  // s, that it takes, and before the hand moves
constexpr double comes_to_rest = 0.35;            // s
constexpr double long_rest = 1.9;                 // s
constexpr double bow_after = 0.50, bow_takes = 0.40, bow_stays = 0.22, rise_takes = 0.48;  // s
constexpr double foreseen_within = 0.01;  // m, the method's tolerance

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

}  // namespace

double Cues::ready(double time) const {
  return smoothstep((time - (begins - stance_by - stance)) / stance);
}

double Cues::plays(double time) const {
  if (!(rests > begins)) return 0;
  return smoothstep((time - begins + stance_by) / stance_by) *
         smoothstep((rests + comes_to_rest - time) / comes_to_rest);
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
  return cues;
}

}  // namespace taut::scenes
