// What a step at obstacles leaves to the next.
#include "sim/methods/direct/contact/contact_step.h"

namespace taut::direct {

void ContactStep::note(Past& past) const {
  past.state = state_;
  past.tension = last_tension_;
  past.along = along_;
  past.touches = touches_;
  past.body_touches = bodies_.touches();
  past.link_touches = links_.touches();
  past.bead_touches = beads_.touches();
  past.acceleration = last_acceleration_;
  past.steady = steady_;
  past.pushed = last_pushed_;
  past.steady_pushed = steady_pushed_;
  past.h = last_h_;
  past.watched = watched_;
  past.risen = risen_;
  past.hits = last_hits_;
  past.pattern = last_pattern_;
}

void ContactStep::go_back(const Past& past) {
  state_ = past.state;
  last_tension_ = past.tension;
  along_ = past.along;
  touches_ = past.touches;
  bodies_.follow(past.body_touches);
  links_.follow(past.link_touches);
  beads_.follow(past.bead_touches);
  last_acceleration_ = past.acceleration;
  steady_ = past.steady;
  last_pushed_ = past.pushed;
  steady_pushed_ = past.steady_pushed;
  last_h_ = past.h;
  watched_ = past.watched;
  risen_ = past.risen;
  last_hits_ = past.hits;
  last_pattern_ = past.pattern;
}

}  // namespace taut::direct
