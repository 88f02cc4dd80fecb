// The schemes of the direct method converge at the orders that they are documented to have.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "sim/methods/direct/schemes/adams.h"
#include "sim/methods/direct/schemes/dop853.h"
#include "sim/methods/direct/schemes/rosenbrock.h"
#include "sim/methods/direct/system/system.h"

namespace taut::direct {
namespace {

constexpr double kUntil = 0.2;  // s

/// A chain of five links, let go from the horizontal, at so many rad/s about the vertical.
World chain(double spin) {
  World world;
  Connector chain = straight_connector("chain", 0.5, 0.05, 6, Vec3::Zero(), Vec3::UnitX());
  chain.holds = {{0, {}}};
  for (std::size_t i = 0; i < chain.particles(); ++i) {
    chain.velocity[i] = spin * Vec3::UnitY().cross(chain.position[i]);
  }
  world.connectors = {chain};
  finish(world);
  return world;
}

/// A world's motion with the arrays that steps take.
class Stepper {
 public:
  explicit Stepper(World world) : world_(std::move(world)) {
    const Component part = division_.divide(world_)[0];
    motion_.rebuild(world_, part, planes_.find(world_, part, 0, Vec3::Zero()));
    arena_.reset(3 + Dop853Step::kResults + Dop853Step::kWorkspace + AdamsStep::kArrays +
                     RosenbrockStep::kResults + RosenbrockStep::kWorkspace,
                 motion_.size());
    for (Slice* slice : {&q_, &rate_, &first_}) *slice = arena_.make();
    dop853_.make_results(arena_);
    dop853_.make_workspace(arena_);
    adams_.make_arrays(arena_);
    rosenbrock_.make_results(arena_);
    rosenbrock_.make_workspace(arena_);
    motion_.load(world_, 0, q_.data(), rate_.data());
  }

  template <typename Step>
  void single(Step& step, double h) {
    motion_.acceleration(time_, q_.data(), rate_.data(), first_.data());
    step.attempt(motion_, time_, h, q_.data(), rate_.data(), first_.data());
    finish(step, h);
  }
  void dop853(double h) { single(dop853_, h); }
  void rosenbrock(double h) { single(rosenbrock_, h); }
  /// Adams needs three steps before its first.
  void start_adams(double h) {
    const auto past = adams_.begin(h);
    for (std::size_t k = past.size(); k-- > 0;) {
      motion_.acceleration(time_, q_.data(), rate_.data(), past[k]);
      if (k > 0) dop853(h);
    }
  }
  void adams(double h) {
    adams_.attempt(motion_, time_, q_.data(), rate_.data(), 0);
    adams_.accept();
    finish(adams_, h);
  }

  /// Positions and velocities of the particles now.
  std::vector<Vec3> state() {
    world_.time = time_;
    motion_.store(world_, q_.data(), rate_.data());
    std::vector<Vec3> all = world_.connectors[0].position;
    const std::vector<Vec3>& velocity = world_.connectors[0].velocity;
    all.insert(all.end(), velocity.begin(), velocity.end());
    return all;
  }

 private:
  template <typename Step>
  void finish(Step& step, double h) {
    step.swap_result(q_, rate_);
    time_ += h;
    motion_.project(time_, q_.data(), rate_.data());
  }

  World world_;
  Division division_;
  PlaneFinder planes_;
  System motion_;
  Arena arena_;
  Dop853Step dop853_;
  AdamsStep adams_;
  RosenbrockStep rosenbrock_;
  Slice q_, rate_, first_;
  double time_ = 0;
};

enum class Scheme { dop853, adams, rosenbrock };

std::vector<Vec3> state_after(Scheme scheme, double spin, int steps) {
  Stepper stepper(chain(spin));
  const double h = kUntil / steps;
  int taken = 0;
  if (scheme == Scheme::adams) {
    stepper.start_adams(h);
    taken = 3;
  }
  for (; taken < steps; ++taken) {
    if (scheme == Scheme::dop853) stepper.dop853(h);
    if (scheme == Scheme::adams) stepper.adams(h);
    if (scheme == Scheme::rosenbrock) stepper.rosenbrock(h);
  }
  return stepper.state();
}

struct Case {
  Scheme scheme;
  int steps;     // the fewest
  double order;  // by which errors fall
};

class SchemeOrder : public testing::TestWithParam<Case> {};

// In the plane, where coordinates are angles, and in space, where they are directions; by two
// halvings of the step.
TEST_P(SchemeOrder, IsTheDocumentedOne) {
  const auto [scheme, steps, order] = GetParam();
  for (const double spin : {0.0, 3.0}) {
    SCOPED_TRACE(spin);
    const std::vector<Vec3> exact = state_after(Scheme::dop853, spin, 640);
    const auto error = [&](int n) {
      const std::vector<Vec3> state = state_after(scheme, spin, n);
      double sum = 0;
      for (std::size_t i = 0; i < state.size(); ++i) sum += (state[i] - exact[i]).squaredNorm();
      return std::sqrt(sum);
    };
    const double coarse = error(steps), middle = error(2 * steps), fine = error(4 * steps);
    EXPECT_NEAR(std::log2(coarse / middle), order, 0.5) << coarse << ' ' << middle;
    EXPECT_NEAR(std::log2(middle / fine), order, 0.5) << middle << ' ' << fine;
  }
}

std::string name_of(const testing::TestParamInfo<Case>& info) {
  constexpr const char* kNames[] = {"Dop853", "Adams", "Rosenbrock"};
  return kNames[static_cast<int>(info.param.scheme)];
}

INSTANTIATE_TEST_SUITE_P(, SchemeOrder,
                         testing::Values(Case{Scheme::dop853, 8, 8}, Case{Scheme::adams, 80, 4},
                                         Case{Scheme::rosenbrock, 160, 3}),
                         name_of);

}  // namespace
}  // namespace taut::direct
