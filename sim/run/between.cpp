#include "sim/run/between.h"

#include <utility>

namespace taut {
namespace {

void take_back(const Snapshot& end, const Snapshot& last, double share, Snapshot& state) {
  for (std::size_t c = 0; c < state.connectors.size(); ++c)
    for (std::size_t i = 0; i < state.connectors[c].size(); ++i)
      state.connectors[c][i] += share * (last.connectors[c][i] - end.connectors[c][i]);
  for (std::size_t b = 0; b < state.bodies.size(); ++b) {
    Pose& pose = state.bodies[b];
    pose.position += share * (last.bodies[b].position - end.bodies[b].position);
    const Quat off = last.bodies[b].rotation * end.bodies[b].rotation.conjugate();
    pose.rotation = (Quat::Identity().slerp(share, off) * pose.rotation).normalized();
  }
}

}  // namespace

Between::Between(Simulation other) : simulation_(std::move(other)) {
  simulation_.advance_to(std::as_const(simulation_).world().time);  // what happens at the start
}

std::vector<Snapshot> Between::states(const World& first, const std::vector<double>& times,
                                      const Snapshot& last) {
  simulation_.go_on_from(first);
  std::vector<Snapshot> states;
  for (const double time : times) {
    simulation_.advance_to(time);
    states.push_back(simulation_.state());
  }
  simulation_.advance_to(last.time);
  const Snapshot end = simulation_.state();
  for (Snapshot& state : states)
    take_back(end, last, (state.time - first.time) / (last.time - first.time), state);
  return states;
}

}  // namespace taut
