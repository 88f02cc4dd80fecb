#include "sim/simulation.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>

namespace taut {

Simulation::Simulation(World world, std::unique_ptr<Method> method, Timeline timeline)
    : world_(std::move(world)),
      method_(std::move(method)),
      timeline_(std::move(timeline)),
      pins_(timeline_.pins.size(), 0) {
  for (std::size_t i = 0; i < timeline_.pins.size(); ++i) {
    entries_.push_back({timeline_.pins[i].from, Entry::Kind::pin, i});
    entries_.push_back({timeline_.pins[i].until, Entry::Kind::release, i});
  }
  for (std::size_t i = 0; i < timeline_.cuts.size(); ++i) {
    entries_.push_back({timeline_.cuts[i].time, Entry::Kind::cut, i});
  }
  std::ranges::sort(entries_, {}, [](const Entry& entry) {
    return std::tuple(entry.time, entry.kind, entry.index);
  });
  interventions_.reserve(world_, timeline_.pins.size(), timeline_.cuts.size());
}

void Simulation::advance_to(double time) {
  if (!(time >= world_.time)) throw std::invalid_argument("a simulation cannot go back in time");
  for (; next_ < entries_.size() && entries_[next_].time <= time; ++next_) {
    const Entry& entry = entries_[next_];
    if (entry.time > world_.time) method_->advance(world_, entry.time);
    enact(entry);
  }
  if (time > world_.time) method_->advance(world_, time);
}

void Simulation::enact(const Entry& entry) {
  Outcome outcome = Outcome::done;
  if (entry.kind == Entry::Kind::cut) {
    const TimedCut& cut = timeline_.cuts[entry.index];
    outcome = interventions_.cut(world_, cut.connector, cut.along).outcome;
  } else if (entry.kind == Entry::Kind::release) {
    outcome = interventions_.release(world_, pins_[entry.index]);
  } else {
    const TimedPin& pin = timeline_.pins[entry.index];
    const Pinned pinned =
        pin.to ? interventions_.pin(world_, pin.connector, pin.along, *pin.to, pin.over)
               : interventions_.pin(world_, pin.connector, pin.along);
    pins_[entry.index] = pinned.pin;
    outcome = pinned.outcome;
  }
  if (outcome == Outcome::done) return;
  throw BadIntervention({entry.kind == Entry::Kind::cut, entry.index, std::string(words(outcome))},
                        entry.time);
}

}  // namespace taut
