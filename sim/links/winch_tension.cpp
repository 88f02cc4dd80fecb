#include "sim/links/winch_tension.h"

#include <stdexcept>
#include <vector>

#include "sim/links/mechanism.h"
#include "sim/links/tension.h"
#include "sim/material/elements.h"

namespace taut {
namespace {

/// Tensions of a connector's links, N, what of the air's force on each link is at either end, N,
/// and accelerations of the particles, m/s^2.
struct Dynamics {
  std::vector<double> tension;
  std::vector<Vec3> air, acceleration;
  double bending = 0;  // N: by how much the energy of bends falls with what is paid out
};

/// Dynamics::bending, of a connector whose points begin at `first`.
double bending(const Connector& connector, const Mechanism& mechanism, std::size_t first,
               const double* state) {
  const material::MaterialForces& material = mechanism.material();
  double sum = 0;
  Vec3 e0, e1;
  for (const material::BendElement& bend : material.bends()) {
    if (bend.b < first || bend.b >= first + connector.particles()) continue;
    material.edges(bend, state, e0, e1);
    const std::size_t particle = bend.b - first;
    double length = 0, share = 0;  // of half of either link
    const auto add = [&](std::size_t link) {
      length += connector.rest[link] / 2;
      share += connector.winch->share(link) / 2;
    };
    if (!bend.clamped_before()) add(particle - 1);
    if (!bend.clamped_behind()) add(particle);
    sum += material::Bend(e0, e1, bend.rest).energy(bend.stiffness) / length * share;
  }
  return sum;
}

Dynamics solve(const World& world, std::size_t index) {
  Mechanism mechanism(world);
  TensionSystem system(mechanism);
  std::vector<double> state, right, tension;
  mechanism.load(world, state);
  mechanism.update(world.time, state.data());
  for (std::size_t r = 0; r < mechanism.rows().size(); ++r) {
    right.push_back(mechanism.free_acceleration(r));
  }
  system.assemble(mechanism);
  system.solve(right, tension);
  std::vector<double> slope(state.size());
  mechanism.differentiate(state.data(), tension.data(), slope.data());
  Dynamics found;
  for (std::size_t r = 0; r < tension.size(); ++r) {
    if (mechanism.rows()[r].connector == index) found.tension.push_back(tension[r]);
  }
  std::size_t first = 0;
  for (std::size_t c = 0; c < index; ++c) first += world.connectors[c].particles();
  const Connector& connector = world.connectors[index];
  found.bending = bending(connector, mechanism, first, state.data());
  found.air.resize(connector.links(), Vec3::Zero());
  for (const material::DragElement& link : mechanism.material().drags()) {
    if (link.a < first || link.a >= first + connector.links()) continue;
    found.air[link.a - first] =
        mechanism.material().drag(link, state.data(), state.data() + mechanism.velocity(0));
  }
  for (std::size_t i = 0; i < connector.particles(); ++i) {
    found.acceleration.push_back(Eigen::Map<const Vec3>(&slope[mechanism.velocity(first + i)]));
  }
  for (const Hold& hold : connector.holds) {  // whose slopes are zero
    found.acceleration[hold.particle] = hold_motion(world, hold.to, world.time).acceleration;
  }
  return found;
}

}  // namespace

double winch_tension(const World& world, std::size_t index, std::size_t end) {
  const Connector& connector = world.connectors[index];
  if (!connector.winch || !connector.winch->paths[end]) {
    throw std::invalid_argument("the connector " + connector.name + " has no winch there");
  }
  const Winch& winch = *connector.winch;
  const auto [tension, air, acceleration, bending] = solve(world, index);
  const PaidOut first = winch.paid_out(0, world.time), last = winch.paid_out(1, world.time);
  const PaidOut longer = first + last, own = end == 0 ? first : last;
  // Lagrange's equation for what this winch has paid out, in the frame of its end.
  const std::size_t eye = end == 0 ? 0 : connector.particles() - 1;
  const auto place = [&](std::size_t i) -> Vec3 {
    return connector.position[i] - connector.position[eye];
  };
  const auto speed = [&](std::size_t i) -> Vec3 {
    return connector.velocity[i] - connector.velocity[eye];
  };
  const Vec3 weight = world.gravity - acceleration[eye];
  double rate = 0, slope = 0, pull = bending;  // of dL/dq' by time, dL/dq, and of the links
  for (std::size_t k = 0; k < connector.links(); ++k) {
    const double length = connector.rest[k], share = winch.share(k);
    const Vec3 gap = place(k + 1) - place(k), gap_rate = speed(k + 1) - speed(k);
    pull += share * tension[k];
    for (const std::size_t i : {k, k + 1}) {
      const double part = end == 0 ? 1 - winch.before[i] : -winch.before[i];  // of the flow there
      const Winch::Flow flow = winch.flow(i, first, last);
      pull += part * air[k].dot(gap) / length;
      rate += part * ((acceleration[i] - acceleration[eye]).dot(gap) + speed(i).dot(gap_rate) +
                      share * longer.rate * flow.speed + length * flow.rate);
      slope +=
          share * ((speed(i).squaredNorm() + flow.speed * flow.speed) / 2 + weight.dot(place(i)));
    }
  }
  return winch.density / 2 * (slope - rate + own.rate * own.rate) + pull;
}

}  // namespace taut
