// The elastica under its own weight, by shooting.
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "sim/motion/types.h"

namespace taut::material_worlds {

/// EI theta'' = F x t with t = (cos theta, sin theta) and F' = (0, weight): F is what the part
/// ahead pulls with, weight that of a length. By Runge and Kutta's method over `length`.
struct HeavyElastica {
  double stiffness = 0, weight = 0, length = 0, slope = 0;  // slope: theta at the first end
  static constexpr int kSteps = 4400;

  using State = Eigen::Vector4d;  // theta, its derivative, x, y
  template <class Visit>
  void follow(const Vec3& unknown, Visit visit) const {  // theta' and F at the first end
    const double h = length / kSteps;
    const auto rate = [&](double s, const State& at) -> State {
      const double pull = unknown.z() + weight * s;
      const double moment = unknown.y() * std::sin(at[0]) - pull * std::cos(at[0]);
      return {at[1], moment / stiffness, std::cos(at[0]), std::sin(at[0])};
    };
    State at(slope, unknown.x(), 0, 0);
    visit(0, at);
    for (int i = 0; i < kSteps; ++i) {
      const double s = i * h;
      const State a = rate(s, at), b = rate(s + h / 2, at + h / 2 * a);
      const State c = rate(s + h / 2, at + h / 2 * b), d = rate(s + h, at + h * c);
      at += h / 6 * (a + 2 * (b + c) + d);
      visit(i + 1, at);
    }
  }
  Vec3 end(const Vec3& unknown) const {  // x, y, theta
    State last;
    follow(unknown, [&](int, const State& at) { last = at; });
    return {last[2], last[3], last[0]};
  }
};

}  // namespace taut::material_worlds
