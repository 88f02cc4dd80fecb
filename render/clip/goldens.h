// The records of a golden suite, checked against today and taken over from it.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "render/gl/context.h"
#include "render/golden/golden.h"
#include "render/golden/golden_trajectory.h"
#include "scenes/load/golden_suite.h"

namespace taut::clips {

/// The outcome of one picture.
struct FrameResult {
  golden::PictureComparison comparison;
  double distance = 0;  // m, of today's state from the kept one
  std::string failure;  // empty: as it should be
  std::optional<picture::Picture> actual, golden;
};

class Goldens {
 public:
  /// The suite in a folder, or what is named of it. Throws BadScene, Misuse, NoContext.
  Goldens(const std::filesystem::path& folder, const std::vector<std::string>& only,
          gl::Backend backend, int threads);
  ~Goldens();

  const std::vector<scenes::GoldenFrame>& frames() const { return suite_.frames; }
  const std::vector<scenes::GoldenTrajectory>& trajectories() const { return suite_.trajectories; }

  FrameResult check(const scenes::GoldenFrame& frame);
  golden::TrajectoryComparison check(const scenes::GoldenTrajectory& trajectory);

  /// Keeps today's picture or motion. Kept states stay while today's are `within` of them, unless
  /// `simulate` asks for today's. Says what changed.
  std::string accept(const scenes::GoldenFrame& frame, bool simulate);
  std::string accept(const scenes::GoldenTrajectory& trajectory, bool simulate);

 private:
  struct Set;
  void check_names(const std::vector<std::string>& names) const;
  std::filesystem::path file(const scenes::GoldenFrame& frame, const char* extension) const;
  std::filesystem::path file(const scenes::GoldenTrajectory& trajectory) const;
  bool is_kept(const scenes::GoldenFrame& frame) const;
  Set& set_of(const scenes::GoldenFrame& frame);

  scenes::GoldenSuite suite_;
  std::optional<gl::Context> context_;  // where there is a picture to draw
  std::string driver_;
  std::unique_ptr<Set> set_;
};

void write_picture(const std::filesystem::path& name, const picture::Picture& picture);
void write_text(const std::filesystem::path& name, std::string_view text);

}  // namespace taut::clips
