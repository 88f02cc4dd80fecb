// The models that SD/FAST's generator wrote when taut was built.
#pragma once

#include <span>
#include <vector>

namespace taut::sdfast {

enum class Formulation { order_n, kane };

/// A planar chain of so many links. Its state is the angles of all links, each against the one
/// before (rad), and their rates. What a model knows lies in its own global variables, so that it
/// serves one user at a time.
struct Model {
  int links = 0;
  Formulation formulation = Formulation::order_n;
  void (*init)();
  void (*gravity)(double* g);                // m/s^2
  void (*mass)(int body, double kg);         // of the particle that ends link `body`, from 0
  void (*to_joint)(int joint, double* arm);  // m, from that particle to where its link begins
  /// Integrates over `dt` with steps of its own; `start` is 1 for a new motion.
  void (*motion)(double* time, double* state, double* rate, double dt, double constraint_tolerance,
                 double tolerance, int* start, int* failed);
  void (*error)(int* routine, int* number);  // of the last call that went wrong; 0: none
  void (*clear_error)();
};

/// Empty where the generator was not installed.
std::span<const Model> models();

}  // namespace taut::sdfast
