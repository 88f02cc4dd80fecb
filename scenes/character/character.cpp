#include "scenes/character/character.h"

#include "scenes/character/acting.h"

namespace taut {
namespace {

class Player : public Performance {
 public:
  Player(std::shared_ptr<const Model> model, const HeldStick& stick, double duration)
      : model_(std::move(model)),
        path_(stick.path),
        figure_(*model_, stick.diameter / 2),
        controls_(act(figure_, *path_, duration)) {
    plan_arm(figure_, *path_, controls_);
  }

  std::vector<Pose> bones_at(double time) const override {
    const Controls controls = controls_.at(time);
    return figure_.skeleton().poses(figure_.pose(controls, path_->at(time).pose()));
  }

 private:
  std::shared_ptr<const Model> model_;
  std::shared_ptr<const Path> path_;
  Figure figure_;
  Track controls_;
};

}  // namespace

std::shared_ptr<const Performance> make_performance(std::shared_ptr<const Model> model,
                                                    const HeldStick& right_hand, double duration) {
  return std::make_shared<Player>(std::move(model), right_hand, duration);
}

}  // namespace taut
