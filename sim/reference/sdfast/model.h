// The models that SD/FAST's generator wrote when taut was built.
#pragma once

#include <span>
#include <vector>

namespace taut::sdfast {

enum class Formulation { order_n, kane };

/// The joints of a chain, from its base to its tip. Each is a kind of model.
enum class Joints {
  pin,   // a plane chain from a fixed point: pins only
  ball,  // from a point: ball joints, the last of them to a body at the tip
  free,  // from a body without a joint to the ground, then as `ball`
};

/// A chain of so many links. Bodies, each with the joint before it: the base of a free chain, the
/// links, and but for pins the tip. The state is the joints' coordinates, then their rates:
///   pin   angle (rad) against the body before;
///   ball  quaternion x y z of the turn from the body before, and w behind all other coordinates;
///         rates are the relative spin (rad/s) in the body's own axes;
///   free  position (m) before the quaternion, velocity (m/s) before the spin.
/// A model's state lies in its own global variables, so that it serves one user at a time.
struct Model {
  int links = 0;
  Joints joints = Joints::pin;
  Formulation formulation = Formulation::order_n;
  void (*init)();
  void (*gravity)(double* g);                            // m/s^2
  void (*mass)(int body, double kg);                     // bodies count from 0; -1 is the ground
  void (*inertia)(int body, double (*i)[3]);             // kg m^2, about the centre of mass
  void (*to_joint)(int joint, double* arm);              // m, from its body's centre of mass
  void (*joint_on_inboard)(int joint, double* arm);      // m, from that body's centre of mass
  void (*push)(int body, double* point, double* force);  // while it integrates; body's axes
  void (*turn)(int from, double* vector, int to, double* turned);  // between bodies' axes
  /// Integrates over `dt` with steps of its own; `start` is 1 for a new motion.
  void (*motion)(double* time, double* state, double* rate, double dt, double constraint_tolerance,
                 double tolerance, int* start, int* failed);
  void (*error)(int* routine, int* number);  // of the last call that went wrong; 0: none
  void (*clear_error)();
};

/// The function that the integrating model calls at each instant (s), for forces beside gravity.
inline void (*forces)(double time) = nullptr;

/// Empty where the generator was not installed.
std::span<const Model> models();

}  // namespace taut::sdfast
