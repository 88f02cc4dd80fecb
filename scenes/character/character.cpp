#include "scenes/character/character.h"

#include "scenes/character/acting.h"
#include "scenes/character/tails.h"

namespace taut {
namespace {

class Player : public Performance {
 public:
  Player(std::shared_ptr<const Model> model, const HeldStick& stick, double duration,
         const Path* head)
      : model_(std::move(model)),
        path_(stick.path),
        figure_(*model_, stick.diameter / 2),
        controls_(act(figure_, *path_, duration)),
        tails_(figure_.skeleton()) {
    look_about(figure_, *path_, controls_);
    plan_arm(figure_, *path_, controls_);
    for (Eigen::Index i = 0; head && i < controls_.count(); ++i) {
      controls_.samples().col(i).segment<3>(head_yaw) += head->at(controls_.time(i)).position;
    }
    swing_ = tails_.swing(duration, acting_rate, [&](double time) { return placed(time); });
  }

  std::vector<Pose> bones_at(double time) const override {
    Placement all = placed(time);
    tails_.hang(swing_.at(time), all);
    return figure_.skeleton().poses(all);
  }

 private:
  Placement placed(double time) const {
    return figure_.pose(controls_.at(time), path_->at(time).pose());
  }

  std::shared_ptr<const Model> model_;
  std::shared_ptr<const Path> path_;
  Figure figure_;
  Track controls_;
  Tails tails_;
  Track swing_{Eigen::MatrixXd::Zero(0, 1), acting_rate};
};

}  // namespace

std::shared_ptr<const Performance> make_performance(std::shared_ptr<const Model> model,
                                                    const HeldStick& right_hand, double duration,
                                                    const Path* head) {
  return std::make_shared<Player>(std::move(model), right_hand, duration, head);
}

void check_figure(const Model& model, const HeldStick& right_hand) {
  Figure(model, right_hand.diameter / 2);
}

Path bone_path(const Performance& performance, std::size_t bone, double duration) {
  std::vector<PathKey> keys;
  for (int i = 0; keys.empty() || keys.back().time < duration; ++i) {
    const double time = i / acting_rate;
    const Pose pose = performance.bones_at(time).at(bone);
    keys.push_back({time, pose.position, pose.rotation});
  }
  return Path(std::move(keys));
}

}  // namespace taut
