// A rigid body that hangs from one of its points, as a link.
#pragma once

namespace taut {

/// Two point masses on a rigid line: `tip` at the point that it hangs from and `far` at `length`
/// from it, on the line through the centre of mass. Mass, centre and moment of inertia across the
/// line are those of the body: I + M a^2 = M a s, with a the arm of the centre of mass, s the
/// length of the equivalent simple pendulum. In plane motion that is all there is to the body, and
/// in space all where it has the same moment about every axis across the line and does not turn
/// about the line itself.
struct EquimomentalLink {
  double tip = 0, far = 0;  // kg
  double length = 0;        // m
  EquimomentalLink(double mass, double inertia, double arm)
      : far(mass * arm / ((inertia + mass * arm * arm) / (mass * arm))),
        length((inertia + mass * arm * arm) / (mass * arm)) {
    tip = mass - far;
  }
};

}  // namespace taut
