// What a golden suite keeps, checked against today and taken over from it.
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
#include "scenes/golden_suite.h"

namespace taut::cli {

/// What became of one picture.
struct FrameResult {
  PictureComparison comparison;
  double distance = 0;  // m, of today's state from the kept one
  std::string failure;  // empty: as it should be
  std::optional<Picture> actual, golden;
};

class Goldens {
 public:
  /// The suite in a folder, or what is named of it. Throws BadScene, Misuse, NoContext.
  Goldens(const std::filesystem::path& folder, const std::vector<std::string>& only,
          Backend backend, int threads);
  ~Goldens();

  const std::vector<GoldenFrame>& frames() const { return suite_.frames; }
  const std::vector<GoldenTrajectory>& trajectories() const { return suite_.trajectories; }

  FrameResult check(const GoldenFrame& frame);
  TrajectoryComparison check(const GoldenTrajectory& trajectory);

  /// Keeps what there is today; a frame's kept state stays unless `simulate` asks for another.
  /// Says what changed.
  std::string accept(const GoldenFrame& frame, bool simulate);
  std::string accept(const GoldenTrajectory& trajectory);

 private:
  struct Set;
  void keep_only(const std::vector<std::string>& names);
  std::filesystem::path file(const GoldenFrame& frame, const char* extension) const;
  std::filesystem::path file(const GoldenTrajectory& trajectory) const;
  bool is_kept(const GoldenFrame& frame) const;
  Set& set_of(const GoldenFrame& frame);

  GoldenSuite suite_;
  std::optional<Context> context_;  // where there is a picture to draw
  Renderer renderer_;
  std::unique_ptr<Set> set_;
};

void write_picture(const std::filesystem::path& name, const Picture& picture);
void write_text(const std::filesystem::path& name, std::string_view text);

}  // namespace taut::cli
