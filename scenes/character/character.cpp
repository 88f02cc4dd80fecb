#include "scenes/character/character.h"

#include <algorithm>
#include <mutex>

#include "scenes/character/acting.h"
#include "scenes/character/hanging_cloth.h"
#include "scenes/character/reach.h"

namespace taut::scenes {
namespace {

class Player : public Performance {
 public:
  Player(std::shared_ptr<const Model> model, const HeldStick& stick, double duration,
         const Path* head)
      : model_(std::move(model)),
        path_(stick.path),
        figure_(*model_, stick.diameter / 2),
        cues_(foresee(*path_, stick.free, duration)),
        controls_(act(figure_, *path_, duration, cues_)),
        duration_(duration),
        cloth_(*model_, figure_.skeleton()) {
    look_about(figure_, *path_, controls_, cues_);
    play_face(figure_, *path_, controls_, cues_);
    plan_arm(figure_, *path_, controls_);
    sink_to_the_feet(figure_, controls_);
    for (Eigen::Index i = 0; head && i < controls_.count(); ++i) {
      controls_.samples().col(i).segment<3>(head_yaw) += head->at(controls_.time(i)).position;
    }
  }

  std::vector<Pose> bones_at(double time) const override {
    Placement all = placed(time);
    std::call_once(has_cloth_, [&] {
      cloth_.simulate(duration_, acting_rate, [&](double t) { return placed(t); });
    });
    cloth_.hang(time, all);
    return figure_.skeleton().poses(all);
  }

  Pose limb_at(std::size_t bone, double time) const override {
    return figure_.skeleton().poses(placed(time)).at(bone);
  }

  /// How far the pelvis is from over its feet, beyond what a stance allows, and what the arm is
  /// short of even so.
  double beyond_reach(double time) const {
    constexpr double kStance = 0.45;  // m, of a figure of 1.78 m: a lunge
    const Controls c = controls_.at(time);
    const Vec3 pelvis(c[root_x], 0, c[root_z]);
    const Vec3 right(c[right_step_x], 0, c[right_step_z]), left(c[left_step_x], 0, c[left_step_z]);
    const Placement torso = figure_.skeleton().place(figure_.torso(c));
    const ArmState arm = figure_.right_arm(figure_.right_shoulder(torso), figure_.chest_turn(torso),
                                           path_->at(time).pose(), c[hand_roll], c[elbow_swivel]);
    const double off = (pelvis - (right + left) / 2).norm();
    return std::max(0.0, off - kStance * figure_.scale()) + arm.shortfall;
  }

 private:
  Placement placed(double time) const {
    return figure_.pose(controls_.at(time), path_->at(time).pose());
  }

  std::shared_ptr<const Model> model_;
  std::shared_ptr<const Path> path_;
  Figure figure_;
  Cues cues_;
  Track controls_;
  double duration_;  // s
  mutable std::once_flag has_cloth_;
  mutable HangingCloth cloth_;
};

}  // namespace

std::shared_ptr<const Performance> make_performance(std::shared_ptr<const Model> model,
                                                    const HeldStick& right_hand, double duration,
                                                    const Path* head) {
  return std::make_shared<Player>(std::move(model), right_hand, duration, head);
}

double beyond_reach(const Performance& performance, double time) {
  const auto* player = dynamic_cast<const Player*>(&performance);
  return player ? player->beyond_reach(time) : 0;
}

void check_figure(const Model& model, const HeldStick& right_hand) {
  Figure(model, right_hand.diameter / 2);
}

Path bone_path(const Performance& performance, std::size_t bone, double duration) {
  std::vector<PathKey> keys;
  for (int i = 0; keys.empty() || keys.back().time < duration; ++i) {
    const double time = i / acting_rate;
    const Pose pose = performance.limb_at(bone, time);
    keys.push_back({time, pose.position, pose.rotation});
  }
  return Path(std::move(keys));
}

}  // namespace taut::scenes
