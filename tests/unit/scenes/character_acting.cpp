// The body's part in a hand's path: it prepares, follows late, breathes and blinks, and its face
// plays.
#include <gtest/gtest.h>

#include <cmath>

#include "scenes/character/acting.h"
#include "scenes/model/load_model.h"
#include "sim/motion/rotation.h"

namespace taut::character_acting {
namespace {

constexpr double start = 2.0, lasts = 0.20;  // s, of the hand's move

const scenes::Figure& figure() {
  static const scenes::Model model =
      scenes::load_model(TAUT_SOURCE_DIR "/assets/martial_artist.glb");
  static const scenes::Figure figure(model, 0.014);
  return figure;
}

/// A hand at ease that goes `way` and stays there.
Path move(const Vec3& way) {
  const Vec3 ease(-0.26, 1.06, 0.46);
  const Quat turn = rotation_between(Vec3::UnitY(), Vec3(-0.98, 0.17, 0).normalized());
  return Path({{0, ease, turn, true},
               {start, ease, turn, true},
               {start + lasts, ease + way, turn, true},
               {6, ease + way, turn, true}});
}

scenes::Track controls(const Path& path) {
  scenes::Track track = scenes::act(figure(), path, 6);
  scenes::look_about(figure(), path, track);
  scenes::play_face(figure(), path, track);
  return track;
}

/// A control as the hand's move changes it, breath taken off.
std::vector<double> change(scenes::Control control, const Vec3& way) {
  const scenes::Track moved = controls(move(way)), still = controls(move(Vec3::Zero()));
  std::vector<double> values;
  for (Eigen::Index i = 0; i < moved.count(); ++i)
    values.push_back(moved[i][control] - still[i][control]);
  return values;
}

/// When a control has made half of its way, later than the hand (s).
double lag(scenes::Control control, const Vec3& way) {
  const std::vector<double> values = change(control, way);
  const double half = values.back() / 2;
  for (std::size_t i = values.size(); i-- > 0;)
    if (values[i] / half < 1) return double(i + 1) / scenes::acting_rate - (start + lasts / 2);
  return INFINITY;
}

TEST(CharacterActing, TorsoShouldersAndHeadFollowTheHandLate) {
  const Vec3 aside(0.15, 0, 0), ahead(0, 0, 0.12), up(0, 0.15, 0);
  for (const auto& [control, way] : {std::pair{scenes::spine_yaw, aside},
                                     {scenes::pelvis_yaw, aside},
                                     {scenes::spine_tilt, aside},
                                     {scenes::spine_tilt, up},
                                     {scenes::spine_lean, ahead},
                                     {scenes::right_shoulder_up, up},
                                     {scenes::right_shoulder_forward, ahead},
                                     {scenes::guard_z, ahead},
                                     {scenes::head_yaw, aside},
                                     {scenes::head_lean, up}}) {
    EXPECT_GT(lag(control, way), 0.080) << control;
    EXPECT_LT(lag(control, way), 0.120) << control;
  }
}

/// Before the hand goes anywhere, weight and torso have gone the other way.
TEST(CharacterActing, TheBodyPreparesForAMove) {
  const auto before = [](scenes::Control control, const Vec3& way) {
    const std::vector<double> values = change(control, way);
    double most = 0;
    for (std::size_t i = 0; double(i) < start * scenes::acting_rate; ++i)
      most = std::max(most, -values[i] / values.back());
    return most;
  };
  EXPECT_GT(before(scenes::spine_yaw, Vec3(0.15, 0, 0)), 0.2);
  EXPECT_GT(before(scenes::pelvis_yaw, Vec3(0.15, 0, 0)), 0.2);
  EXPECT_GT(before(scenes::root_x, Vec3(0.15, 0, 0)), 0.2);
  EXPECT_GT(before(scenes::root_y, Vec3(0, 0.15, 0)), 0.2);  // it sinks before the hand rises
}

TEST(CharacterActing, AStillBodyBreathes) {
  const scenes::Track still = controls(move(Vec3::Zero()));
  double low = INFINITY, high = -INFINITY;
  std::vector<double> turns;  // s: when the shoulders are at their highest
  for (Eigen::Index i = 1; i + 1 < still.count(); ++i) {
    const auto at = [&](Eigen::Index k) { return still[k][scenes::left_shoulder_up]; };
    low = std::min(low, at(i));
    high = std::max(high, at(i));
    if (at(i) > at(i - 1) && at(i) >= at(i + 1)) turns.push_back(still.time(i));
  }
  EXPECT_GT(high - low, 0.01);  // rad
  EXPECT_LT(high - low, 0.06);
  ASSERT_GE(turns.size(), 2u);
  EXPECT_NEAR(turns[1] - turns[0], 3.7, 1.3);  // s: 12 to 25 breaths a minute
}

TEST(CharacterActing, TheLidsBlinkNowAndThen) {
  const scenes::Track track = controls(move(Vec3::Zero()));
  int blinks = 0, closed = 0;
  for (Eigen::Index i = 1; i < track.count(); ++i) {
    const double lid = track[i][scenes::lids];
    EXPECT_GE(lid, 0);
    EXPECT_LE(lid, 1);
    blinks += lid > 0.9 && track[i - 1][scenes::lids] <= 0.9;
    closed += lid > 0.5;
  }
  EXPECT_EQ(blinks, 2);  // in 6 s
  EXPECT_LT(closed / scenes::acting_rate, 0.5);
}

TEST(CharacterActing, TheFaceIsCalmThenStrainedThenFirm) {
  const scenes::Track track = controls(move(Vec3(0.3, 0.2, 0)));
  const auto at = [&](double time) { return track.at(time); };
  for (const scenes::Control control : {scenes::brows, scenes::frown, scenes::smile, scenes::jaw})
    EXPECT_NEAR(at(0.5)[control], 0, 1e-3) << control;
  EXPECT_GT(at(start)[scenes::frown], 0.8);
  EXPECT_LT(at(start)[scenes::brows], -0.4);
  EXPECT_GT(at(start)[scenes::jaw], 0.3);
  EXPECT_GT(at(5)[scenes::smile], 0.9);
  EXPECT_LT(at(5)[scenes::brows], -0.4);  // low: raised, they would say alarm
  EXPECT_GT(at(5)[scenes::frown], 0.2);
  EXPECT_LT(at(5)[scenes::frown], 0.5);
  for (Eigen::Index i = 1; i < track.count(); ++i) {  // no faster than a face can
    for (const scenes::Control control : {scenes::brows, scenes::frown, scenes::smile, scenes::jaw})
      EXPECT_NEAR(track[i][control], track[i - 1][control], 0.15) << control << ' ' << i;
  }
}

}  // namespace
}  // namespace taut::character_acting
