#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/export/frame_writer.h"
#include "scenes/character/skeleton.h"
#include "scenes/format/document.h"

namespace taut::exporting {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// A rotation as turns about z, then x, then y of the axes as they have been turned (rad).
struct Turns {
  double z, x, y;
};

Turns turns_of(const Mat3& r) {
  const double x = std::asin(std::clamp(r(2, 1), -1.0, 1.0));
  if (std::abs(r(2, 1)) > 1 - 1e-12) return {std::atan2(r(1, 0), r(0, 0)), x, 0};
  return {std::atan2(-r(0, 1), r(1, 1)), x, std::atan2(-r(2, 0), r(2, 2))};
}

class BvhWriter final : public FrameWriter {
 public:
  BvhWriter(const scenes::Scene& scene, WriteBytes write)
      : write_(std::move(write)),
        performance_(performance_of(scene)),
        model_(*scene.stage->characters.front()),
        skeleton_(model_) {
    const scenes::Posture upright = skeleton_.upright();
    rest_ = skeleton_.poses(skeleton_.place(upright));
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < model_.bones.size(); ++i)
      if (model_.bones[i].parent < 0) roots.push_back(i);
    if (roots.size() != 1)
      scenes::fail_at(
          scene.file, {"characters"},
          fmt::format("the character's skeleton has {} roots, expected one for BVH", roots.size()));
    text_ = "HIERARCHY\n";
    describe(roots.front(), 0);
    text_ +=
        fmt::format("MOTION\nFrames: {}\nFrame Time: {:.9f}\n", scene.frames(), 1.0 / scene.fps);
    write_(text_);
  }

  int states_per_frame() const override { return 0; }

  void add(const ExportState& state) override {
    const std::vector<Pose> bones = performance_.bones_at(state.state.time);
    text_.clear();
    for (std::size_t k = 0; k < order_.size(); ++k) {
      const std::size_t i = order_[k];
      const int parent = model_.bones[i].parent;
      if (parent < 0) {
        const Vec3& p = bones[i].position;
        text_ += fmt::format("{:.7f} {:.7f} {:.7f}", p.x(), p.y(), p.z());
      }
      const Quat above = parent < 0 ? Quat::Identity() : turn(bones, std::size_t(parent));
      const Turns turns = turns_of((above.conjugate() * turn(bones, i)).toRotationMatrix());
      for (const double angle : {turns.z, turns.x, turns.y})
        text_ += fmt::format(" {:.6f}", angle / kDegree);
    }
    write_(text_ += '\n');
  }

  void finish() override {}

 private:
  static const scenes::Performance& performance_of(const scenes::Scene& scene) {
    const std::size_t count = scene.performances.size();
    if (count != 1)
      scenes::fail_at(scene.file, {"characters"},
                      fmt::format("has {} characters on its stage, expected one for BVH", count));
    return *scene.performances.front();
  }

  /// From the pose at rest to that of the bone.
  Quat turn(const std::vector<Pose>& bones, std::size_t i) const {
    return bones[i].rotation * rest_[i].rotation.conjugate();
  }

  void describe(std::size_t bone, std::size_t depth) {
    order_.push_back(bone);
    const std::string indent(2 * depth, ' ');
    const int parent = model_.bones[bone].parent;
    // The root's place is in its channels.
    const Vec3 offset = parent < 0
                            ? Vec3(Vec3::Zero())
                            : Vec3(rest_[bone].position - rest_[std::size_t(parent)].position);
    const auto offset_text = [](const Vec3& v) {
      return fmt::format("OFFSET {:.7f} {:.7f} {:.7f}\n", v.x(), v.y(), v.z());
    };
    text_ += fmt::format("{}{} {}\n{}{{\n{}  {}", indent, parent < 0 ? "ROOT" : "JOINT",
                         word(model_.bones[bone].name), indent, indent, offset_text(offset));
    text_ += fmt::format("{}  CHANNELS {}Zrotation Xrotation Yrotation\n", indent,
                         parent < 0 ? "6 Xposition Yposition Zposition " : "3 ");
    bool leaf = true;
    for (std::size_t i = bone + 1; i < model_.bones.size(); ++i)
      if (model_.bones[i].parent == int(bone)) {
        describe(i, depth + 1);
        leaf = false;
      }
    if (leaf) {
      // Readers draw the last bone to here: on in its parent's direction.
      constexpr double kLength = 0.03;  // m
      const Vec3 end =
          offset.norm() > 0 ? Vec3(kLength * offset.normalized()) : Vec3(0, kLength, 0);
      text_ += fmt::format("{}  End Site\n{}  {{\n{}    {}{}  }}\n", indent, indent, indent,
                           offset_text(end), indent);
    }
    text_ += indent + "}\n";
  }

  /// A name as one word.
  static std::string word(std::string name) {
    std::ranges::replace_if(
        name, [](unsigned char c) { return std::isspace(c) != 0; }, '_');
    return name;
  }

  WriteBytes write_;
  const scenes::Performance& performance_;
  const scenes::Model& model_;
  scenes::Skeleton skeleton_;
  std::vector<Pose> rest_;
  std::vector<std::size_t> order_;  // of the channels
  std::string text_;
};

}  // namespace

std::unique_ptr<FrameWriter> bvh_writer(const scenes::Scene& scene, WriteBytes write) {
  return std::make_unique<BvhWriter>(scene, std::move(write));
}

}  // namespace taut::exporting
