// Worlds with connectors that stretch, bend or meet the air: the scheme of each part.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "sim/methods/direct/integrator.h"
#include "sim/methods/direct/schemes/radau_step.h"
#include "sim/run/method.h"

namespace taut::direct {

/// Follows each such connector by RadauStep, for nothing couples it with the rest of the world, and
/// the rest as if they were not there. Steps follow from the tolerance by the step's own estimate.
class Elastic {
 public:
  /// `make` makes what follows the rest.
  Elastic(const StepOptions& options, std::function<std::unique_ptr<Method>()> make);

  /// Call when the world's topology is new. Throws Diverged where such a connector holds a free
  /// body, or where there is contact.
  void prepare(const World& world);
  void advance(World& world, double until);
  Counters counters() const;

 private:
  struct Part {
    std::size_t connector = 0;        // of the world
    std::vector<std::size_t> bodies;  // driven, of the world
    World world;
    RadauStep step;
    bool known = false;  // the steps' state is that of `world`
    double h = 0;        // s, of the next step; zero: not known
  };
  void follow(Part& part, double until);
  double first_step(const Part& part) const;
  double allowed(const Part& part, double h) const;
  double left_open(const Part& part, double h) const;
  [[noreturn]] void give_up(Part& part) const;

  StepOptions options_;
  std::unique_ptr<Method> rest_method_;
  World rest_;
  std::vector<std::size_t> rest_connectors_;
  std::vector<std::unique_ptr<Part>> parts_;
  Counters counters_;
};

}  // namespace taut::direct
