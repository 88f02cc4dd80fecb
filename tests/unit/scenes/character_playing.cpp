// The martial artist plays the demonstration: his body answers the free stick, his eyes follow it,
// he waits before he begins, and stands still in the end.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "scenes/character/acting.h"
#include "scenes/load/load_scene.h"
#include "sim/run/simulation.h"

namespace taut::character_playing {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kBegins = 2.4, kEnds = 5.8;    // s, of the figure-eight
constexpr double kSpins = 7.0, kHasSpun = 9.6;  // s
constexpr double kThrown = 12.9;                // s, before it strikes him
using Row = std::vector<double>;

double range(const Row& row) {
  const auto [least, most] = std::ranges::minmax(row);
  return most - least;
}

/// Pearson's coefficient of a[i] and b[i + shift].
double correlation(const Row& a, const Row& b, int shift = 0) {
  double n = 0, sa = 0, sb = 0, saa = 0, sbb = 0, sab = 0;
  for (int i = 0; i < int(a.size()); ++i) {
    const int k = i + shift;
    if (k < 0 || k >= int(b.size())) continue;
    const double x = a[std::size_t(i)], y = b[std::size_t(k)];
    n += 1, sa += x, sb += y, saa += x * x, sbb += y * y, sab += x * y;
  }
  return (n * sab - sa * sb) / std::sqrt((n * saa - sa * sa) * (n * sbb - sb * sb));
}

class Playing : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scene_ = new scenes::Scene(scenes::load_scene(TAUT_SOURCE_DIR "/scenes/nunchaku.toml", true));
    figure_ = new scenes::Figure(*scene_->stage->characters[0], 0.014);
    const Path& hand = *scene_->world.bodies[0].path;
    const scenes::FreeStick stick{.from = Vec3(0, 0.135, 0),
                                  .chain = 0.12,
                                  .chain_mass = 0.012,
                                  .mass = 0.12,
                                  .length = 0.30,
                                  .diameter = 0.028};
    cues_ = new scenes::Cues(scenes::foresee(hand, stick, scene_->duration));
    controls_ = new scenes::Track(scenes::act(*figure_, hand, scene_->duration, *cues_));
    scenes::look_about(*figure_, hand, *controls_, *cues_);
  }
  static void TearDownTestSuite() {
    delete controls_;
    delete cues_;
    delete figure_;
    delete scene_;
  }

  /// The values of a function of the time, 120 a second.
  template <typename Value>
  static Row over(double from, double until, Value value) {
    Row row;
    for (double time = from; time < until; time += 1 / scenes::acting_rate)
      row.push_back(value(time));
    return row;
  }
  static Row control(scenes::Control which, double from, double until) {
    return over(from, until, [&](double time) { return controls_->at(time)[which]; });
  }
  static scenes::Placement torso(double time) {
    return figure_->skeleton().place(figure_->torso(controls_->at(time)));
  }
  /// Yaw to the left, rad.
  static double yaw(const Quat& turn) {
    const Vec3 front = turn * Vec3::UnitZ();
    return std::atan2(front.x(), front.z());
  }
  static Row chest_yaw(double from, double until) {
    return over(from, until, [](double t) { return yaw(figure_->chest_turn(torso(t))); });
  }

  static scenes::Scene* scene_;
  static scenes::Figure* figure_;
  static scenes::Cues* cues_;
  static scenes::Track* controls_;
};
scenes::Scene* Playing::scene_ = nullptr;
scenes::Figure* Playing::figure_ = nullptr;
scenes::Cues* Playing::cues_ = nullptr;
scenes::Track* Playing::controls_ = nullptr;

TEST_F(Playing, TheFreeStickGoesWhereItIsForeseen) {
  Simulation simulation(scene_->world, make_method(scene_->method.name, scene_->method.settings));
  double most = 0;
  for (double time = 0.05; time < kThrown; time += 0.05) {
    simulation.advance_to(time);
    most = std::max(most, (std::as_const(simulation).world().bodies[1].frame().position -
                           Vec3(cues_->stick.at(time)))
                              .norm());
  }
  EXPECT_LT(most, 0.03);  // m, of a chain of eleven particles
}

TEST_F(Playing, HipsTurnAgainstShouldersThatComeLater) {
  const Row hips = control(scenes::pelvis_yaw, kBegins, kEnds), chest = chest_yaw(kBegins, kEnds);
  EXPECT_GT(range(hips), 8 * kDegree);
  EXPECT_GT(range(chest), 15 * kDegree);
  EXPECT_LT(correlation(hips, chest), -0.3);
  int lag = 0;  // samples, at which the chest does most nearly the opposite
  for (int shift = -30; shift <= 60; ++shift)
    if (correlation(hips, chest, shift) < correlation(hips, chest, lag)) lag = shift;
  EXPECT_GT(lag / scenes::acting_rate, 0.05);
  EXPECT_LT(lag / scenes::acting_rate, 0.40);
}

/// Along the line from the left foot, behind, to the right one.
TEST_F(Playing, WeightGoesFromFootToFootAndBackBeforeTheThrow) {
  const Vec3 left(0.20, 0, -0.25), right(-0.17, 0, 0.24), line = right - left;
  const auto weight = [&](double time) {
    const auto u = controls_->at(time);
    const Vec3 l = left + u.segment<3>(scenes::left_step_x);
    const Vec3 pelvis(u[scenes::root_x], 0, u[scenes::root_z]);
    return (pelvis - Vec3(l.x(), 0, l.z())).dot(line) / line.squaredNorm();
  };
  const Row eight = over(kBegins, kEnds, weight), spin = over(kSpins, kHasSpun - 0.4, weight);
  EXPECT_GT(range(eight), 0.15);
  const double in_eight = std::accumulate(eight.begin(), eight.end(), 0.0) / double(eight.size());
  const double in_spin = std::accumulate(spin.begin(), spin.end(), 0.0) / double(spin.size());
  EXPECT_LT(in_spin, in_eight - 0.05) << "he braces himself";
  const Row wind = over(12.0, 12.6, weight);
  EXPECT_LT(*std::ranges::min_element(wind), weight(11.9) - 0.08);
}

TEST_F(Playing, KneesSinkAndRiseWithTheStick) {
  const Row height =
      over(kBegins, kEnds, [](double t) { return controls_->at(t)[scenes::root_y]; });
  const Row stick = over(kBegins, kEnds, [](double t) { return cues_->stick.at(t)[1]; });
  EXPECT_GT(range(height), 0.02);
  EXPECT_GT(correlation(height, stick), 0.4);
}

TEST_F(Playing, TheIdleHandBalancesTheStick) {
  Vec3 last = controls_->at(kBegins).segment<3>(scenes::guard_x);
  double way = 0;
  for (double time = kBegins; time < kEnds; time += 1 / scenes::acting_rate) {
    const Vec3 now = controls_->at(time).segment<3>(scenes::guard_x);
    way += (now - last).norm();
    last = now;
  }
  EXPECT_GT(way, 1.0);  // m, against the chest, in two laps
  const Row aside = control(scenes::guard_x, kBegins, kEnds);
  const Row stick = over(kBegins, kEnds, [](double t) { return cues_->stick.at(t)[0]; });
  EXPECT_LT(correlation(aside, stick), -0.5);
}

/// In the figure-eight and in the spin, 80 ms ahead of the stick.
TEST_F(Playing, TheEyesFollowTheStickALittleAheadOfIt) {
  const scenes::Track stick = cues_->stick.smoothed(0.05);
  const auto off = [&](double time) {
    const scenes::Placement placed = torso(time);
    const std::size_t head = figure_->head_bone();
    const auto u = controls_->at(time);
    const Vec3 from = placed.position[head] + placed.turn[head] * figure_->between_eyes();
    const Vec3 look =
        placed.turn[head] * (Eigen::AngleAxisd(u[scenes::eye_yaw], Vec3::UnitY()) *
                             Eigen::AngleAxisd(u[scenes::eye_lean], Vec3::UnitX()) * Vec3::UnitZ());
    const Vec3 there = (Vec3(stick.at(time + 0.08)) - from).normalized();
    return std::acos(std::min(1.0, there.dot(look))) / kDegree;
  };
  for (const auto& [from, until] : {std::pair{kBegins, kEnds}, {kSpins, kHasSpun}}) {
    const Row error = over(from, until, off);
    EXPECT_LT(std::accumulate(error.begin(), error.end(), 0.0) / double(error.size()), 6);
    EXPECT_LT(*std::ranges::max_element(error), 15);
  }
}

TEST_F(Playing, HeLooksAfterTheStickWithOpenEyes) {
  scenes::Track face = *controls_;
  scenes::play_face(*figure_, *scene_->world.bodies[0].path, face, *cues_);
  for (double time = kThrown; time < cues_->rests + 0.1; time += 0.02) {
    EXPECT_LT(face.at(time)[scenes::lids], 0.05) << time;
    EXPECT_LT(face.at(time)[scenes::eye_lean], 0.05) << time;  // rad: no lid goes along
  }
  const scenes::Placement placed = torso(cues_->rests);
  const double eyes = controls_->at(cues_->rests)[scenes::eye_yaw];
  const double looks = yaw(placed.turn[figure_->head_bone()]) + eyes;
  EXPECT_LT(looks - yaw(figure_->chest_turn(placed)), -60 * kDegree);  // over the right shoulder
}

TEST_F(Playing, HeWaitsAndDoesNotBlink) {
  EXPECT_GT(cues_->begins, 1.2);
  for (const double lid : control(scenes::lids, 0, 2)) EXPECT_EQ(lid, 0);
  const Row shoulder = control(scenes::left_shoulder_up, 0, 1.2);
  EXPECT_GT(range(shoulder), 0.015);  // rad: he breathes in
  // The fist is raised, and he sinks into his stance, before the hand moves.
  const auto first = controls_->at(0), ready = controls_->at(cues_->begins);
  EXPECT_GT(ready[scenes::guard_y] - first[scenes::guard_y], 0.1);
  EXPECT_LT(ready[scenes::root_y] - first[scenes::root_y], -0.02);
}

TEST_F(Playing, HeBowsAndThenHoldsStill) {
  const Row lean = control(scenes::head_lean, cues_->rests, scene_->duration);
  EXPECT_GT(range(lean), 15 * kDegree);
  EXPECT_LT(std::abs(lean.back() - lean.front()), 12 * kDegree);
  const scenes::Placement last = torso(scene_->duration);
  // He breathes 0.27 times a second, which moves no bone by more than 20 mm to either side.
  const double fastest = 2 * std::numbers::pi * 0.27 * 0.020;  // m/s
  for (double time = scene_->duration - 0.25; time < scene_->duration - 0.01; time += 0.05) {
    const scenes::Placement now = torso(time);
    for (std::size_t bone = 0; bone < last.position.size(); ++bone)
      EXPECT_LT((now.position[bone] - last.position[bone]).norm(),
                fastest * (scene_->duration - time))
          << bone;
  }
  const auto held = controls_->at(scene_->duration);
  EXPECT_LT(held[scenes::guard_x], 0.06) << "the left fist is before the chest";
}

}  // namespace
}  // namespace taut::character_playing
